"""What is perceived, corrected by what is known of items that were set down: they stand level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from pickcli.geometry import inverse
from pickcli.planning.pick_problem import StatedPlace
from pickcli.scene.scene import PlacedItem, Scene


def standing(seen: Scene, heights: Mapping[str, float]) -> Scene:
    """Return a scene in which items stand level, at known heights.

    Args:
        seen: Poses as perceived.
        heights: m of the middle of each item over the floor of its place, as it stands there.

    Returns:
        The scene; an item that is seen farther from its height than errors explain stays as it is seen.
    """
    return replace(seen, items=tuple(_stood(seen, placed, heights[placed.id]) for placed in seen.items))


def _stood(seen: Scene, placed: PlacedItem, height: float) -> PlacedItem:
    T_world_place = seen.T_world_place(seen.cell.places[placed.location])
    T = inverse(T_world_place) @ placed.T_world_item
    if abs(T[2, 3] - height) > seen.bound(placed):
        return placed
    x, y, yaw = float(T[0, 3]), float(T[1, 3]), float(np.arctan2(T[1, 0], T[0, 0]))
    return replace(placed, T_world_item=T_world_place @ StatedPlace(x, y, height, yaw).T_place_item)
