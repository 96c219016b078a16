"""Decide whether an item that is let go stays where it lands: what carries it, and what it leans on.

Independent of the planner, by the verifier's own model of the pile.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.geometry import Array
from pickcli.scene.scene import Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.body_boxes import BodyBoxes
from pickcli.verification.contact_pile import CARRYING_NORMAL_Z, WEIGHT_TOLERANCE, body_of, pile_at
from pickcli.verification.equilibrium import RigidBody
from pickcli.verification.separation import support

FOOTING_NORMAL_Z = np.sin(np.radians(45.0))  # vertical part from which on an item lies on it, and leans not
ALIKE = 0.5  # cosine of the angle between normals from which on contacts push the same way
N_EDGES = 36  # horizontal directions in which the edge of what carries an item is looked for
_UP = np.array([0.0, 0.0, 1.0])


def keeps_standing(scene: Scene, item_id: str) -> bool:
    """Whether an item keeps its balance where it is, if everything that it touches is fixed.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        True if it may.
    """
    pile = pile_at(scene, scene.find(item_id).location)
    return bool(pile.missing_alone(item_id).max() <= WEIGHT_TOLERANCE) or pile.lies_level(item_id)


def fall_onto_others(scene: Scene, item_id: str) -> float:
    """Return how far an item falls until it meets another one of its place.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        m between its lowest point and the highest of the boxes of items that it is wholly above, within the
        errors of poses; infinite without any.
    """
    placed = {each.id: each for each in scene.in_location(scene.find(item_id).location)}
    item = body_of(scene, placed.pop(item_id))
    boxes = BodyBoxes.around((item, *(body_of(scene, each) for each in placed.values())))
    is_under = np.all((boxes.low < boxes.high[0])[:, :2] & (boxes.high > boxes.low[0])[:, :2], axis=1)
    falls = boxes.low[0, 2] - boxes.high[:, 2]
    least = [-TOUCH - item.bound - other.bound for other in boxes.bodies]
    return float(np.min(falls, where=is_under & (falls >= least), initial=np.inf))


def tips_as_it_lands(scene: Scene, item_id: str) -> bool:
    """Whether an item that is carried by others only may turn over their edge as it falls onto them.

    It first meets one edge of what carries it, in an inelastic blow, and all energy that this leaves goes
    into the turn over the opposite edge.

    Args:
        scene: The scene, with the item where it is let go.
        item_id: Id of the item.

    Returns:
        True if that energy lifts its centre over an edge.
    """
    pile = pile_at(scene, scene.find(item_id).location)
    body = pile.bodies[item_id]
    below = [c.b for c in pile.touching[item_id] if c.normal[2] >= CARRYING_NORMAL_Z]
    if not below or any(other.is_firm for other in below):
        return False
    fall = max(fall_onto_others(scene, item_id), 0.0)
    x, y, z = 2.0 * body.shape.reach(body.T[:3, :3])
    turns = 2.0 * np.pi * np.arange(N_EDGES) / N_EDGES
    for way in np.column_stack([np.cos(turns), np.sin(turns), np.zeros(N_EDGES)]):
        edge, arm = (_reach_of(below, body, w) for w in (way, -way))
        rise = np.sqrt(max(edge, 0.0) ** 2 + z**2 / 4) - z / 2
        if rise < arm**2 / (arm**2 + (min(x, y) ** 2 + z**2) / 12) * fall:
            return True
    return False


def leans_too_low(scene: Scene, item_id: str) -> bool:
    """Whether an item stays only by leaning on what is lower than its centre.

    Forces that hold it there may exist, but as it falls against an edge below its centre, that goes on beyond
    the edge, and its lower end slides the other way. What can roll does not fall over what it is chocked by.

    Args:
        scene: The scene, with the item where it is let go.
        item_id: Id of the item.

    Returns:
        True if it would not stay without those things that it leans on and that are lower than its centre.
    """
    pile = pile_at(scene, scene.find(item_id).location)
    body, contacts = pile.bodies[item_id], pile.touching[item_id]
    if item_id in pile.rollers:
        return False
    centre = body.T[2, 3] + body.bound
    footing = [c for c in contacts if c.normal[2] >= FOOTING_NORMAL_Z]
    beside = [c for c in contacts if c.normal[2] < FOOTING_NORMAL_Z]
    is_low = [support(c.b.shape, c.b.T, _UP)[2] - c.b.bound < centre for c in beside]
    low = [c for c, less in zip(beside, is_low, strict=True) if less]
    high = [c for c, less in zip(beside, is_low, strict=True) if not less]
    # What is high holds it up only on the side to which it leans.
    holding = footing + [c for c in high if any(c.normal @ other.normal > ALIKE for other in low)]
    if not low:
        return False
    without = replace(pile, touching={**pile.touching, item_id: holding})
    return bool(without.missing_alone(item_id).max() > WEIGHT_TOLERANCE)


def _reach_of(below: Sequence[RigidBody], body: RigidBody, way: Array) -> float:
    """Return how far in m along a horizontal direction bodies carry another one, from below its centre."""
    own, *others = (float(way @ (support(b.shape, b.T, way) - body.T[:3, 3])) for b in (body, *below))
    return min(own, max(others))


def is_borne(scene: Scene, item_id: str) -> bool:
    """Whether the items below an item keep their balance with it on them: all of these at once.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        True if they may, or if no items are below it.
    """
    pile = pile_at(scene, scene.find(item_id).location)
    below = pile.carrying(item_id)
    with_it = pile.missing(below | {item_id}) if below else {}
    before = pile.without(item_id).missing(below)
    return all(
        bool((less <= before.get(name, 0.0) + WEIGHT_TOLERANCE).all()) for name, less in with_it.items()
    )
