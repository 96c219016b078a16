"""Random layout of items in places open above: a heap between walls, or side by side without walls."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.random_scenes.bin_layout import ItemInstance
from pickcli.random_scenes.stable_poses import stable_poses
from pickcli.scene.scene import PlacedItem, Scene

N_DRAWS = 60  # poses tried for each item
FROM_WALL = 0.008  # m
ITEM_SPACING = 0.025  # m between items side by side
ABOVE = 0.002  # m above the supporting surface


def lay_heap(
    scene: Scene, place: Place, contents: Sequence[ItemInstance], rng: np.random.Generator
) -> tuple[PlacedItem, ...] | None:
    """Place items on one of their sides with random yaw, slightly above their resting poses.

    On a conveyor they lie where they may be picked, within its window.

    Args:
        scene: The scene that the place is in.
        place: A place that is open above.
        contents: Items to be placed, in this order.
        rng: Source of random numbers.

    Returns:
        The items; between walls each at the lowest pose found, else all on the floor. None if an item
        does not fit.
    """
    T_world_place, floor = scene.T_world_place(place), _floor(scene, place)
    low, high = np.zeros((0, 3)), np.zeros((0, 3))
    laid: list[PlacedItem] = []
    for entry in contents:
        drawn = [_drawn(place, floor, entry.item, (low, high), rng) for _ in range(N_DRAWS)]
        found = [T for T in drawn if T is not None]
        if not found:
            return None
        T = min(found, key=lambda T: float(T[2, 3]))
        reach = entry.item.shape.reach(T[:3, :3])
        low, high = np.vstack([low, T[:3, 3] - reach]), np.vstack([high, T[:3, 3] + reach])
        laid.append(PlacedItem(entry.id, entry.item, place.name, T_world_place @ T))
    return tuple(laid)


def _side_down(place: Place, item: Item, rng: np.random.Generator) -> Array:
    """Orientation (3, 3) of an item before its yaw; without walls one that does not roll, if possible."""
    every = stable_poses(item)
    standing = [(kind, weight) for kind, weight in every if not kind.is_on_edge]
    if not place.is_open_box:
        standing = [(kind, weight) for kind, weight in standing if not kind.can_roll] or standing
    weights = np.array([weight for _, weight in standing])
    return standing[rng.choice(len(standing), p=weights / weights.sum())][0].R_up_item


def _floor(scene: Scene, place: Place) -> tuple[Array, Array]:
    """Lower and upper corner (2,) of the floor on which items may lie, m in the place's frame."""
    low, high = place.room.low[:2].copy(), place.room.high[:2].copy()
    conveyor = scene.cell.carriers[place.carrier].conveyor
    if conveyor is not None:
        low[0], high[0] = np.array(conveyor.window) - place.T_carrier_place[0, 3]
    return low, high


def _drawn(
    place: Place,
    floor: tuple[Array, Array],
    item: Item,
    boxes: tuple[Array, Array],
    rng: np.random.Generator,
) -> Array | None:
    """Random pose (4, 4) on a floor, on top of boxes with these corners (K, 3); None if it does not fit."""
    turned = rotation_axis_angle((0.0, 0.0, 1.0), float(rng.uniform(-np.pi, np.pi)))
    R = turned @ _side_down(place, item, rng)
    reach, (low, high) = item.shape.reach(R), boxes
    least, most = floor[0] + FROM_WALL + reach[:2], floor[1] - FROM_WALL - reach[:2]
    if not (least <= most).all():
        return None
    middle = rng.uniform(least, most)
    apart = ABOVE if place.is_open_box else ITEM_SPACING
    is_under = ((low[:, :2] < middle + reach[:2] + apart) & (high[:, :2] > middle - reach[:2] - apart)).all(
        axis=1
    )
    if is_under.any() and not place.is_open_box:
        return None
    base = float(high[is_under, 2].max(initial=place.room.floor_back))
    return pose((*middle, base + ABOVE + reach[2]), R=R)
