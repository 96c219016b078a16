"""Places where a carton can come down on a stack, straight from above.

Candidates are where an edge of it is in line with, or beside, an edge of another or of the pallet: pushed
together, any stack becomes one of these (E. Bischoff, M. Marriott, EJOR 44, 1990, use the same corners).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from pickcli.geometry import Array
from pickcli.palletizing.pallet_order import LEVEL, ROUNDED, Carton, PalletOrder
from pickcli.palletizing.pallet_stack import Placement

MOST_EDGES = 160  # positions along one axis, evenly chosen of more


@dataclass(frozen=True, eq=False)
class LandingPlaces:
    """Places of one carton in one orientation.

    Attributes:
        low: (N, 3) m, lower corner of the carton in each.
        is_turned: Whether its length is along y.
        bearing_area: (N,) share of its base over what is as high as what bears it.
        beside: (N,) m of the sides of its base that are beside others, or at the edge of the pallet.
    """

    low: Array
    is_turned: bool
    bearing_area: Array
    beside: Array


def landing_places(order: PalletOrder, placed: list[Placement], carton: Carton) -> list[LandingPlaces]:
    """Find where a carton can come down, whether or not it stands there.

    Args:
        order: The order.
        placed: What is on the pallet.
        carton: The carton.

    Returns:
        For each orientation in which it fits on the pallet.
    """
    lows = np.array([p.low for p in placed]).reshape(-1, 3)
    highs = np.array([p.high for p in placed]).reshape(-1, 3)
    turns = (False,) if carton.size[0] == carton.size[1] else (False, True)
    found = (_in_orientation(order, lows, highs, carton, is_turned) for is_turned in turns)
    return [places for places in found if places is not None]


def _in_orientation(
    order: PalletOrder, lows: Array, highs: Array, carton: Carton, is_turned: bool
) -> LandingPlaces | None:
    size = np.array(carton.size)[[1, 0, 2]] if is_turned else np.array(carton.size)
    room = np.array(order.pallet.room(order.clearance))
    if (size[:2] > room[1] - room[0] + ROUNDED).any():
        return None
    options = [_along(lows[:, k], highs[:, k], float(size[k]), room[:, k], order.clearance) for k in (0, 1)]
    at = np.array(list(product(*options)))
    far = at + size[:2]
    across = np.minimum(far[:, None], highs[None, :, :2]) - np.maximum(at[:, None], lows[None, :, :2])
    is_over = (across > ROUNDED).all(axis=2)
    is_near = (across > ROUNDED - order.clearance).all(axis=2)
    tops = highs[:, 2]
    z = np.where(is_over, tops, 0.0).max(axis=1, initial=0.0)
    passes = np.where(is_near, tops, 0.0).max(axis=1, initial=0.0) <= z + LEVEL
    fits = z + size[2] + order.pallet.deck <= order.pallet.height + ROUNDED
    kept = passes & fits
    at, far, across, is_over, z = at[kept], far[kept], across[kept], is_over[kept], z[kept]
    bears = is_over & (np.abs(tops - z[:, None]) <= LEVEL)
    areas = (np.where(bears[:, :, None], across, 0.0)).prod(axis=2).sum(axis=1) / size[:2].prod()
    low = np.column_stack([at, z])
    beside = _beside(low, low + size, lows, highs, room, order.clearance)
    return LandingPlaces(low, is_turned, np.where(z == 0.0, 1.0, areas), beside)


def _along(lows: Array, highs: Array, length: float, room: Array, clearance: float) -> list[float]:
    """Return positions of the lower side along one axis: in line with edges, and beside them."""
    starts = np.concatenate([room[:1], lows, highs + clearance])
    ends = np.concatenate([room[1:], highs, lows - clearance]) - length
    found = np.concatenate([starts, ends])
    is_inside = (found >= room[0] - ROUNDED) & (found + length <= room[1] + ROUNDED)
    found = np.unique(np.round(found[is_inside], 6))
    if len(found) > MOST_EDGES:
        found = found[np.linspace(0, len(found) - 1, MOST_EDGES).round().astype(int)]
    return [float(value) for value in found]


def _beside(low: Array, high: Array, lows: Array, highs: Array, room: Array, clearance: float) -> Array:
    """Return (N,) m of the sides of bases that are within twice the clearance of others, or at the edge."""
    total = np.zeros(len(low))
    is_high = (lows[None, :, 2] < high[:, None, 2]) & (highs[None, :, 2] > low[:, None, 2])
    for k in (0, 1):
        other = 1 - k
        shared = np.minimum(high[:, None, other], highs[None, :, other]) - np.maximum(
            low[:, None, other], lows[None, :, other]
        )
        shared = np.where(is_high, np.maximum(shared, 0.0), 0.0)
        for gap in (low[:, None, k] - highs[None, :, k], lows[None, :, k] - high[:, None, k]):
            is_beside = (gap >= -ROUNDED) & (gap <= 2 * clearance)
            total += np.where(is_beside, shared, 0.0).sum(axis=1)
        is_first = low[:, k] <= room[0, k] + 2 * clearance
        is_last = high[:, k] >= room[1, k] - 2 * clearance
        total += (is_first.astype(float) + is_last) * (high - low)[:, other]
    return total
