"""Choice of targets: criteria in their order, lines of the order at last."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from hypothesis import given
from hypothesis import strategies as st

from pickcli.strategy.node_types import ActionKind, Criterion
from pickcli.strategy.target_choice import best_action, first_target
from pickcli.strategy.trial_actions import OpenTarget

ITEMS, BINS = ("a", "b", "c"), ("bin_A", "bin_B")
RATES = st.dictionaries(st.sampled_from(ActionKind), st.floats(0, 3), max_size=2)
TARGETS = st.lists(
    st.builds(
        OpenTarget, st.integers(0, 9), st.sampled_from(ITEMS), st.sampled_from(BINS), st.integers(0, 20),
        st.integers(0, 3), st.integers(0, 5), st.booleans(), RATES,
    ),
    max_size=6, unique_by=lambda target: target.index,
)  # fmt: skip


@given(TARGETS, st.randoms())
def test_the_best_action_does_not_depend_on_the_order_of_the_targets(
    targets: list[OpenTarget], rng: Random
) -> None:
    best = best_action(targets)
    rng.shuffle(targets)
    assert best == best_action(targets)
    assert (best is None) == (not any(target.rates for target in targets))
    if best is not None:
        assert best[0].rates[best[1]] == max(rate for t in targets for rate in t.rates.values())


@given(TARGETS, st.lists(st.sampled_from(Criterion), min_size=1, max_size=3, unique=True))
def test_the_first_target_is_not_behind_another_by_the_first_criterion(
    targets: list[OpenTarget], by: list[Criterion]
) -> None:
    found = first_target(targets, by, items=("b", "a"), bins=("bin_B",))
    if found is None:
        assert not targets
        return
    rank = {"b": 0, "a": 1}
    oracle: Callable[[OpenTarget], float] = {
        Criterion.POINTS: lambda t: -t.points,
        Criterion.POINTS_PER_SECOND: lambda t: -max(t.rates.values(), default=0.0),
        Criterion.FEWEST_ITEMS: lambda t: t.n_items,
        Criterion.FEWEST_ATTEMPTS: lambda t: t.n_attempts,
        Criterion.ITEM_PRIORITY: lambda t: rank.get(t.item, 2),
        Criterion.BIN_PRIORITY: lambda t: 0 if t.bin == "bin_B" else 1,
        Criterion.ORDER: lambda t: t.index,
    }[by[0]]
    assert oracle(found) == min(oracle(target) for target in targets)
    same = [target for target in targets if oracle(target) == oracle(found)]
    if len(by) == 1:
        assert found.index == min(target.index for target in same)


@given(TARGETS, st.integers(1, 4))
def test_targets_with_too_many_attempts_are_left_out(targets: list[OpenTarget], most: int) -> None:
    found = first_target(targets, [Criterion.ORDER], attempts_below=most)
    few = [target for target in targets if target.n_attempts < most]
    assert found == min(few, key=lambda target: target.index, default=None)
