"""The sequence of an arm: level by level, the farthest first, and nothing comes below what is there."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.palletizing.arm_sequence import seen_from
from pickcli.palletizing.drop_test import DropTest
from pickcli.palletizing.pallet_order import CONTAINERS, Carton, PalletOrder, least_margin
from pickcli.palletizing.pallet_stack import PalletStack, Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.palletizing.random_pallet_order import CartonBounds, random_pallet_order
from pickcli.palletizing.stack_verification import verify_stack
from pickcli.palletizing.stacking import stack_all
from pickcli.palletizing.support_polygon import rectangle

STILL = DropTest(0.0, 0.0, ())


def random_stack(seed: int) -> PalletStack:
    pallet = replace(CONTAINERS["half_pallet"], height=0.694, edge=0.01)
    sizes = CartonBounds(longest=0.45, heaviest=10.0)
    return stack_all(replace(random_pallet_order(14, seed, pallet, sizes, 0.015), fall=0.006))


@pytest.mark.parametrize("seed", [3, 4])
@pytest.mark.parametrize("side", ["-x", "+x", "-y", "+y"])
def test_the_verifier_accepts_it_and_no_carton_is_lost(seed: int, side: str) -> None:
    stack = random_stack(seed)
    seen = seen_from(stack, side)
    assert not verify_stack(StackedPallet.of(seen, STILL), stack.order).reasons
    assert {p.carton.id for p in seen.placements} == {p.carton.id for p in stack.placements}
    for before, after in zip(seen.placements, seen_from(seen, side).placements, strict=True):
        assert before.carton is after.carton


def on_the_deck(name: str, x: float, y: float, height: float = 0.2) -> Placement:
    carton = Carton(name, (0.2, 0.2, height), 1.0, 100.0)
    low = np.array([x, y, 0.0])
    return Placement(carton, low, False, (), rectangle(low[:2], low[:2] + 0.2), 0.05)


@pytest.mark.parametrize(
    ("side", "names"),
    [("-y", ["far", "near", "high"]), ("+y", ["near", "far", "high"]), ("-x", ["near", "far", "high"])],
)
def test_the_lowest_come_first_and_of_these_the_farthest(side: str, names: list[str]) -> None:
    order = PalletOrder(CONTAINERS["half_pallet"], ())
    placements = (
        on_the_deck("high", -0.3, 0.05, 0.4), on_the_deck("near", 0.0, -0.3), on_the_deck("far", -0.3, -0.2)
    )  # fmt: skip
    far = replace(placements[2], low=np.array([-0.05, 0.05, 0.0]))
    found = seen_from(PalletStack(order, (*placements[:2], far)), side)
    assert [p.carton.id for p in found.placements] == names
    assert [round(p.from_above, 3) for p in found.placements] == [0.05, 0.25, 0.25]


def test_what_hangs_over_another_comes_after_it_though_it_does_not_rest_on_it() -> None:
    """A plank on one block hangs over a lower one, which can come down only before."""
    order = PalletOrder(CONTAINERS["half_pallet"], ())
    block, lower = on_the_deck("block", -0.3, 0.0, 0.3), on_the_deck("lower", -0.09, 0.0, 0.28)
    low = np.array([-0.3, 0.0, 0.3])
    plank = Placement(
        Carton("plank", (0.3, 0.2, 0.01), 1.0), low, False, ("block",), rectangle(low[:2], low[:2] + 0.2), 0.4
    )  # fmt: skip
    found = seen_from(PalletStack(order, (lower, block, plank)), "-y")
    assert [p.carton.id for p in found.placements] == ["lower", "block", "plank"]


def test_a_carton_that_may_fall_stands_farther_inside_of_what_bears_it() -> None:
    """A plank on a narrower block, by hand: over its edge the middle rises by the fall."""
    block, plank = Carton("block", (0.2, 0.2, 0.2), 2.0, 9.0), Carton("plank", (0.24, 0.24, 0.25), 1.0, 9.0)
    pallet = replace(CONTAINERS["half_pallet"], size=(0.25, 0.25))
    margin = least_margin(0.006, 0.25)
    assert np.hypot(margin, 0.125) - 0.125 == pytest.approx(0.006)
    for fall, n in ((0.0, 2), (0.006, 2), (0.02, 2), (0.05, 1)):
        stack = stack_all(PalletOrder(pallet, (block, plank), fall=fall))
        assert len(stack.placements) == n
        if n == 2:
            off = np.abs(stack.placements[1].centre - stack.placements[0].centre)[:2]
            assert 0.1 - off.max() >= least_margin(fall, 0.25) - 1e-9


def test_the_verifier_refuses_a_carton_that_would_tip_as_it_lands() -> None:
    block = on_the_deck("block", -0.1, -0.1, 0.2)
    low, carton = np.array([-0.03, -0.1, 0.2]), Carton("top", (0.2, 0.2, 0.3), 1.0)
    top = Placement(carton, low, False, ("block",), rectangle(low[:2], np.array([0.1, 0.1])), 0.3)
    stack = PalletStack(PalletOrder(CONTAINERS["half_pallet"], (), fall=0.0), (block, top))
    assert not verify_stack(StackedPallet.of(stack, STILL)).reasons
    for fall, whats in ((0.002, []), (0.004, ["would tip as it lands"])):
        verdict = verify_stack(replace(StackedPallet.of(stack, STILL), fall=fall))
        assert [reason.what for reason in verdict.reasons] == whats


def test_cartons_keep_from_edges_that_an_order_states() -> None:
    stack = random_stack(5)
    half = np.array(stack.order.pallet.size) / 2
    assert max(float(np.abs(p.low[:2]).max()) for p in stack.placements) > 0.25
    for p in stack.placements:
        assert (p.low[:2] >= 0.01 - half - 1e-9).all() and (p.high[:2] <= half - 0.01 + 1e-9).all()
    nearer = replace(StackedPallet.of(stack, STILL), pallet=replace(stack.order.pallet, edge=0.02))
    assert "over the edge of the pallet" in {reason.what for reason in verify_stack(nearer).reasons}
