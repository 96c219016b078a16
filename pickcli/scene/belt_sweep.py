"""What rides on a belt as it may have come to, wherever the belt runs on to: each item swept along the belt.

A motion that keeps away from the swept items is free of the true ones whether the belt runs on, as fast as it
likes, or stands. Belts do not run backwards.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene


def swept_along_belt(scene: Scene, conveyor: str, behind: float = 0.0) -> Scene:
    """Return a scene in which every item on a conveyor fills all that it may come to.

    Args:
        scene: The scene.
        conveyor: Name of the conveyor.
        behind: m by which the belt may be behind.

    Returns:
        The scene with the items of the conveyor as boxes along it, from where they are now to farther than
        the belt brings any of those that are known.
    """
    carrier = scene.cell.carriers[conveyor]
    assert carrier.conveyor is not None
    T, farthest = scene.pose_of(carrier).T_world_carrier, carrier.conveyor.farthest
    return replace(
        scene,
        items=tuple(
            _swept(scene, placed, T, behind, farthest) if placed.location in carrier.places else placed
            for placed in scene.items
        ),
    )


def _swept(
    scene: Scene, placed: PlacedItem, T_world_belt: Array, behind: float, farthest: float
) -> PlacedItem:
    """Return an item as the box around it in the belt's frame, drawn out along the belt."""
    T = inverse(T_world_belt) @ placed.T_world_item
    half = placed.item.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - half, T[:3, 3] + half
    low[0], high[0] = low[0] - behind, high[0] + farthest
    at = np.eye(4)
    at[:3, 3] = (low + high) / 2
    size = tuple(float(side) for side in high - low)
    bound = scene.bound(placed)
    return replace(
        placed,
        item=replace(placed.item, shape=Shape(ShapeKind.BOX, size)),
        T_world_item=T_world_belt @ at,
        noise=PoseNoise(bound, 0.0, bound),
    )
