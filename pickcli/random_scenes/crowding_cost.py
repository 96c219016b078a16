"""Crowding cost of items that hide or obstruct each other in a bin.

Modelled on people who stow for visibility and access: high items behind low ones, a finger's width apart. The
targets are unknown here, so all items count alike.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.place import Place
from pickcli.geometry import Array
from pickcli.random_scenes.box_arrays import Bools, BoxArrays, gap

HIDDEN = 1.0  # cost of an item hidden behind a higher one
CONTACT_COST = 2.0  # cost of contact with an item high enough to obstruct fingers
CLOSE = 0.5  # cost of contact with a low item
FINGER = 0.022  # m of gap beside an item, above which the cost is 0
SOME = 0.008  # m of gap beside low items, above which the cost is 0
LOW = 0.022  # m, largest height of a low item above the base of its neighbour
TALL = 0.06  # m by which an item in front must be higher to hide the one behind it completely


def crowding(cell_bin: Place, boxes: BoxArrays) -> Array:
    """Compute the crowding cost of boxes in their bin.

    Args:
        cell_bin: The bin.
        boxes: Rows of N boxes (..., N, 3), bin frame.

    Returns:
        (...) cost of each row.
    """
    one, other = boxes.column, boxes.row
    between = gap(one, other)
    pairs = CONTACT_COST * _shortfall(between, FINGER) * ~_is_low(other, one) + HIDDEN * _hidden(one, other)
    pairs += CLOSE / 2 * _shortfall(between, SOME)
    pairs *= ~np.eye(boxes.low.shape[-2], dtype=bool)
    return np.asarray(pairs.sum(axis=(-1, -2)) + _at_walls(cell_bin, boxes).sum(axis=-1))


def _hidden(behind: BoxArrays, front: BoxArrays) -> Array:
    """Share of a box hidden behind another, 0 to 1."""
    is_behind = behind.middle[..., 0] > front.middle[..., 0]
    width = np.minimum(front.high[..., 1], behind.high[..., 1]) - np.maximum(
        front.low[..., 1], behind.low[..., 1]
    )
    share = np.clip(width / (behind.high - behind.low)[..., 1], 0.0, 1.0)
    higher = np.clip((front.high[..., 2] - behind.high[..., 2]) / TALL, 0.0, 1.0)
    return np.asarray(is_behind * share * higher)


def _is_low(other: BoxArrays, of: BoxArrays) -> Bools:
    return np.asarray(other.high[..., 2] <= of.low[..., 2] + LOW)


def _at_walls(cell_bin: Place, boxes: BoxArrays) -> Array:
    """Cost (..., N) of boxes close to the edges of the mouth and to the back."""
    half = cell_bin.access.width / 2
    gaps = (boxes.low[..., 1] + half, half - boxes.high[..., 1], cell_bin.room.depth - boxes.high[..., 0])
    return np.asarray(CONTACT_COST * sum(_shortfall(width, FINGER) for width in gaps))


def _shortfall(width: Array, enough: float) -> Array:
    """Relative lack of width, 0 to 1."""
    return np.clip(1.0 - width / enough, 0.0, 1.0)
