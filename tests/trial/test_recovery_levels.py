"""After a stop: the item first, then the arm; nothing gives up before the time is over."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import RecoveryLevel
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.plan_run import END_TIME
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.loop import run_trial
from pickcli.trial.order import Order
from pickcli.trial.recovery_levels import FIRST_WAIT, LET_GO, MOST_STOPPED, WAIT
from pickcli.trial.trial_clock import PLANNING_CHARGE
from pickcli.trial.trial_interfaces import ARRIVAL, ExecutionResult
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import Attempt, Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import summary
from support.order_builders import pick_order
from support.scripted_trial import DURATION, ScriptedTrial, scene_of

ITEM = "scotch_duct_tape"
ORDER = pick_order(
    {"bin_A": (ITEM, "jane_eyre_dvd"), "bin_C": ("dove_beauty_bar",)},
    ("bin_A", ITEM),
    ("bin_C", "dove_beauty_bar"),
)
DENIED = ExecutionResult(
    4.0, "the sensor reads nothing", has_item=False, stop_cause=StopCause.SENSOR, path_time=4.0
)
HIT = ExecutionResult(4.0, "contact", has_item=True, stop_cause=StopCause.CONTACT, path_time=4.0)
ALL = frozenset(RecoveryLevel)


def fake_with(cell: Cell, *executions: ExecutionResult, clings: bool = False) -> ScriptedTrial:
    """The item's first executions are scripted; while it clings it stays in the cup."""
    fake = ScriptedTrial(scene_of(ORDER, cell), clings=frozenset({ITEM} if clings else ()))
    fake.executions[ITEM] = list(executions)
    return fake


def play(fake: ScriptedTrial, order: Order = ORDER, **settings: object) -> TrialResult:
    return run_trial(order, fake.interfaces(), TrialSettings(**settings))  # type: ignore[arg-type]


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
    cell: Cell, execution: ExecutionResult, first: str
) -> None:
    fake = replace(fake_with(cell, execution, clings=True), no_plan=frozenset({"bring on", "bring back"}))
    result = play(fake)
    assert steps(result)[0] == first
    assert steps(result)[1:] == [{"bring on": "bring back", "bring back": "bring on"}[first], LET_GO,
                                 RecoveryLevel.AS_PLANNED]  # fmt: skip


@pytest.mark.parametrize(
    "cause", [StopCause.SEAL_LOST, StopCause.NOT_SEALED, StopCause.GRASP_LOST, StopCause.NOT_GRASPED]
)
def test_after_the_tool_measured_that_it_is_empty_nothing_is_brought_anywhere(
    cell: Cell, cause: StopCause
) -> None:
    lost = ExecutionResult(4.0, str(cause), has_item=False, stop_cause=cause, path_time=4.0)
    fake = fake_with(cell, lost)
    execute = fake.execute

    def lose(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is lost:
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


def test_what_is_stopped_again_and_again_from_one_place_is_left_alone(cell: Cell) -> None:
    """An arm that cannot move on, whatever it does, touches something a few times and no more."""
    fake = fake_with(cell, DENIED)
    at_once = replace(HIT, duration=0.1, path_time=0.0)
    for level in RecoveryLevel:
        fake.executions[f"recover {level}"] = [at_once] * 500
    result = play(fake)
    moved = [step.what for step in first_attempt(result).recovery[1:] if step.execution is not None]
    assert {level: moved.count(level) for level in RecoveryLevel} == dict.fromkeys(
        RecoveryLevel, MOST_STOPPED
    )
    assert "before the time was over" in result.aborted


def test_what_was_stopped_from_one_place_is_tried_from_another(cell: Cell) -> None:
    fake = fake_with(cell, DENIED)
    at_once = replace(HIT, duration=0.1, path_time=0.0)
    fake.executions["recover as planned"] = [at_once] * 4
    fake.stuck = [ALL - {RecoveryLevel.AS_PLANNED}]
    execute = fake.execute

    def drift(plan):  # type: ignore[no-untyped-def]
        fake.q = fake.q + 0.015 * plan.query.startswith("recover")
        return execute(plan)

    fake.execute = drift  # type: ignore[method-assign]
    result = play(fake)
    moved = [step.what for step in first_attempt(result).recovery[1:] if step.execution is not None]
    assert moved == [RecoveryLevel.AS_PLANNED] * 5 and result.is_clean


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
    assert 900.0 - 2.0 * PLANNING_CHARGE < result.clock <= 900.0
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
    # There was a way out, and no time for it: that is the end of the time, and no arm that cannot leave.
    assert result.aborted == "" and result.is_clean
    assert "the time was over with the arm on its way out" in result.cut_short
    assert f"takes {DURATION:.1f} s" in result.cut_short
    assert trial_record(result, "order.json", 1.0)["cut_short"] in summary(result)


def test_where_the_time_ends_and_nothing_led_out_the_trial_is_aborted(cell: Cell) -> None:
    fake = replace(fake_with(cell, DENIED), stuck=[ALL])
    result = play(fake, time_limit=40.0)
    assert "before the time was over" in result.aborted and result.cut_short == ""
    assert not result.is_clean and result.clock <= 40.0


def test_a_way_for_which_there_is_no_time_does_not_end_a_recovery_for_which_there_is(cell: Cell) -> None:
    """The item would be brought too far; the arm comes out slowly first, and home from there."""
    fake = fake_with(cell, DENIED, clings=True)
    fake = replace(fake, lying_sensor=True, durations={"bring": 60.0, "recover": 1.0})
    fake.stuck = [ALL - {RecoveryLevel.SLOWLY}, frozenset()]
    result = play(fake, time_limit=40.0)
    assert steps(result)[:3] == ["bring on", "bring back", LET_GO]
    assert steps(result)[-2:] == [RecoveryLevel.SLOWLY, RecoveryLevel.AS_PLANNED]
    assert result.aborted == result.cut_short == ""


def test_of_several_ways_out_a_shorter_one_is_taken_where_the_first_takes_too_long(cell: Cell) -> None:
    fake = replace(fake_with(cell, DENIED), durations={"recover as planned": 30.0, "recover": 2.0})
    result = play(fake, time_limit=30.0)
    assert steps(result)[1:] == [RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING]
    assert result.aborted == result.cut_short == ""


def test_what_is_still_in_the_cup_when_the_time_ends_stays_there(cell: Cell) -> None:
    fake = fake_with(cell, replace(HIT, duration=10.0, path_time=10.0), clings=True)
    limit = DEFAULT.look_time + PLANNING_CHARGE + DURATION + 0.1 + DEFAULT.look_time
    fake.executions[ITEM][0] = replace(fake.executions[ITEM][0], duration=limit - 2.7)  # it was met late
    result = play(fake, time_limit=limit)
    last = first_attempt(result).recovery[-1]
    assert last.what == LET_GO and "time was over" in last.reason and last.execution is None
    assert result.clock <= limit and fake.held == ITEM
    assert "before the item had been let go" in result.cut_short


def test_back_along_a_motion_that_began_in_the_pod_is_not_out(cell: Cell) -> None:
    """Slowly to some place in the pod, on from there until something is met, back to that place, and home."""
    fake = fake_with(cell, DENIED)
    fake.stuck = [ALL - {RecoveryLevel.SLOWLY}, frozenset({RecoveryLevel.OPENING}), frozenset()]
    fake.executions["recover as planned"] = [HIT]
    result = play(fake)
    moved = [step.what for step in first_attempt(result).recovery if step.execution is not None]
    assert moved[1:] == [
        RecoveryLevel.SLOWLY, RecoveryLevel.AS_PLANNED, RecoveryLevel.BACKWARDS, RecoveryLevel.AS_PLANNED
    ]  # fmt: skip
    assert result.is_clean


def test_what_stopped_where_it_began_is_no_way_back(cell: Cell) -> None:
    """On its way home something is met at once: back goes the motion before that."""
    fake = fake_with(cell, DENIED)
    fake.stuck = [ALL - {RecoveryLevel.AS_PLANNED}, ALL - {RecoveryLevel.BACKWARDS}]
    fake.executions["recover as planned"] = [replace(HIT, path_time=0.0)]
    result = play(fake)
    moved = [step.what for step in first_attempt(result).recovery if step.execution is not None]
    assert moved[1:] == [RecoveryLevel.AS_PLANNED, RecoveryLevel.BACKWARDS]
    assert result.is_clean


def test_what_is_seen_elsewhere_is_not_brought_whatever_closes_the_cup(cell: Cell) -> None:
    fake = replace(fake_with(cell, HIT), clogged=True)
    result = play(fake, time_limit=30.0)
    assert steps(result)[0] == LET_GO
    assert not any(plan.query.startswith("bring") for plan in fake.executed)


def test_what_is_seen_where_the_cup_would_have_it_is_brought_back(cell: Cell) -> None:
    fake = replace(fake_with(cell, HIT), clogged=True)
    item = fake.scene.find(ITEM)
    # The fake's grasps have the tip in the middle of the item.
    tip = Arm(cell.robot).tip(fake.q, fake.tool_state)
    execute = fake.execute

    def hang(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is HIT:
            fake.scene = fake.scene.moved(replace(item, T_world_item=tip))
        return done

    fake.execute = hang  # type: ignore[method-assign]
    result = play(fake, time_limit=30.0)
    assert steps(result)[0] == "bring back"


def test_what_was_not_let_go_at_the_end_goes_back_to_where_it_should_have_been(cell: Cell) -> None:
    missed = ExecutionResult(DURATION, has_item=True, missed=("valve off",))
    result = play(fake_with(cell, missed, clings=True))
    assert steps(result) == ["bring on", LET_GO, RecoveryLevel.AS_PLANNED]
    assert first_attempt(result).outcome is Outcome.IN_TOTE
    assert result.score.total == result.score.maximum


def test_an_execution_ends_as_soon_after_its_plan_as_the_clock_takes_for_granted() -> None:
    assert END_TIME <= ARRIVAL


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
