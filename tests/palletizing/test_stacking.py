"""Stacks keep what they promise: room, support at any time, loads, sequence; against a linear program."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from pickcli.geometry import Array
from pickcli.palletizing.drop_test import drop_test, what_stands
from pickcli.palletizing.pallet_order import Carton, Pallet, PalletOrder
from pickcli.palletizing.pallet_stack import Placement, loads_on
from pickcli.palletizing.pallet_stack_file import StackedPallet, stack_to_dict
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stacking import stack_all, stack_as_they_come
from pickcli.palletizing.support_polygon import EMPTY

SMALL = Pallet((0.6, 0.4), 0.1, 1.0, 200.0)


def order_of(seed: int, n: int) -> PalletOrder:
    return replace(random_pallet_order(n, seed), pallet=Pallet((0.8, 0.6), 0.144, 1.4))


def corners_between(lower: Placement, upper: Placement) -> Array:
    """Corners (4, 2) of the contact of two cartons."""
    low = np.maximum(lower.low, upper.low)[:2]
    high = np.minimum(lower.high, upper.high)[:2]
    return np.array([low, (high[0], low[1]), high, (low[0], high[1])])


def can_balance(placements: tuple[Placement, ...], off: Array | None = None) -> bool:
    """Whether forces that only press, at the corners of all contacts, balance every carton.

    off: (N, 2) by which the centre of each is off its middle, as a share of its sides
    """
    index = {p.carton.id: k for k, p in enumerate(placements)}
    columns: list[Array] = []
    for upper in placements:
        bearers = [p for p in placements if p.carton.id in upper.rests_on]
        ground = replace(upper, low=upper.low - (0.0, 0.0, upper.size[2]))
        for lower in bearers or [ground]:
            for x, y in corners_between(lower, upper).tolist():
                column = np.zeros(3 * len(placements))
                column[3 * index[upper.carton.id] :][:3] = 1.0, x, y
                if bearers:
                    column[3 * index[lower.carton.id] :][:3] = -1.0, -x, -y
                columns.append(column)
    shares = np.zeros((len(placements), 2)) if off is None else off
    centres = [p.centre[:2] + share * p.size[:2] for p, share in zip(placements, shares, strict=True)]
    masses = [p.carton.mass for p in placements]
    weights = np.concatenate([m * np.array([1.0, *c]) for m, c in zip(masses, centres, strict=True)])
    A = np.array(columns).T
    return bool(linprog(np.zeros(A.shape[1]), A_eq=A, b_eq=weights, bounds=(0, None)).status == 0)


@pytest.mark.parametrize("look_ahead", [None, 0, 2])
@given(seed=st.integers(0, 10_000), n=st.integers(1, 14))
@settings(deadline=None, max_examples=12)
def test_every_carton_stands_where_it_has_room_and_at_any_time(
    look_ahead: int | None, seed: int, n: int
) -> None:
    order = order_of(seed, n)
    stack = stack_all(order, seed) if look_ahead is None else stack_as_they_come(order, look_ahead)
    pallet, placed = order.pallet, stack.placements
    assert {p.carton.id for p in placed} | stack.left.keys() == {carton.id for carton in order.cartons}
    for k, p in enumerate(placed):
        assert (np.abs(p.low[:2]) <= np.array(pallet.size) / 2 + 1e-6).all()
        assert (np.abs(p.high[:2]) <= np.array(pallet.size) / 2 + 1e-6).all()
        assert p.low[2] >= 0.0 and p.high[2] + pallet.deck <= pallet.height + 1e-6
        tops = [q.high[2] for q in placed[:k]]
        assert p.from_above > max(tops, default=0.0)
        for q in placed[:k]:  # what is beside its way down, or over it
            across = np.minimum(p.high, q.high)[:2] - np.maximum(p.low, q.low)[:2]
            if (across > -order.clearance + 1e-5).all():
                assert q.high[2] <= p.low[2] + 6e-4
        assert can_balance(placed[: k + 1])
    rng = np.random.default_rng(seed)
    for _ in range(4):
        assert can_balance(placed, 0.05 * rng.choice([-1.0, 1.0], (len(placed), 2)))
    bears = {carton.id: carton.bears for carton in order.cartons}
    assert all(load <= bears[name] + 1e-9 for name, load in loads_on(stack).items())


def test_no_two_cartons_overlap_and_the_engine_agrees_that_they_stand() -> None:
    stack = stack_all(order_of(3, 16))
    assert len(stack.placements) > 8
    for p, q in combinations(stack.placements, 2):
        assert (np.minimum(p.high, q.high) - np.maximum(p.low, q.low)).min() <= 1e-6
    tested = drop_test(stack.order.pallet, stack.placements)
    assert tested.is_stable and tested.sinking < 0.002


def test_what_overhangs_falls_in_the_engine() -> None:
    """The hull that bears it is narrower than half of it: no stacking would put it there."""
    lower, upper = Carton("lower", (0.2, 0.2, 0.2), 2.0), Carton("upper", (0.4, 0.2, 0.1), 2.0)
    base = Placement(lower, np.array([-0.3, -0.1, 0.0]), False, (), EMPTY, 1.0)
    over = Placement(upper, np.array([-0.28, -0.1, 0.2]), False, ("lower",), EMPTY, 1.0)
    tested = drop_test(SMALL, (base, over))
    assert not tested.is_stable
    assert [reason.where for reason in tested.reasons] == ["upper"]
    assert not can_balance((base, over))


@pytest.mark.parametrize(("overhang", "stands"), [(0.005, False), (-0.005, True)])
def test_nothing_is_put_on_what_has_begun_to_tip(overhang: float, stands: bool) -> None:
    """A plank whose middle is 5 mm beyond its block; the counterweight that comes next would hold it."""
    block, plank = Carton("block", (0.4, 0.4, 0.2), 10.0), Carton("plank", (0.8, 0.4, 0.04), 3.0)
    weight = Carton("weight", (0.1, 0.4, 0.1), 10.0)
    left = overhang - 0.4
    placed = (
        Placement(block, np.array([-0.4, -0.2, 0.0]), False, (), EMPTY, 1.0),
        Placement(plank, np.array([left, -0.2, 0.2]), False, ("block",), EMPTY, 1.0),
        Placement(weight, np.array([left, -0.2, 0.24]), False, ("plank",), EMPTY, 1.0),
    )
    assert can_balance(placed) and can_balance(placed[:2]) is stands
    assert drop_test(Pallet(), placed).is_stable is stands


def test_what_moves_in_the_engine_is_left_with_all_that_comes_after_it() -> None:
    """The engine gives way where the mass on a carton is five hundred times its own."""
    light = tuple(Carton(f"light_{k}", (0.4, 0.3, 0.2), 0.2) for k in range(2))
    heavy = tuple(Carton(f"heavy_{k}", (0.4, 0.3, 0.2), 100.0) for k in range(3))
    order = PalletOrder(Pallet((0.45, 0.35), 0.144, 2.0), (*light, *heavy))
    whole = stack_as_they_come(order)
    assert len(whole.placements) == 5 and can_balance(whole.placements)
    assert not drop_test(order.pallet, whole.placements).is_stable
    kept, tested = what_stands(whole)
    n = len(kept.placements)
    assert tested.is_stable and 2 <= n < 5 and kept.placements == whole.placements[:n]
    assert not drop_test(order.pallet, whole.placements[: n + 1]).is_stable
    assert list(kept.left) == [carton.id for carton in order.cartons[n:]]


def test_what_a_sequence_left_comes_earlier_in_the_next() -> None:
    """No sequence that is sorted stacks all of this order; one that is repaired does."""
    order = order_of(6, 26)
    assert len(stack_all(order, 3).placements) == 26
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pickcli.palletizing.stacking.N_REPAIRED", 0)
        assert len(stack_all(order, 3).placements) < 26


@pytest.mark.parametrize("size", [(0.38, 0.28, 0.25), (0.28, 0.38, 0.25)])
def test_cartons_that_are_alike_lie_along_one_side(size: tuple[float, float, float]) -> None:
    cartons = tuple(Carton(f"m_{k}", size, 4.0) for k in range(8))
    assert len(stack_all(PalletOrder(Pallet(height=0.4), cartons)).placements) == 8


def test_neighbours_that_only_touch_bear_nothing_and_limits_may_be_met() -> None:
    """Two layers of twelve, side by side without a gap: each carton bears exactly the one above it."""
    cartons = tuple(Carton(f"b_{k}", (0.4, 0.2, 0.2), 5.0, bears=5.0) for k in range(24))
    stack = stack_all(PalletOrder(Pallet(height=0.6), cartons, clearance=0.0))
    assert len(stack.placements) == 24
    assert sorted(len(p.rests_on) for p in stack.placements) == [0] * 12 + [1] * 12
    thirds = tuple(Carton(f"t_{k}", (0.3, 0.3, 0.1), 0.1) for k in range(3))
    assert len(stack_all(PalletOrder(Pallet(bears=0.3), thirds)).placements) == 3


@pytest.mark.parametrize(("width", "stands"), [(0.56, True), (0.54, False)])
def test_a_middle_that_may_be_off_by_a_twentieth_is_over_what_bears_it(width: float, stands: bool) -> None:
    """A plank of 1 m on one end of its pallet's blocks: its middle may be off by 50 mm."""
    block = Carton("block", (width, 0.4, 0.2), 5.0)
    plank = Carton("plank", (1.0, 0.4, 0.05), 2.0)
    stack = stack_as_they_come(PalletOrder(Pallet((1.0, 0.4), 0.0, 1.0), (block, plank)))
    assert (len(stack.placements) == 2) is stands


def test_as_cartons_come_the_sequence_is_theirs() -> None:
    order = order_of(5, 14)
    ids = [carton.id for carton in order.cartons]
    for look_ahead in (0, 3):
        placed = [p.carton.id for p in stack_as_they_come(order, look_ahead).placements]
        assert placed == [name for name in ids if name in placed]


def test_heavy_cartons_stand_below_what_cannot_bear_them() -> None:
    light = Carton("light", (0.59, 0.39, 0.2), 1.0, bears=1.5)
    heavy = Carton("heavy", (0.59, 0.39, 0.2), 10.0, bears=50.0)
    placed = stack_all(PalletOrder(SMALL, (light, heavy))).placements
    assert [p.carton.id for p in placed] == ["heavy", "light"]
    stack = stack_as_they_come(PalletOrder(SMALL, (light, heavy)))
    assert "would crush what bears it" in stack.left["heavy"].summary()


@pytest.mark.parametrize(
    ("carton", "told"),
    [
        (Carton("tall", (0.3, 0.3, 0.95), 1.0), "no room"),
        (Carton("heavy", (0.3, 0.3, 0.1), 201.0), "the pallet bears 200 kg"),
    ],
)
def test_what_has_no_place_says_why(carton: Carton, told: str) -> None:
    stack = stack_all(PalletOrder(SMALL, (carton,)))
    assert not stack.placements and stack.share_placed == stack.fill == 0.0
    assert told in stack.left[carton.id].summary()


def test_the_same_seed_gives_the_same_stack() -> None:
    order = order_of(8, 14)
    tested = drop_test(order.pallet, ())
    first, again = (stack_to_dict(StackedPallet.of(stack_all(order, 4), tested)) for _ in range(2))
    assert first == again
