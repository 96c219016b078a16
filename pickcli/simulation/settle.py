"""Lets items come to rest in a physics simulation of the carriers and some items, without the robot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import combinations

import numpy as np

from pickcli.cell.station import OBSTACLE, UNKNOWN
from pickcli.errors import Reason
from pickcli.geometry import inverse
from pickcli.scene.colours import item_colour, static_colour
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import bounds, location_of

TIME_STEP = 1e-3  # s, that of ``World``, so that items at rest here are at rest there
MAX_TIME = 6.0  # s; items that still move then are rejected
REST_TIME = 0.25  # s below both speeds, after which items are at rest
SETTLED_SPEED = 1e-3  # m/s
SETTLED_TURN_RATE = 2e-2  # rad/s
MAX_OVERLAP = 1e-3  # m between any two shapes
MAX_DRIFT = 5e-4  # m, tolerated motion of an item while the last contacts form
DRIFT_TIME = 0.5  # s
MAX_CREEP = 2.5e-4  # m, tolerated motion after that: a pile that creeps for minutes finally falls
CREEP_TIME = 1.4  # s; the engine lets items fall asleep after 2 s of rest


def settle(scene: Scene, items: tuple[PlacedItem, ...]) -> tuple[PlacedItem, ...] | Reason:
    """Drop items of a scene from their poses until they are at rest.

    Args:
        scene: The scene, for its carriers; its own items are ignored.
        items: Items to be dropped.

    Returns:
        The items at rest, in the same order, or the reason for failure: an item keeps moving, leaves its
        location, sticks out of it, or overlaps.
    """
    with _engine_with(scene, items) as engine:
        rested = _come_to_rest(engine, scene, items)
    if isinstance(rested, Reason):
        return rested
    # In a world of its own, as a scene is loaded: what only contacts that formed in its fall hold, falls.
    with _engine_with(scene, rested) as engine:
        return _drift(engine, rested) or rested


@contextmanager
def _engine_with(scene: Scene, items: tuple[PlacedItem, ...]) -> Iterator[Engine]:
    """Yield an engine with the carriers of a scene, and items at their poses."""
    engine = Engine(TIME_STEP)
    try:
        for carrier in scene.posed_carriers:
            for body in carrier.bodies if carrier.name not in (OBSTACLE, UNKNOWN) else ():
                engine.add_static(body, carrier.T_world_carrier, static_colour(carrier.name))
        for placed in items:
            engine.add_item(placed.id, placed.item, placed.T_world_item, item_colour(placed.item))
        yield engine
    finally:
        engine.close()


def _come_to_rest(
    engine: Engine, scene: Scene, items: tuple[PlacedItem, ...]
) -> tuple[PlacedItem, ...] | Reason:
    if (mover := _run(engine, items)) is not None:
        return Reason("does not come to rest", mover.location, mover.id)
    rested = tuple(replace(p, T_world_item=engine.pose(p.id)) for p in items)
    for placed in rested:
        if reason := _misplaced(scene, placed):
            return reason
        if reason := _overlap(engine, placed):
            return reason
    if reason := _pressed_together(rested):
        return reason
    return rested


def _run(engine: Engine, items: tuple[PlacedItem, ...]) -> PlacedItem | None:
    """Step until all items are at rest, and return None, or an item that still moves after MAX_TIME."""
    quiet = 0.0
    moving: PlacedItem | None = None
    for _ in range(round(MAX_TIME / TIME_STEP)):
        engine.step()
        moving = next((p for p in items if _moves(engine, p)), None)
        quiet = 0.0 if moving else quiet + TIME_STEP
        if quiet >= REST_TIME:
            return None
    return moving or items[0]


def _moves(engine: Engine, placed: PlacedItem) -> bool:
    linear, angular = engine.speed(placed.id)
    return linear > SETTLED_SPEED or angular > SETTLED_TURN_RATE


def _misplaced(scene: Scene, placed: PlacedItem) -> Reason | None:
    """Why an item is not entirely inside its location, or None."""
    where = location_of(scene, placed.item, placed.T_world_item)
    if where != placed.location:
        return Reason("left its place", placed.location, f"{placed.id} is {where}")
    place = scene.cell.places.get(placed.location)
    if place is None or place.access.is_from_above:  # a heap may rise above the rim
        return None
    lower, _ = bounds(placed.item.shape, inverse(scene.T_world_place(place)) @ placed.T_world_item)
    if lower[0] < 0.0:
        return Reason("sticks out", placed.location, f"{placed.id} by {-lower[0] * 1e3:.0f} mm")
    return None


def _overlap(engine: Engine, placed: PlacedItem) -> Reason | None:
    for point in engine.contact_points(placed.id):
        if point.depth > MAX_OVERLAP:
            detail = f"{placed.id} and {point.b} by {point.depth * 1e3:.1f} mm"
            return Reason("overlap", placed.location, detail)
    return None


def _pressed_together(rested: tuple[PlacedItem, ...]) -> Reason | None:
    """Two items that overlap more than a scene file allows, which the engine's margins can hide."""
    for a, b in combinations(rested, 2):
        depth = overlap_depth(
            PosedSolid(a.item.shape, a.T_world_item), PosedSolid(b.item.shape, b.T_world_item)
        )
        if depth > 0.0:
            return Reason("overlap", b.location, f"{a.id} and {b.id} by {depth * 1e3:.1f} mm")
    return None


def _drift(engine: Engine, items: tuple[PlacedItem, ...]) -> Reason | None:
    """Continue for a while with all items awake, and report an item that moves."""
    for duration, limit in ((DRIFT_TIME, MAX_DRIFT), (CREEP_TIME, MAX_CREEP)):
        for placed in items:
            engine.wake(placed.id)
        before = [engine.pose(placed.id)[:3, 3] for placed in items]
        for _ in range(round(duration / TIME_STEP)):
            engine.step()
        for placed, position in zip(items, before, strict=True):
            moved = float(np.linalg.norm(engine.pose(placed.id)[:3, 3] - position))
            if moved > limit:
                what = f"{placed.id} creeps {moved * 1e3:.2f} mm in {duration} s"
                return Reason("does not come to rest", placed.location, what)
    return None
