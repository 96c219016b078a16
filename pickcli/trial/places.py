"""Where an item is, by the rules: in a bin, in the tote, or outside; and how far it stands out."""

from __future__ import annotations

import numpy as np

from pickcli.cell.scene import TOTE, PlacedItem, Scene
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, transform_points
from pickcli.trial.score import OUTSIDE

HEAP = 0.25  # m over the tote's rim up to which a heaped item still lies in the tote


def place_of(scene: Scene, T_world_item: Array) -> str:
    """Bin name, TOTE or OUTSIDE of an item whose pose (4, 4) in the world is given, by its centre."""
    centre = T_world_item[:3, 3][None]
    bin_name = scene.cell.pod.bin_of_point(transform_points(inverse(scene.T_world_pod), centre)[0])
    if bin_name is not None:
        return bin_name
    tote = scene.cell.tote
    x, y, z = transform_points(inverse(tote.T_world_tote), centre)[0]
    length, width, height = tote.inner
    is_in_tote = abs(x) <= length / 2 and abs(y) <= width / 2 and 0.0 <= z <= height + HEAP
    return TOTE if is_in_tote else OUTSIDE


def protrusion(scene: Scene, placed: PlacedItem) -> float:
    """How far, in m, the item stands out beyond the plane of the pod's front face; 0 if it does not."""
    T_pod_item = inverse(scene.T_world_pod) @ placed.T_world_item
    outwards = np.array([-1.0, 0.0, 0.0])
    reach = extent_along(placed.item.shape, T_pod_item[:3, :3].T @ outwards)
    return max(0.0, reach - float(T_pod_item[0, 3]))


def extent_along(shape: Shape, direction: Array) -> float:
    """Distance in m from the centre to the farthest point along a unit vector (3,) of the shape's frame."""
    x, y, z = (abs(float(v)) for v in direction)
    if shape.kind is ShapeKind.BOX:
        return float(np.dot((x, y, z), shape.size)) / 2
    if shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        return radius * float(np.hypot(x, y)) + length / 2 * z
    return float(shape.size[0])
