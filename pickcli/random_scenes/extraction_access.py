"""Extraction access of items in a bin: up, possibly sideways, and straight out through the mouth.

An approximation on boxes of what the planner later proves. People who stow leave room for a hand; here the
tool needs about two centimetres around the item.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pickcli.cell.place import Place
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import Bools, BoxArrays, lies_on

PATH_CLEARANCE = 0.020  # m of clearance around an item on its path
# m, length of the first stretch, in which an item may still touch its neighbours. The planner's is a little
# longer; with less, an item that is said to have a way out here has some way to spare there.
FIRST_STRETCH = 0.05
FIRST_ASIDE = 0.03  # m, largest sideways part of that stretch
SIDEWAYS_OFFSETS = (0.0, 0.02, -0.02, 0.04, -0.04, 0.07, -0.07)  # m, sideways displacements to try
HEIGHTS = (0.0, 0.5, 1.0)  # between the lowest height over the lip and the highest in the mouth
WAYS = np.array(list(product(SIDEWAYS_OFFSETS, HEIGHTS)))


def have_way_out(cell_bin: Place, boxes: BoxArrays) -> Bools:
    """Whether boxes can be extracted past the others of their row.

    Args:
        cell_bin: The bin.
        boxes: Rows of N boxes (..., N, 3), bin frame.

    Returns:
        (..., N).
    """
    is_other = ~np.eye(boxes.low.shape[-2], dtype=bool)
    buried = (is_other & lies_on(boxes.row, boxes.column)).any(axis=-1)
    fits, aside, rise = _ways(cell_bin, boxes)
    hindered = is_other & _hinders(boxes.row, boxes.column, aside[..., None], rise[..., None])
    return np.asarray(~buried & (fits & ~hindered.any(axis=-1)).any(axis=0))


def _ways(cell_bin: Place, boxes: BoxArrays) -> tuple[Bools, Array, Array]:
    """Whether each of W paths passes the mouth, and its displacement sideways and up: (W, ..., N)."""
    aside, share = WAYS.T.reshape(2, -1, *[1] * (boxes.low.ndim - 1))
    half = cell_bin.access.width / 2 - PATH_CLEARANCE
    (_, y_low, z_low), (_, y_high, z_high) = np.moveaxis(boxes.low, -1, 0), np.moveaxis(boxes.high, -1, 0)
    aside = np.clip(0.0, -half - y_low, half - y_high) + aside
    need, most = PATH_CLEARANCE - z_low, cell_bin.access.height - PATH_CLEARANCE - z_high
    rise = need + share * np.maximum(most - need, 0.0)
    fits = (y_low + aside >= -half - 1e-9) & (y_high + aside <= half + 1e-9) & (most >= need - 0.008)
    return fits, aside, rise


def _hinders(other: BoxArrays, of: BoxArrays, aside: Array, rise: Array) -> Bools:
    """Whether each other box obstructs each box that is raised, moved sideways and pulled out."""
    first_aside = np.clip(aside, -FIRST_ASIDE, FIRST_ASIDE)
    first_rise = np.minimum(rise, np.sqrt(FIRST_STRETCH**2 - first_aside**2))
    to_right = other.high[..., 1] - of.low[..., 1] + PATH_CLEARANCE
    to_left = other.low[..., 1] - of.high[..., 1] - PATH_CLEARANCE
    top = other.high[..., 2] - of.low[..., 2] + PATH_CLEARANCE
    is_not_behind = other.low[..., 0] < of.high[..., 0]
    is_beside = (other.low[..., 0] < of.high[..., 0] + PATH_CLEARANCE) & (
        other.high[..., 0] > of.low[..., 0] - PATH_CLEARANCE
    )
    lifts = (to_left < np.maximum(aside, first_aside)) & (to_right > np.minimum(aside, first_aside))
    passes = (to_left < aside) & (to_right > aside)
    return np.asarray((is_beside & lifts & (top > first_rise)) | (is_not_behind & passes & (top > rise)))
