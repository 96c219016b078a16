"""Where an item can be set down from the front: free floor, level, at the back and beside a wall.

The item keeps the way it stands, so that whatever can hold it where it is can set it down there. It must keep
its balance there, and what can roll must lie on level ground.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np

from pickcli.cell.place import Place
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.stage_contacts import while_resting_on
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.supports import supports_of

STEP = 0.02  # m between spots that are tried
FROM_MOUTH = 0.03  # m that stay free behind the mouth: the lips are 20 mm deep
HOVER = 0.001  # m over the floor, on top of how much lower the item may be than its pose says
N_EXPLAINED = 16  # about, of the spots where none is free
LEAST_SLENDERNESS = 0.35  # narrowest side of the base over the height: what is thinner falls over


def floor_placements(
    context: PlanningContext,
    scene: Scene,
    placed: PlacedItem,
    R_place_item: Array,
    place: Place,
    n_most: int = 8,
) -> tuple[PlacedItem, ...] | Failures:
    """Find where on the floor of a place an item could be let go.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived.
        placed: The item where it is now.
        R_place_item: (3, 3) how it is to stand, before it is levelled.
        place: Where it is brought.
        n_most: Most placements.

    Returns:
        The item at each placement, the best first; or why there is none.
    """
    R = _levelled(R_place_item)
    reach = placed.item.shape.reach(R)
    if 2 * float(reach[:2].min()) < LEAST_SLENDERNESS * 2 * float(reach[2]):
        size = " x ".join(f"{2e3 * e:.0f}" for e in reach)
        return Failures.of(Reason("would fall over", place.name, f"{placed.id} stands {size} mm"))
    T_world_place = scene.T_world_place(place)
    uncertainty = scene.noise.bound(placed.item)
    free = FreeItem(placed.item, T_world_place @ pose(R=R), T_world_place[:3, :3], uncertainty)
    flying = FreeItemChecker(context.model, scene, free, while_resting_on(place.support, placed.id))
    spots = _spots(place, reach, uncertainty + HOVER)
    fitting = [_placed(placed, place.name, T_world_place, R, d) for d in spots if flying.is_valid(d)]
    if not fitting:
        return _occupied(place, spots, flying)
    staying = tuple(islice((spot for spot in fitting if _stays(scene, spot)), n_most))
    rolling = Reason("would fall over or roll", place.name, f"{placed.id} on all free places")
    return staying or Failures.of(rolling)


def _occupied(place: Place, spots: Array, flying: FreeItemChecker) -> Failures:
    """What stands on some of the spots (K, 6), none of which is free."""
    what, tried = "no free place on the floor", f"{len(spots)} places tried"
    met = [flying.clearance(d) for d in spots[:: 1 + len(spots) // N_EXPLAINED]]
    if not met:
        return Failures.of(Reason(what, place.name, tried))
    told = [(f"{contact.with_distance(flying.margin)}, {tried}", contact.item) for contact in met]
    return Failures(tuple(Reason(what, place.name, detail, item) for detail, item in told))


def _stays(scene: Scene, spot: PlacedItem) -> bool:
    """Whether an item stays where it is let go, as poses may be off."""
    beside = (p for p in scene.in_location(spot.location) if p.id != spot.id)
    supports = supports_of(replace(scene, items=(*beside, spot)))
    return supports.stays(spot.id) or supports.lies_level(spot.id)


def _levelled(R: Array) -> Array:
    """The least turn away from R (3, 3) that makes the item's most vertical axis vertical."""
    axis = int(np.argmax(np.abs(R[2])))
    up = np.sign(R[2, axis]) * np.array([0.0, 0.0, 1.0])
    across = np.cross(R[:, axis], up)
    sine = float(np.linalg.norm(across))
    if sine < 1e-9:
        return R
    return np.asarray(rotation_axis_angle(across / sine, float(np.arcsin(min(sine, 1.0)))) @ R)


def _spots(place: Place, half: Array, hover: float) -> Array:
    """(K, 6) displacements from the place's origin to spots on its floor, as of a free flyer.

    As far back and as near a wall as possible first. half: (3,) of the box around the item, level
    """
    low, high = place.room.y_range
    along_x = _grid(FROM_MOUTH + half[0], place.room.depth - half[0])
    along_y = _grid(low + half[1], high - half[1])
    x, y = (axis.ravel() for axis in np.meshgrid(along_x, along_y, indexing="ij"))
    height, pitch = place.room.rest(x, half[0])
    # An item that hovers over the floor, parallel to what it will lie on.
    above = half[2] + hover
    none = np.zeros(len(x))
    at = (x + above * np.sin(pitch), y, height + above * np.cos(pitch), none, pitch, none)
    cost = place.room.depth - x + np.minimum(y - along_y.min(initial=0.0), along_y.max(initial=0.0) - y)
    return np.column_stack(at)[np.argsort(cost, kind="stable")]


def _grid(low: float, high: float) -> Array:
    return np.linspace(low, high, int((high - low) / STEP) + 1) if high >= low else np.zeros(0)


def _placed(placed: PlacedItem, place_name: str, T_world_place: Array, R: Array, d: Array) -> PlacedItem:
    pitched = rotation_axis_angle((0.0, 1.0, 0.0), float(d[4])) @ R
    return replace(placed, location=place_name, T_world_item=T_world_place @ pose(d[:3], R=pitched))
