"""Check the release of the item: between walls below the drop limit, else just over floor or other items."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from pickcli.cell.place import Place
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.landing_statics import (
    fall_onto_others,
    is_borne,
    keeps_standing,
    leans_too_low,
    tips_as_it_lands,
)
from pickcli.verification.static_solids import place_at, release_pose

DROP_LIMIT = 0.3  # m from the item's bottom to the floor between walls (rules of 2016)
SHIFT = re.compile(r"shift .+ in \S+ by (?P<x>-?\d+),(?P<y>-?\d+) mm(?: and (?P<turn>-?\d+) deg)?")
STATED = re.compile(
    r"pick .+ from \S+ into (?P<place>\S+) at (?P<x>-?[\d.]+),(?P<y>-?[\d.]+),(?P<z>-?[\d.]+) mm and "
    r"(?P<yaw>-?[\d.]+) deg"
)
OFF_SHIFT, OFF_TURN = 3.0, np.radians(2.0)  # mm and rad by which an item may end off what the query says
SET_DOWN = 0.02  # m to the floor of any other place, on top of the item's uncertainty: it must not tumble


def check_release(plan: Plan, scene: Scene, T_tip_item: Array | None) -> tuple[Reason, ...]:
    """Check where the item is released.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.

    Returns:
        The faults; () if nothing is released.
    """
    if plan.grasp is None or T_tip_item is None:
        return ()
    ends = releases(plan)
    if plan.segments[-1].held is None and not ends:
        return (Reason("never released", plan.grasp.item, "the item is not brought anywhere"),)
    return tuple(reason for k in ends for reason in _at(plan, scene, k, T_tip_item))


def _at(plan: Plan, scene: Scene, k: int, T_tip_item: Array) -> Iterable[Reason]:
    assert plan.grasp is not None
    T = release_pose(plan, scene, k, T_tip_item)
    place = place_at(scene, T)
    if place is None:
        yield Reason("released outside of every place", plan.grasp.item, "the cell has no place there")
        return
    taken = scene.instance(plan.grasp.item)
    placed = PlacedItem(taken.id, taken.item, place.name, T, taken.noise)
    yield from _shifted_as_stated(plan, scene, placed)
    yield from _set_down_as_stated(plan, scene, placed)
    if place.is_open_box:
        yield from _dropped(scene, place, placed)
        return
    yield from _off_floor(scene, place, placed)
    yield from _tumbles(scene, placed)


def _shifted_as_stated(plan: Plan, scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    """Check that an item is shifted within its place as the query says; () for all other plans."""
    found = SHIFT.fullmatch(plan.query)
    if found is None or scene.held is not None:
        return
    before = scene.find(placed.id)
    if placed.location != before.location:
        detail = f"released in {placed.location}, taken from {before.location}"
        yield Reason("not shifted as stated", placed.id, detail)
        return
    T_world_place = scene.T_world_place(scene.cell.places[placed.location])
    start, end = (inverse(T_world_place) @ T for T in (before.T_world_item, placed.T_world_item))
    x, y = (end - start)[:2, 3]
    across = end[:3, :3] @ start[:3, :3].T
    turn = np.arctan2(across[1, 0] - across[0, 1], across[0, 0] + across[1, 1])
    stated = float(found["x"]), float(found["y"]), np.radians(float(found["turn"] or 0.0))
    off_turn = abs(np.angle(np.exp(1j * (turn - stated[2]))))
    if np.hypot(1e3 * x - stated[0], 1e3 * y - stated[1]) > OFF_SHIFT or off_turn > OFF_TURN:
        detail = f"by {1e3 * x:.0f},{1e3 * y:.0f} mm and {np.degrees(turn):.0f} deg"
        yield Reason("not shifted as stated", placed.id, detail)


def _set_down_as_stated(plan: Plan, scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    """Check that an item is released over its place that the query states; () for all other plans."""
    found = STATED.fullmatch(plan.query)
    if found is None:
        return
    if placed.location != found["place"]:
        yield Reason("not set down as stated", placed.id, f"in {placed.location}, not in {found['place']}")
        return
    T = inverse(scene.T_world_place(scene.cell.places[placed.location])) @ placed.T_world_item
    x, y, z = (1e3 * T[:3, 3]).tolist()
    off = float(np.hypot(x - float(found["x"]), y - float(found["y"])))
    yaw = np.arctan2(T[1, 0], T[0, 0]) - np.radians(float(found["yaw"]))
    off_turn = abs(np.angle(np.exp(1j * yaw)))
    over = z - float(found["z"])
    if off > OFF_SHIFT or off_turn > OFF_TURN or not -OFF_SHIFT <= over <= 1e3 * SET_DOWN:
        detail = f"{off:.1f} mm aside, {over:.1f} mm higher, turned by {np.degrees(off_turn):.1f} deg"
        yield Reason("not set down as stated", placed.id, detail)


def _released(scene: Scene, placed: PlacedItem) -> Scene:
    """Return the scene with an item where it is released."""
    return replace(scene, items=(*(p for p in scene.items if p.id != placed.id), placed), held=None)


def _tumbles(scene: Scene, placed: PlacedItem) -> Iterator[Reason]:
    """Check that the released item stays upright, and what it lies on, by statics at the release pose."""
    there = _released(scene, placed)
    where = f"in {placed.location} where it is let go"
    if not keeps_standing(there, placed.id):
        yield Reason("would fall over", placed.id, f"it does not keep its balance {where}")
    elif not is_borne(there, placed.id):
        yield Reason("would fall over", placed.id, f"what lies below it {where} does not keep its balance")
    elif tips_as_it_lands(there, placed.id):
        yield Reason("would fall over", placed.id, f"too near an edge of what lies below it {where}")
    elif leans_too_low(there, placed.id):
        yield Reason("would fall over", placed.id, f"it leans {where} on what is lower than its centre")


def _dropped(scene: Scene, place: Place, placed: PlacedItem) -> Iterator[Reason]:
    """Check that an item released over a place with walls is between them and does not fall too far."""
    low, _, beyond = _box_in(scene, place, placed)
    if beyond > 0.0:
        yield Reason(f"released beyond the {place.name}'s walls", placed.id, f"by {beyond * 1e3:.0f} mm")
    fall = low[2] - place.room.floor_back
    if fall > DROP_LIMIT:
        yield Reason(
            "released too high", placed.id, f"{fall:.3f} m over the floor, the limit is {DROP_LIMIT}"
        )


def _off_floor(scene: Scene, place: Place, placed: PlacedItem) -> Iterator[Reason]:
    """Check that an item that is set down is wholly in its place, and just over the floor or on an item."""
    low, high, beyond = _box_in(scene, place, placed)
    if place.access.is_from_above:
        if beyond > 0.0:
            yield Reason(f"released beyond the {place.name}'s edge", placed.id, f"by {beyond * 1e3:.0f} mm")
    elif low[0] < 0.0:
        out = f"{-low[0] * 1e3:.0f} mm out of {place.name}"
        yield Reason("released beyond the bin's mouth", placed.id, out)
    floor = float(place.room.floor_at(high[0]))
    most = SET_DOWN + scene.bound(placed)
    fall = min(low[2] - floor, fall_onto_others(_released(scene, placed), placed.id))
    if fall > most:
        over = f"{1e3 * fall:.0f} mm over the floor of {place.name} or an item, at most {most * 1e3:.0f}"
        yield Reason("released too high", placed.id, over)


def _box_in(scene: Scene, place: Place, placed: PlacedItem) -> tuple[Array, Array, float]:
    """Return both corners (3,) of an item's box in a place's frame, and m that it exceeds the room."""
    T = inverse(scene.T_world_place(place)) @ placed.T_world_item
    reach = placed.item.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - reach, T[:3, 3] + reach
    room = place.room
    return low, high, float(np.maximum(high[:2] - room.high[:2], room.low[:2] - low[:2]).max())
