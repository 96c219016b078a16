"""Landing places of whole grids, against one position and one carton of the stack at a time."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.palletizing.landing_places import LandingPlaces, PlacementArrays, landing_places
from pickcli.palletizing.pallet_order import LEVEL, Carton, Pallet, PalletOrder, least_contact
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stacking import stack_as_they_come
from pickcli.palletizing.support_polygon import clipped

WALLED = Pallet((0.8, 0.6), 0.144, 1.0, 500.0, ("-x", "+y"))


def positions(order: PalletOrder, placed: tuple[Placement, ...], size: Array, k: int) -> list[float]:
    """Lower sides along an axis that are in line with edges, or beside them, inside of the room."""
    low, high = (float(end[k]) for end in order.pallet.room(order.clearance))
    found = {low, high - float(size[k])}
    for p in placed:
        near, far, keeps = float(p.low[k]), float(p.high[k]), order.clearance
        found |= {near, far + keeps, far - float(size[k]), near - keeps - float(size[k])}
    return [at for at in found if low - 1e-6 <= at and at + float(size[k]) <= high + 1e-6]


def shared(p: Placement, low: Array, high: Array) -> Array:
    """Lengths (2,) that two bases share along both axes, negative where they are apart."""
    return np.asarray((np.minimum(p.high, high) - np.maximum(p.low, low))[:2])


def judged(
    order: PalletOrder, placed: tuple[Placement, ...], low: Array, size: Array
) -> dict[str, float] | None:
    """What a place is like, where a carton comes straight down; None where it cannot."""
    over = [p for p in placed if (shared(p, low, low + size) > 1e-6).all()]
    near = [p for p in placed if (shared(p, low, low + size) > 1e-6 - order.clearance).all()]
    z = max((float(p.high[2]) for p in over), default=0.0)
    if any(p.high[2] > z + LEVEL for p in near):
        return None
    if z + size[2] + order.pallet.deck > order.pallet.height + 1e-6:
        return None
    bearing = [p for p in over if abs(p.high[2] - z) <= LEVEL]
    borne = sum(float(shared(p, low, low + size).prod()) for p in bearing)
    least, most = (beside_of(order, placed, low, size, z, off) for off in (-1e-6, 1e-6))
    return {"z": z, "area": borne / float(size[:2].prod()) if over else 1.0, "least": least, "most": most}


def beside_of(
    order: PalletOrder, placed: tuple[Placement, ...], low: Array, size: Array, z: float, off: float
) -> float:
    """M of the sides of a base at a height that are near others or the edge, with an error of the reach."""
    total, reach, room = 0.0, 2 * order.clearance + off, order.pallet.room(order.clearance)
    for k in (0, 1):
        at_edges = (low[k] <= room[0][k] + reach, low[k] + size[k] >= room[1][k] - reach)
        total += sum(at_edges) * float(size[1 - k])
        for p in placed:
            along = shared(p, low, low + size)
            is_high = p.low[2] < z + size[2] and p.high[2] > z
            if is_high and -1e-6 - off <= -along[k] <= reach:
                total += max(float(along[1 - k]), 0.0)
    return total


@given(seed=st.integers(0, 10_000), n=st.integers(0, 12))
@settings(deadline=None, max_examples=12)
def test_places_are_those_found_one_by_one(seed: int, n: int) -> None:
    """What counts as beside may differ where the gap is within a rounding of its limit."""
    drawn = random_pallet_order(n + 1, seed, WALLED)
    order = PalletOrder(WALLED, drawn.cartons[:n], drawn.clearance)
    placed = stack_as_they_come(order).placements if n else ()
    arrays = PlacementArrays.of(placed, [5.0] * len(placed))
    carton = drawn.cartons[n]
    for places in landing_places(order, arrays, carton):
        size = np.array(carton.size)[[1, 0, 2] if places.is_turned else [0, 1, 2]]
        options = [positions(order, placed, size, k) for k in (0, 1)]
        expected = {
            (round(x, 5), round(y, 5)): found
            for x, y in product(*options)
            if (found := judged(order, placed, np.array([x, y, 0.0]), size)) is not None
        }
        given_places = {
            (round(float(low[0]), 5), round(float(low[1]), 5)): (float(low[2]), float(area), float(beside))
            for low, area, beside in zip(places.low, places.supported_share, places.beside, strict=True)
        }
        assert given_places.keys() == expected.keys()
        for at, (z, area, beside) in given_places.items():
            assert z == pytest.approx(expected[at]["z"], abs=1e-9)
            assert area == pytest.approx(expected[at]["area"], abs=1e-4)
            assert expected[at]["least"] - 1e-4 <= beside <= expected[at]["most"] + 1e-4
        check_what_bears(order, placed, places, size)


def check_what_bears(
    order: PalletOrder, placed: tuple[Placement, ...], places: LandingPlaces, size: Array
) -> None:
    """All that bears a carton is in the rectangle that is told, and spares what is told."""
    for low, spare, first, last in zip(
        places.low, places.spare, places.borne_low, places.borne_high, strict=True
    ):
        over = [p for p in placed if (shared(p, low, low + size) > 1e-6).all()]
        bearing = [p for p in over if abs(p.high[2] - low[2]) <= LEVEL]
        assert spare == (5.0 if bearing else np.inf)
        for p in bearing:
            if shared(p, low, low + size).min() >= least_contact(order.clearance):
                for corner in clipped(p.bears_within, low[:2], (low + size)[:2]):
                    assert (first - 1e-9 <= corner).all() and (corner <= last + 1e-9).all()
        if not over:
            np.testing.assert_array_equal([first, last], [low[:2], (low + size)[:2]])


def test_what_is_too_large_for_the_deck_has_no_place() -> None:
    order = PalletOrder(WALLED, (Carton("long", (0.797, 0.3, 0.1), 1.0),))
    assert landing_places(order, PlacementArrays.of((), ()), order.cartons[0]) == []
