"""After a stop: the item first, then the arm; nothing gives up before the time is over."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fake_crew import DURATION, FakeCrew, scene_of
from order_builders import pick_order

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.motion.plan import RecoveryLevel
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order
from pickcli.trial.player import TrialSettings
from pickcli.trial.ports import Execution
from pickcli.trial.recovery import FIRST_WAIT, LET_GO, LONGEST_WAIT, WAIT
from pickcli.trial.result import Attempt, Outcome, TrialResult

ITEM = "scotch_duct_tape"
ORDER = pick_order(
    {"bin_A": (ITEM, "jane_eyre_dvd"), "bin_C": ("dove_beauty_bar",)},
    ("bin_A", ITEM),
    ("bin_C", "dove_beauty_bar"),
)
DENIED = Execution(
    4.0, "the sensor reads nothing", has_item=False, stop_cause=StopCause.SENSOR, path_time=4.0
)
HIT = Execution(4.0, "contact", has_item=True, stop_cause=StopCause.CONTACT, path_time=4.0)
BURST = Execution(4.0, "seal lost", has_item=False, stop_cause=StopCause.SEAL_LOST, path_time=4.0)
ALL = frozenset(RecoveryLevel)


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell("apc2016_delft")


def fake_with(cell: Cell, *executions: Execution, clings: bool = False) -> FakeCrew:
    """The item's first executions are scripted; while it clings it stays in the cup."""
    fake = FakeCrew(scene_of(ORDER, cell), clings=frozenset({ITEM} if clings else ()))
    fake.executions[ITEM] = list(executions)
    return fake


def play(fake: FakeCrew, order: Order = ORDER, **settings: object) -> TrialResult:
    return run_trial(order, fake.crew(), TrialSettings(**settings))  # type: ignore[arg-type]


def first_attempt(result: TrialResult) -> Attempt:
    return next(a for a in result.attempts if a.item == ITEM)


def steps(result: TrialResult) -> list[str]:
    return [step.what for step in first_attempt(result).recovery]


def test_an_item_seen_in_its_bin_is_not_looked_for_in_the_cup(cell: Cell) -> None:
    result = play(fake_with(cell, DENIED))
    assert steps(result) == [LET_GO, RecoveryLevel.AS_PLANNED]
    assert first_attempt(result).outcome is Outcome.NOT_PICKED
    assert result.items_in_tote == 2 and result.is_clean


def test_what_a_lying_sensor_denies_is_brought_over_the_tote_before_it_is_let_go(cell: Cell) -> None:
    fake = replace(fake_with(cell, DENIED, clings=True), lying_sensor=True)
    result = play(fake)
    assert steps(result) == ["bring on", LET_GO, RecoveryLevel.AS_PLANNED]
    # The look sees it in the tote, whatever the sensor said.
    assert first_attempt(result).outcome is Outcome.IN_TOTE
    assert result.score.total == result.score.maximum


def test_what_is_held_when_something_is_hit_goes_back_into_its_bin(cell: Cell) -> None:
    result = play(fake_with(cell, HIT, clings=True))
    assert steps(result) == ["bring back", LET_GO, RecoveryLevel.AS_PLANNED]
    assert first_attempt(result).seen_in == first_attempt(result).truly_in == "bin_A"
    assert result.items_in_tote == 2 and result.is_clean


@pytest.mark.parametrize(("execution", "first"), [(DENIED, "bring on"), (HIT, "bring back")])
def test_an_item_is_vented_where_it_is_only_where_it_can_be_brought_nowhere(
    cell: Cell, execution: Execution, first: str
) -> None:
    fake = replace(fake_with(cell, execution, clings=True), no_plan=frozenset({"bring on", "bring back"}))
    result = play(fake)
    assert steps(result)[0] == first
    assert steps(result)[1:] == [{"bring on": "bring back", "bring back": "bring on"}[first], LET_GO,
                                 RecoveryLevel.AS_PLANNED]  # fmt: skip


def test_after_the_vacuum_broke_down_nothing_is_brought_anywhere(cell: Cell) -> None:
    fake = fake_with(cell, BURST)
    execute = fake.execute

    def lose(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is BURST:
            fake.put(ITEM, OUTSIDE)
        return done

    fake.execute = lose  # type: ignore[method-assign]
    result = play(fake)
    assert steps(result) == [LET_GO, RecoveryLevel.AS_PLANNED]
    assert first_attempt(result).outcome is Outcome.LOST
    assert (first_attempt(result).seen_in, first_attempt(result).truly_in) == ("", OUTSIDE)
    assert result.items_in_tote == 1


@pytest.mark.parametrize("n_failing", range(len(RecoveryLevel) + 1))
def test_the_levels_are_tried_from_the_strictest_on(cell: Cell, n_failing: int) -> None:
    levels = list(RecoveryLevel)
    fake = fake_with(cell, DENIED)
    fake.stuck = [frozenset(levels[:n_failing]), frozenset()]
    result = play(fake)
    tried = steps(result)[1:]
    assert tried[: min(n_failing + 1, len(levels))] == levels[: min(n_failing + 1, len(levels))]
    assert result.items_in_tote == 2 and result.is_clean
    if n_failing >= levels.index(RecoveryLevel.SLOWLY):
        # Slow motions only come free; the strict levels bring the arm home from there.
        assert tried[-1] == RecoveryLevel.AS_PLANNED


def test_what_stops_on_the_way_out_is_looked_at_and_tried_again(cell: Cell) -> None:
    fake = fake_with(cell, DENIED)
    fake.executions["recover as planned"] = [HIT, HIT]
    result = play(fake)
    # What has just met something is not repeated.
    assert steps(result)[1:] == [RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING]
    assert [step.reason for step in first_attempt(result).recovery][1:] == ["contact", ""]
    assert result.items_in_tote == 2


def test_where_no_level_leads_out_it_waits_looks_and_tries_with_another_seed(cell: Cell) -> None:
    fake = fake_with(cell, DENIED)
    fake.stuck = [ALL, ALL, frozenset()]
    result = play(fake)
    assert steps(result).count(WAIT) == 2
    waits = [w for w in fake.waited if w >= FIRST_WAIT]
    assert waits == [FIRST_WAIT, 2 * FIRST_WAIT]
    seeds = [plan.seed for plan in fake.executed if plan.query.startswith("recover")]
    assert len(set(seeds)) == len(seeds)
    assert result.items_in_tote == 2 and result.is_clean


@pytest.mark.parametrize("fault", ["no way", "rejected"])
def test_only_time_ends_a_trial_and_what_was_tried_is_recorded(cell: Cell, fault: str) -> None:
    fake = fake_with(cell, DENIED)
    if fault == "no way":
        fake.stuck = [ALL]
    else:
        fake = replace(fake, rejects=frozenset({"recover"}))
    result = play(fake)
    assert result.clock == pytest.approx(900.0, abs=LONGEST_WAIT)
    assert "before the time was over" in result.aborted and not result.is_clean
    reasons = {step.reason for step in first_attempt(result).recovery if step.what in ALL}
    assert all(reasons)
    assert len(fake.levels) <= 200  # bounded work, however long the trial
    assert {t.outcome for t in result.targets} == {Outcome.NOT_PICKED, Outcome.NO_TIME}


def test_nothing_moves_past_the_time_limit_on_the_way_out_either(cell: Cell) -> None:
    fake = fake_with(cell, DENIED)
    result = play(fake, time_limit=DURATION + 8.0)
    assert result.clock <= DURATION + 8.0
    assert not any(plan.query.startswith("recover") for plan in fake.executed)
    assert result.aborted == ""  # there was a way out, and no time for it


def test_belief_and_truth_are_both_recorded_and_their_difference_counted(cell: Cell) -> None:
    """A tote that swallows: the robot saw nothing wrong but the item lies on the floor."""
    fake = fake_with(cell)
    execute = fake.execute

    def swallow(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if "dove_beauty_bar" in plan.query:
            fake.put("dove_beauty_bar", OUTSIDE)
        return done

    fake.execute = swallow  # type: ignore[method-assign]
    result = play(fake)
    swallowed = next(a for a in result.attempts if a.item == "dove_beauty_bar")
    assert swallowed.outcome is Outcome.LOST and "not seen again" in swallowed.reason
    assert result.n_misjudged == 0 and result.items_in_tote == 1
