"""Poses of the tool at a push that topples an item: against its side, or by friction on its upper side.

From beside, the cup comes down next to the item and pushes its upper part. From above, the relaxed cup is
pressed on its upper side and turns with it about the lower edge; the press holds that edge on the floor, so
that neither a wall beside the item nor its width matters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from pickcli.cartesian.key_waypoints import PREAPPROACH_DISTANCE
from pickcli.cartesian.line import shifted
from pickcli.cell.place import Place
from pickcli.geometry import GRAVITY, Array, pose, rotation_axis_angle
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.statics.toppling import Topple

BENDS = 0.004  # m of the cup, besides the stroke of its bellows, that bends aside at the item
BESIDE = 0.003  # m between tip and item before the push, besides clearance and errors: spheres cover the cup
ABOVE = 0.005  # m between tip and item before it is pressed, likewise
LEAST_BELOW_TOP = 0.002  # m that are left of it as the push rises
RISING_TILTS = np.radians((20.0, 16.0, 12.0, 8.0, 4.0, 0.0))  # rad, tilts up to which the push rises
ABOVE_RIM = 0.06  # m from the rim up to the tip, at the start of the way in
ASIDE = (0.0, 0.2, -0.2)  # shares of the item's width by which the tip is off its middle
N_TURNS = 8  # turns of the tool about its axis
TURN_STEP = np.radians(12.0)  # rad, largest turn in one line: 0.3 mm off the arc of an item 60 mm high
LEAST_PRESS = 0.0005  # m by which the bellows are surely pressed, and do not reach the end of their stroke
FOLLOWED = 0.012  # m that the cup goes on level after the turn: the item turns a little less than the cup
TURNED_LESS = np.radians((0.0, 14.0))  # rad that the cup turns less, and goes on level for, if it has no room
INSIDE = (1.0, 0.5)  # of the way that the tip is inside of the upper side; beside a wall it may hang over
MOST_PULL = 0.4  # of the press, that friction is taken to bear; a lip on cardboard has 0.5 and more
DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])


@dataclass(frozen=True, eq=False)
class PushPoses:
    """Poses (4, 4) of the tool in the world.

    Attributes:
        above: At the start of the way in, over the box or in front of the mouth of a bin.
        first: At its end, clear of the item.
        pushes: At the ends of the lines of the push.
        out: At the ends of the lines of the way out.
    """

    above: Array
    first: Array
    pushes: tuple[Array, ...]
    out: tuple[Array, ...]


def poses_from_beside(scene: Scene, place: Place, push: Topple) -> Iterator[PushPoses]:
    """Find poses of a push against the upper part of an item's side.

    Args:
        scene: The scene.
        place: The box.
        push: The push.

    Yields:
        The poses, with the push through the middle of the item first; none if a push would slide it.
    """
    if push.sliding:
        return
    grip, clearance = scene.cell.robot.tool.grip, scene.cell.clearance
    pushed_at = push.highest
    height = pushed_at - grip.gives_way - BENDS
    begin = push.near_side(height) - grip.tip_radius - clearance - push.bound - BESIDE
    rising, level = _ways(push, pushed_at, begin + grip.tip_radius)
    if not np.isfinite(level).all():
        return
    # It rises already before it meets the item, at the height meant.
    rise = float(rising[2]) / max(float(rising @ push.direction), 1e-9)
    lower = rise * (push.near_side(pushed_at) - begin - grip.tip_radius)
    across = np.cross([0.0, 0.0, 1.0], push.direction)
    placed = scene.find(push.item)
    width = float(np.abs(across @ placed.T_world_item[:3, :3]) @ placed.item.shape.extents)
    above = max(height_of_rim(scene, place), height) + ABOVE_RIM - height + lower
    for share, R in product(ASIDE, tool_turns(DOWN)):
        aside = (push.centre @ across + share * width) * across
        first = pose(aside + begin * push.direction + np.array([0.0, 0.0, height - lower]), R=R)
        risen, end = (shifted(first, way) for way in (rising, rising + level))
        up = np.array([0.0, 0.0, above])
        out = shifted(end, up - np.array([0.0, 0.0, rising[2]]))
        yield PushPoses(shifted(first, up), first, (risen, end), (out,))


def _ways(push: Topple, height: float, begin: float) -> tuple[Array, Array]:
    """Return the ways (3,) m of the push: up along the item until it tilts, then level until it falls.

    The weight turns the item back most at the start. A straight line cannot follow the pushed face, which
    rises less the more it tilts.

    height: m in the world, of the pushed point. begin: m along the push, of the tool's side
    """
    slope = push.slope(height)
    for tilt in RISING_TILTS:
        rise = push.travel(height, slope, tilt) if tilt > 0.0 else 0.0
        top = push.top(tilt) - push.bound - LEAST_BELOW_TOP
        if height + slope * rise <= top or tilt == 0.0:
            break
    rising = push.near_side(height) - begin + rise if rise > 0.0 else 0.0
    level = push.near_side(height + slope * rise, push.tilt) - begin - rising + push.bound
    up = np.array([0.0, 0.0, slope * rising])
    return rising * push.direction + up, level * push.direction


def poses_from_above(scene: Scene, place: Place, push: Topple) -> Iterator[PushPoses]:
    """Find poses of a cup that is pressed on an item's upper side, and turns with it about its lower edge.

    Args:
        scene: The scene.
        place: The box.
        push: The push.

    Yields:
        The poses, with the cup in the middle of the item's width first; none if the cup could slide on it,
        or if the errors of the pose are larger than half the stroke of its bellows.
    """
    grip, placed = scene.cell.robot.tool.grip, scene.find(push.item)
    press, inside = grip.gives_way / 2.0, min(grip.tip_radius, _depth(push, placed) / 2.0)
    # Moments about the edge: friction bears the weight, and the press inside of the edge. The part of the lip
    # that hangs over does not press.
    of_weight = push.mass * GRAVITY * push.lever / (grip.stiffness * press)
    pulls = {part: MOST_PULL * (1.0 + part) / 2.0 * _height(push) for part in INSIDE}
    parts = [part for part, pull in pulls.items() if of_weight + part * inside <= pull]
    R_item, axis = placed.T_world_item[:3, :3], np.cross([0.0, 0.0, 1.0], push.direction)
    up, ahead = _outwards(R_item, push.upper), -_outwards(R_item, push.face)
    across = np.cross(up, ahead)
    extents = placed.item.shape.extents
    width = float(np.abs(across @ R_item) @ extents)
    off = np.array([_height(push) + push.bound, _depth(push, placed)]) / 2.0
    beside = np.abs(ASIDE) * width + grip.tip_radius
    errors = scene.noise_of(placed).at(np.hypot(np.linalg.norm(off), beside)).tolist()
    shares = [share for share, error in zip(ASIDE, errors, strict=True) if press >= error + LEAST_PRESS]
    top = placed.T_world_item[:3, 3] + extents["xyz".index(push.upper[1])] / 2.0 * up
    top = top + (_depth(push, placed) / 2.0) * ahead
    edge = push.edge[0] * push.direction + np.array([0.0, 0.0, push.edge[1]])
    before = scene.cell.clearance + push.bound + ABOVE
    turns = tuple(tool_turns(np.column_stack([across, np.cross(-up, across), -up])))
    for part, less, share, R in product(parts, TURNED_LESS, shares, turns):
        pressed = pose(top - part * inside * ahead + share * width * across - press * up, R=R)
        tilts = np.linspace(0.0, push.tilt - less, int(np.ceil((push.tilt - less) / TURN_STEP)) + 1)[1:]
        turned = [_about(edge, axis, float(tilt)) @ pressed for tilt in tilts]
        turned.append(shifted(turned[-1], (FOLLOWED + less * _height(push)) * push.direction))
        first = shifted(pressed, (press + before) * up)
        if not place.access.is_from_above:
            lifted = shifted(turned[-1], np.array([0.0, 0.0, before]))
            outside, out = (_in_front(scene, place, T, across) for T in (first, lifted))
            yield PushPoses(outside, first, (pressed, *turned), (lifted, out))
            continue
        over = max(height_of_rim(scene, place) + ABOVE_RIM - pressed[2, 3], before)
        leaving = np.array([0.0, 0.0, over + pressed[2, 3] - turned[-1][2, 3]])
        out = shifted(turned[-1], leaving)
        yield PushPoses(shifted(pressed, over * up), first, (pressed, *turned), (out,))


def _in_front(scene: Scene, place: Place, T: Array, along: Array) -> Array:
    """Return a pose (4, 4) of the tool moved straight out of a bin, to in front of its mouth.

    It moves along the upper side (3,) of the item, which slopes with the floor.
    """
    T_world_entry = scene.T_world_place(place) @ place.T_place_entry
    inwards = T_world_entry[:3, 0]
    depth = float((T[:3, 3] - T_world_entry[:3, 3]) @ inwards)
    return shifted(T, -max(0.0, depth + PREAPPROACH_DISTANCE) / float(along @ inwards) * along)


def _height(push: Topple) -> float:
    """Return how high over its edge an item surely reaches, m."""
    return float(push.top(0.0) - push.bound - push.edge[1])


def _depth(push: Topple, placed: PlacedItem) -> float:
    """Return the extent of an item along the push, m."""
    return float(placed.item.shape.extents["xyz".index(push.face[1])])


def _outwards(R: Array, face: str) -> Array:
    """Return the outward normal (3,) of a face of a box with the rotation R (3, 3)."""
    return np.asarray(R[:, "xyz".index(face[1])] * (1.0 if face[0] == "+" else -1.0))


def _about(point: Array, axis: Array, angle: float) -> Array:
    """Return the displacement (4, 4) that turns by an angle in rad about an axis through a point."""
    R = rotation_axis_angle(axis, angle)
    return pose(point - R @ point, R=R)


def tool_turns(R: Array) -> Iterator[Array]:
    """Turn the tool about its axis.

    Args:
        R: (3, 3) its rotation.

    Yields:
        (3, 3) rotations, the given one first.
    """
    for k in range(N_TURNS):
        yield R @ rotation_axis_angle((0.0, 0.0, 1.0), -2.0 * np.pi * k / N_TURNS)


def height_of_rim(scene: Scene, place: Place) -> float:
    """Compute how high the rim of a box is.

    Args:
        scene: The scene.
        place: The box.

    Returns:
        m in the world.
    """
    return float((scene.T_world_place(place) @ place.access.T_place_mouth)[2, 3])
