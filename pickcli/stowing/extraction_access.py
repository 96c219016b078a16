"""Which items of a bin have a way out: up, perhaps aside, and straight out through the mouth.

A sketch of what the planner proves later, on upright boxes. A person who stows leaves room for a hand; here
the hand needs about two centimetres around what it takes.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from pickcli.cell.place import Place
from pickcli.geometry import Array
from pickcli.stowing.box_arrays import Bools, BoxArrays, lies_on

ROOM = 0.020  # m that an item keeps from others and from the mouth's edges on its way
FIRST = 0.05  # m of the first stretch, in which an item still touches its neighbours
FIRST_ASIDE = 0.03  # m of it sideways at most
ASIDE = (0.0, 0.02, -0.02, 0.04, -0.04, 0.07, -0.07)  # m that are tried
HEIGHTS = (0.0, 0.5, 1.0)  # between as high as the lip demands and as the mouth allows
WAYS = np.array(list(product(ASIDE, HEIGHTS)))


def have_way_out(cell_bin: Place, boxes: BoxArrays) -> Bools:
    """Whether boxes can be taken out past the others of their row.

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
    """Whether each of W ways leads through the mouth, and how far aside and up it goes: (W, ..., N)."""
    aside, share = WAYS.T.reshape(2, -1, *[1] * (boxes.low.ndim - 1))
    half = cell_bin.access.width / 2 - ROOM
    (_, y_low, z_low), (_, y_high, z_high) = np.moveaxis(boxes.low, -1, 0), np.moveaxis(boxes.high, -1, 0)
    aside = np.clip(0.0, -half - y_low, half - y_high) + aside
    need, most = ROOM - z_low, cell_bin.access.height - ROOM - z_high
    rise = need + share * np.maximum(most - need, 0.0)
    fits = (y_low + aside >= -half - 1e-9) & (y_high + aside <= half + 1e-9) & (most >= need - 0.008)
    return fits, aside, rise


def _hinders(other: BoxArrays, of: BoxArrays, aside: Array, rise: Array) -> Bools:
    """Whether each other box is in the way of each box that rises, moves aside and is pulled out."""
    first_aside = np.clip(aside, -FIRST_ASIDE, FIRST_ASIDE)
    first_rise = np.minimum(rise, np.sqrt(FIRST**2 - first_aside**2))
    to_right = other.high[..., 1] - of.low[..., 1] + ROOM
    to_left = other.low[..., 1] - of.high[..., 1] - ROOM
    top = other.high[..., 2] - of.low[..., 2] + ROOM
    is_not_behind = other.low[..., 0] < of.high[..., 0]
    is_beside = (other.low[..., 0] < of.high[..., 0] + ROOM) & (other.high[..., 0] > of.low[..., 0] - ROOM)
    lifts = (to_left < np.maximum(aside, first_aside)) & (to_right > np.minimum(aside, first_aside))
    passes = (to_left < aside) & (to_right > aside)
    return np.asarray((is_beside & lifts & (top > first_rise)) | (is_not_behind & passes & (top > rise)))
