"""Stable poses of items on a floor, with their probabilities."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.statics.balance import FREE_SLENDERNESS

SUPPORTED_SLENDERNESS = 0.1  # below this an item falls over even next to a wall
LEAST_EDGE = 0.01  # m, least thickness of an item on its edge: leaflets and bags do not stand
WEIGHTS = (0.5, 0.3, 0.2)  # of the lowest pose, the next and the highest


@dataclass(frozen=True, eq=False)
class StablePose:
    """A pose in which an item stands on one of its sides.

    Attributes:
        R_up_item: (3, 3) orientation before any rotation about the vertical.
        height: m.
        is_level: Whether its top is flat, so that others can lie on it.
        is_on_edge: Whether it is so thin, along y, that it needs support at the side.
        can_roll: Whether it rolls along its y axis (a lying cylinder) or in any direction (a sphere).
    """

    R_up_item: Array
    height: float
    is_level: bool
    is_on_edge: bool
    can_roll: bool


@cache
def stable_poses(item: Item) -> list[tuple[StablePose, float]]:
    """Return all stable poses of an item with their probabilities.

    Args:
        item: The item.

    Returns:
        Poses and probabilities, the lowest first.
    """
    found = {round(s.height, 6): s for s in (_stance(item, up) for up in range(3)) if s is not None}
    ranked = [found[height] for height in sorted(found)]
    weights = np.array(WEIGHTS[: len(ranked)])
    return list(zip(ranked, (weights / weights.sum()).tolist(), strict=True))


def _stance(item: Item, up: int) -> StablePose | None:
    """Stable pose with one of the item's axes upwards, or None if it is unstable."""
    shape = item.shape
    if shape.kind is not ShapeKind.BOX and up == 1:
        return None  # equivalent to its x axis
    if shape.kind is ShapeKind.CYLINDER and up == 0 and shape.extents[2] < shape.extents[0]:
        return None  # a disc rolls away on its rim
    R = upwards(shape, up)
    _, y, height = np.abs(R) @ shape.extents
    slenderness = y / height
    is_on_edge = slenderness < FREE_SLENDERNESS
    if is_on_edge and (slenderness < SUPPORTED_SLENDERNESS or y < LEAST_EDGE or item.folded):
        return None
    is_round = shape.kind is ShapeKind.SPHERE or (shape.kind is ShapeKind.CYLINDER and up == 0)
    return StablePose(R, float(height), not is_round, bool(is_on_edge), is_round)


def upwards(shape: Shape, up: int) -> Array:
    """Compute the rotation that turns an axis upwards and the longer of the other sides along x.

    Args:
        shape: The shape.
        up: Index of its axis.

    Returns:
        (3, 3).
    """
    a, b = (axis for axis in range(3) if axis != up)
    long, short = (a, b) if shape.extents[a] >= shape.extents[b] else (b, a)
    R = np.zeros((3, 3))
    R[0, long], R[2, up] = 1.0, 1.0
    R[1, short] = 1.0
    R[1] *= np.linalg.det(R)
    return R
