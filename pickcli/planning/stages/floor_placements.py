"""Placements for setting an item down: on free, level floor, at the back behind a mouth and beside a wall.

The caller chooses the orientation of the item, in which the tool can set it down; here it is levelled. The
item must keep its balance, and an item that can roll must lie on level ground. An item that is too thin
to stand by itself leans back on a wall or another item, like books on a shelf.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import islice

import numpy as np

from pickcli.cell.place import Place
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.stage_contacts import while_resting_on
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, levelled, pose, rotation_axis_angle
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.statics.balance import FREE_SLENDERNESS
from pickcli.statics.supports import supports_of

STEP, FINE_STEP = 0.02, 0.01  # m between tried placements, and where none of those is free
FROM_WALLS = 0.006  # m to walls and to the back, besides the uncertainty of the item's pose
FROM_MOUTH = 0.01  # m that stay free behind the mouth
BEHIND_LIP = 0.03  # m that stay free behind a 20 mm deep lip in front of the floor
HOVER = 0.001  # m over the floor, besides how much lower the item may be than its pose says
OVER_OBSTACLES = 0.002  # m higher, where an obstacle under a thin floor is too near: a table under a mat
LEAN_ANGLE = np.radians(4.0)  # angle of a leaning item beyond the one at which its centre is over its edge
WALL_GAP = 0.008  # m to the walls on either side of a leaning item, besides the uncertainty of its pose
N_HALVINGS = 5  # bisections of the step in which it meets its support
SPREAD = 0.06  # m between the placements that are tried first
N_EXPLAINED = 16  # about, of the placements if none is free


def floor_placements(
    context: PlanningContext,
    scene: Scene,
    placed: PlacedItem,
    R_place_item: Array,
    place: Place,
    n_most: int = 8,
    hover: float = HOVER,
) -> tuple[PlacedItem, ...] | Failures:
    """Find placements of an item on the floor of a place.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived.
        placed: The item at its current pose.
        R_place_item: (3, 3) its orientation at the destination, before it is levelled.
        place: The destination.
        n_most: Most placements.
        hover: m over the floor, besides how much lower the item may be than its pose says; an item that leans
            has ``HOVER``.

    Returns:
        The item at each placement, the best first; or the reasons for failure.
    """
    R = levelled(R_place_item)
    reach = placed.item.shape.reach(R)
    if 2 * float(reach[:2].min()) < FREE_SLENDERNESS * 2 * float(reach[2]):
        return _leaning(context, scene, placed, R, place, n_most)
    T_world_place = scene.T_world_place(place)
    uncertainty = scene.bound(placed)
    free = FreeItem(placed.item, T_world_place @ pose(R=R), T_world_place[:3, :3], uncertainty)
    flying = FreeItemChecker(context.model, scene, free, while_resting_on(place.support, placed.id))
    for step, height in ((STEP, hover), (FINE_STEP, hover), (FINE_STEP, hover + OVER_OBSTACLES)):
        placements = _grid_placements(place, reach, uncertainty, step, height)
        fitting = [_placed(placed, place.name, T_world_place, R, d) for d in placements if flying.is_valid(d)]
        if fitting:
            break
    else:
        return _occupied(place, placements, flying)
    staying = tuple(islice((placement for placement in _spread(fitting) if _stays(scene, placement)), n_most))
    rolling = Reason("would fall over or roll", place.name, f"{placed.id} on all free places")
    return staying or Failures.of(rolling)


def _leaning(
    context: PlanningContext, scene: Scene, placed: PlacedItem, R: Array, place: Place, n_most: int
) -> tuple[PlacedItem, ...] | Failures:
    """Find placements at which an item that would fall over can lean back on the wall or on another item.

    From the last free placement before an obstacle, the item moves backwards until it might touch that within
    the errors of both poses: released there, it falls back onto it, and is not pressed on it.
    R: (3, 3) its orientation, levelled
    """
    reach = placed.item.shape.reach(R)
    size = " x ".join(f"{2e3 * e:.0f}" for e in reach)
    falls = Reason("would fall over", place.name, f"{placed.id} stands {size} mm")
    if place.access.is_from_above or reach[1] < reach[0]:
        return Failures.of(falls)
    T_world_place, gap = scene.T_world_place(place), scene.bound(placed) + HOVER
    free = FreeItem(placed.item, T_world_place @ pose(R=R), T_world_place[:3, :3], gap - HOVER)

    def flying(*leant_on: str) -> FreeItemChecker:
        touched = while_resting_on((*place.support, *leant_on), placed.id)
        return FreeItemChecker(context.model, scene, free, touched)

    apart, touching = flying(), cache(flying)
    placements = _leaning_placements(place, reach, gap)
    are_free = np.array([[apart.is_valid(d) for d in column] for column in placements]).reshape(
        placements.shape[:2]
    )
    found: list[Array] = []
    for column, row in zip(placements, are_free, strict=True):
        for k in np.flatnonzero(row[1:] & ~row[:-1]) + 1:  # the first of a column is behind the back wall
            behind = apart.clearance(column[k - 1]).b
            if _top(scene, behind) < (T_world_place @ pose(column[k][:3]))[2, 3] + gap:
                continue  # it would fall over what is lower than its centre
            near, far = column[k], column[k - 1]
            for _ in range(N_HALVINGS):
                middle = (near + far) / 2
                near, far = (middle, far) if touching(behind).is_valid(middle) else (near, middle)
            short, room = free.inflate + _bound(scene, behind), float(near[0] - column[k][0])
            share = min(1.0, short / room) if room > 0.0 else 0.0
            found.append(near + share * (column[k] - near))
    found.sort(key=lambda d: (-round(float(d[0]), 3), abs(float(d[1]))))
    stood = _spread([_placed(placed, place.name, T_world_place, R, d) for d in found])
    staying = tuple(islice((placement for placement in stood if _stays(scene, placement)), n_most))
    lean = Reason("nothing to lean on", place.name, f"{placed.id}, {len(found)} free places before something")
    return staying or Failures.of(falls, lean)


def _bound(scene: Scene, name: str) -> float:
    """Bound of the pose error of an item, m; 0 for a wall, as carriers are grown by their errors."""
    return next((scene.bound(placed) for placed in scene.items if placed.id == name), 0.0)


def _top(scene: Scene, name: str) -> float:
    """World z, m, up to which a body or an item surely reaches; points and unknown space bear nothing."""
    unknown = {body.name for space in scene.unknown for body in space.bodies}
    solids = [
        (body.name, body.shape, T @ body.T_parent_shape, 0.0)
        for body, T in scene.standing
        if body.name not in unknown
    ]
    solids += [(each.id, each.item.shape, each.T_world_item, scene.bound(each)) for each in scene.items]
    tops = (T[2, 3] + shape.reach(T[:3, :3])[2] - bound for own, shape, T, bound in solids if own == name)
    return float(next(tops, -np.inf))


def _leaning_placements(place: Place, half: Array, gap: float) -> Array:
    """Return (J, K, 6) displacements of a leaning item: columns, each from behind the back wall to the mouth.

    half: (3,) of the box around the level item. gap: m between its lower edge and the floor
    """
    (front, back), (low, high) = place.room.x_range, place.room.y_range
    pitch = float(np.arctan2(half[0], half[2])) + LEAN_ANGLE
    to_upper, to_lower = half[0] * np.cos(pitch) + np.array([1.0, -1.0]) * half[2] * np.sin(pitch)
    along_x = np.arange(back - to_upper + STEP, front + BEHIND_LIP + to_upper, -STEP)
    along_y = _grid(low + half[1] + gap + WALL_GAP, high - half[1] - gap - WALL_GAP)
    y, x = np.meshgrid(along_y, along_x, indexing="ij")
    z = place.room.floor_at(x + to_lower) + gap + half[2] * np.cos(pitch) + half[0] * np.sin(pitch)
    none = np.zeros_like(x)
    return np.stack([x, y, z, none, none + pitch, none], axis=-1)


def _spread(placements: list[PlacedItem]) -> list[PlacedItem]:
    """Reorder placements, those apart from all before them first: neighbours fail for the same reason."""
    at = np.array([placement.T_world_item[:3, 3] for placement in placements]).reshape(-1, 3)
    first: list[int] = []
    for k, p in enumerate(at):
        if (np.linalg.norm(at[first] - p, axis=1) >= SPREAD).all():
            first.append(k)
    return [placements[k] for k in (*first, *sorted(set(range(len(placements))) - set(first)))]


def _occupied(place: Place, placements: Array, flying: FreeItemChecker) -> Failures:
    """Explain what occupies some of the placements (K, 6), none of which is free."""
    what, tried = "no free place on the floor", f"{len(placements)} placements tried"
    met = [flying.clearance(d) for d in placements[:: 1 + len(placements) // N_EXPLAINED]]
    if not met:
        return Failures.of(Reason(what, place.name, tried))
    details = [(f"{flying.description(contact)}, {tried}", contact.item) for contact in met]
    return Failures(tuple(Reason(what, place.name, detail, item) for detail, item in details))


def _stays(scene: Scene, placement: PlacedItem) -> bool:
    """Whether an item stays where it is released, within pose errors."""
    beside = (p for p in scene.in_location(placement.location) if p.id != placement.id)
    supports = supports_of(replace(scene, items=(*beside, placement)))
    return supports.balance.stays(placement.id) or supports.balance.lies_level(placement.id)


def _grid_placements(place: Place, half: Array, uncertainty: float, step: float, hover: float) -> Array:
    """Return (K, 6) displacements from the place's origin to placements on its floor, as of a free flyer.

    Behind a mouth, placements far back and near a wall come first; on a table, those near its middle,
    which are the easiest to reach. half: (3,) of the box around the level item. uncertainty: m, of its pose
    """
    (front, back), (low, high) = place.room.x_range, place.room.y_range
    is_from_above = place.access.is_from_above
    free = BEHIND_LIP if place.room.floor_front < 0.0 else FROM_MOUTH
    wall = FROM_WALLS + uncertainty
    along_x = _grid(front + (wall if is_from_above else free) + half[0], back - wall - half[0], step)
    along_y = _grid(low + wall + half[1], high - wall - half[1], step)
    x, y = (axis.ravel() for axis in np.meshgrid(along_x, along_y, indexing="ij"))
    height, pitch = place.room.rest(x, half[0])
    # The item hovers over the floor, parallel to its surface.
    above = half[2] + uncertainty + hover
    none = np.zeros(len(x))
    at = (x + above * np.sin(pitch), y, height + above * np.cos(pitch), none, pitch, none)
    if is_from_above:
        cost = np.hypot(x - (front + back) / 2, y - (low + high) / 2).round(6)
    else:
        cost = place.room.depth - x + np.minimum(y - along_y.min(initial=0.0), along_y.max(initial=0.0) - y)
    return np.column_stack(at)[np.argsort(cost, kind="stable")]


def _grid(low: float, high: float, step: float = STEP) -> Array:
    """Return evenly spaced values, at most a step apart; the middle if an item hardly fits between walls."""
    if high < low:
        return np.full(int(low - high < 2 * FROM_WALLS), (low + high) / 2)
    return np.linspace(low, high, int(np.ceil((high - low) / step)) + 1)


def _placed(placed: PlacedItem, place_name: str, T_world_place: Array, R: Array, d: Array) -> PlacedItem:
    pitched = rotation_axis_angle((0.0, 1.0, 0.0), float(d[4])) @ R
    return replace(placed, location=place_name, T_world_item=T_world_place @ pose(d[:3], R=pitched))
