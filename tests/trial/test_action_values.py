"""What comes next: points per second, learning from what happened, and nothing without something new."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.strategy.node_types import ActionKind
from pickcli.strategy.target_choice import best_action
from pickcli.trial.action_values import (
    MOST_CLEARINGS,
    MOST_FAILURES,
    MOST_REFUSALS,
    MOST_REFUSALS_OF_STOW,
    AttemptOutcomes,
    TargetState,
    open_targets,
)
from pickcli.trial.order import ANY_BIN, Target
from pickcli.trial.trial_clock import TrialClock

JOB = TargetState(0, Target("bin_A", "crayola_24_ct"), 10, 12.0)
TARGETS = [Target(f"bin_{b}", item) for b in "ABC" for item in ("crayola_24_ct", "jane_eyre_dvd")]

targets = st.builds(
    TargetState,
    index=st.integers(0, 20),
    target=st.sampled_from(TARGETS),
    points=st.integers(10, 23),
    seconds=st.floats(5.0, 30.0),
    can_hold=st.booleans(),
    attempts=st.integers(0, 9),
    failures=st.integers(0, MOST_FAILURES),
    refusals=st.integers(0, MOST_REFUSALS),
    cleared=st.integers(0, 9),
    clearings=st.integers(0, MOST_CLEARINGS),
)


def chosen(
    *candidates: TargetState, outcomes: AttemptOutcomes | None = None, may_clear: bool = True
) -> TargetState:
    best = best_action(open_targets(candidates, outcomes or AttemptOutcomes(), may_clear, {}))
    assert best is not None
    return next(state for state in candidates if state.index == best[0].index)


def rates(state: TargetState, may_clear: bool = True) -> dict[ActionKind, float]:
    """Expected points per second of each action for a target by itself."""
    return {
        kind: rate
        for found in open_targets([state], AttemptOutcomes(), may_clear, {})
        for kind, rate in found.rates.items()
    }


@given(st.lists(targets, max_size=8, unique_by=lambda state: state.index), st.booleans())
def test_open_targets_are_those_with_an_action_in_the_order_of_their_lines(
    candidates: list[TargetState], may: bool
) -> None:
    found = open_targets(candidates, AttemptOutcomes(), may, {"bin_A": 3})
    assert found == open_targets(list(reversed(candidates)), AttemptOutcomes(), may, {"bin_A": 3})
    possible = [state.index for state in candidates if state.can_pick or (may and state.can_clear)]
    assert [target.index for target in found] == sorted(possible)
    assert all(target.n_items == (3 if target.bin == "bin_A" else 0) for target in found)


def test_more_points_or_less_time_come_first_and_what_failed_waits() -> None:
    richer = replace(JOB, index=1, points=20)
    faster = replace(JOB, index=2, seconds=5.0)
    assert chosen(JOB, richer) is richer
    assert chosen(JOB, richer, faster) is faster
    assert chosen(JOB, richer.failed().failed()) is JOB
    assert chosen(JOB, richer.refused()) is JOB


def test_what_happened_to_the_same_item_or_in_the_same_bin_counts() -> None:
    same_item = replace(JOB, index=1, target=Target("bin_B", "crayola_24_ct"))
    same_bin = replace(JOB, index=2, target=Target("bin_A", "jane_eyre_dvd"))
    other = replace(JOB, index=3, target=Target("bin_C", "dove_beauty_bar"))
    outcomes = AttemptOutcomes()
    outcomes.note(JOB.target, is_success=False)
    assert chosen(same_item, same_bin, other, outcomes=outcomes) is other
    for _ in range(3):
        outcomes.note(JOB.target, is_success=True)
    outcomes.note(other.target, is_success=False)
    assert chosen(other, same_item, outcomes=outcomes) is same_item


@given(targets)
def test_in_a_scene_that_does_not_change_nothing_is_left_in_the_end(state: TargetState) -> None:
    for _ in range(MOST_FAILURES + MOST_REFUSALS + MOST_CLEARINGS + 20):
        best = best_action(open_targets([state], AttemptOutcomes(), True, {}))
        if best is None:
            return
        is_pick = best[1] is ActionKind.PICK
        clearings = state.clearings + (not is_pick)
        state = replace(state.tried().refused() if is_pick else state, clearings=clearings)
    pytest.fail("actions without end")


def test_an_unchanged_heap_is_looked_at_less_often() -> None:
    stowing = replace(JOB, target=replace(JOB.target, into=ANY_BIN))
    assert replace(stowing, refusals=MOST_REFUSALS_OF_STOW - 1).can_pick
    assert not replace(stowing, refusals=MOST_REFUSALS_OF_STOW).can_pick
    assert replace(JOB, refusals=MOST_REFUSALS_OF_STOW).can_pick


def test_a_changed_scene_gives_new_looks_but_no_new_failures() -> None:
    spent = replace(JOB, refusals=MOST_REFUSALS, clearings=MOST_CLEARINGS)
    assert not spent.can_pick and not spent.can_clear
    assert spent.renewed().can_pick
    assert not replace(spent, failures=MOST_FAILURES).renewed().can_pick


def test_what_failed_comes_later_if_nothing_that_it_blamed_has_moved() -> None:
    state = JOB.tried().refused()
    doubted = rates(state.renewed(is_doubted=True))[ActionKind.PICK]
    fresh = rates(state.renewed())[ActionKind.PICK]
    assert 0.0 < doubted < fresh
    assert not state.renewed(is_doubted=True).tried().is_doubted


def test_something_is_moved_aside_only_for_what_was_refused_and_where_the_rules_let_it() -> None:
    assert set(rates(JOB.refused())) == {ActionKind.PICK, ActionKind.CLEAR}
    assert set(rates(JOB)) == {ActionKind.PICK}
    assert set(rates(JOB.refused(), may_clear=False)) == {ActionKind.PICK}


def test_what_the_tool_cannot_hold_is_asked_for_once_and_last() -> None:
    hopeless = replace(JOB, points=23, can_hold=False)
    assert chosen(hopeless, replace(JOB, index=1).failed().refused()).index == 1
    assert rates(hopeless.tried().refused()) == {}


def test_what_would_lie_on_waiting_targets_waits_for_three_looks_at_each_of_them() -> None:
    """Whatever else is open comes first, and what is brought there all the same in the end."""
    hiding = replace(JOB, target=Target("bin_B", "crayola_24_ct", "bin_A"))
    waiting = replace(JOB, index=1, target=Target("bin_A", "jane_eyre_dvd", "bin_C"))
    elsewhere = replace(JOB, index=2, target=Target("bin_B", "jane_eyre_dvd", "bin_C"))
    assert chosen(hiding, waiting, may_clear=False) is waiting
    for n_refusals in range(1, 3):
        looked_at = replace(waiting, refusals=n_refusals)
        assert chosen(hiding, looked_at, may_clear=False) is looked_at
        assert chosen(hiding, looked_at, elsewhere, may_clear=False) is elsewhere
    assert chosen(hiding, replace(waiting, refusals=3), may_clear=False) is hiding
    assert (
        chosen(hiding, elsewhere, may_clear=False) is hiding
    )  # nothing waits there any more: the order's line decides


def test_a_known_duration_replaces_the_estimate() -> None:
    assert JOB.timed(7.5).seconds == 7.5
    assert JOB.tried().seconds == JOB.seconds and JOB.tried().attempts == 1


@given(st.integers(0, 50), st.floats(0, 500), st.floats(0, 1000))
def test_the_clock_adds_motion_and_planning_calls(n_plans: int, motion: float, ask: float) -> None:
    clock = TrialClock(900.0).moved(motion)
    for _ in range(n_plans):
        clock = clock.planned()
    assert clock.now == pytest.approx(motion + n_plans * clock.charge)
    assert clock.has_time_for(ask) == (clock.now + ask <= 900.0)
    assert 0.0 <= clock.left <= 900.0
