"""A trial of two arms, played by script: which one acts, who is parked before, what it costs and tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import load_workcell
from pickcli.cell.tool import MOVING
from pickcli.cell.workcell import Workcell
from pickcli.motion.plan import RecoveryLevel
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.loop import run_trial
from pickcli.trial.trial_clock import PLANNING_CHARGE
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_record import trial_record
from pickcli.trial.trial_result import ArmSummary, Attempt, Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import summary
from support.order_builders import pick_order
from support.scripted_trial import DURATION, ScriptedTrial, scene_of

ORDER = pick_order(
    {"bin_B": ("crayola_24_ct",), "bin_E": ("jane_eyre_dvd",), "bin_H": ("dove_beauty_bar",)},
    ("bin_B", "crayola_24_ct"),
    ("bin_E", "jane_eyre_dvd"),
    ("bin_H", "dove_beauty_bar"),
)
BOTH = {"crayola_24_ct": ("right",), "jane_eyre_dvd": ("left", "right"), "dove_beauty_bar": ("right",)}


@pytest.fixture(scope="module")
def kth() -> Workcell:
    return load_workcell("apc2016_kth")


def fake_of(kth: Workcell, **scripted: object) -> ScriptedTrial:
    scene = replace(scene_of(ORDER, kth.preferred), cell=kth.preferred)
    q = {"q": np.zeros(len(kth.preferred.robot.joint_names))}
    return ScriptedTrial(scene, cells=dict(kth.arms), **(q | scripted))  # type: ignore[arg-type]


def play(fake: ScriptedTrial, **settings: object) -> TrialResult:
    return run_trial(ORDER, fake.interfaces(), TrialSettings(**settings))  # type: ignore[arg-type]


def moved(fake: ScriptedTrial) -> list[str]:
    return [plan.query.partition(" from ")[0] for plan in fake.executed]


def test_the_arm_that_acted_is_parked_before_another_one_moves(kth: Workcell) -> None:
    fake = fake_of(kth, able=BOTH)
    result = play(fake)
    assert result.items_in_tote == 3
    arm = "right"
    for query, plan in zip(moved(fake), fake.executed, strict=True):
        if query.startswith("park"):
            assert query == f"park {arm}"
            arm = "left" if arm == "right" else "right"
        else:
            assert plan.arm == arm
    assert len(fake.turns) == moved(fake).count("park right") + moved(fake).count("park left") > 0


def test_an_arm_that_acts_again_is_not_parked_between(kth: Workcell) -> None:
    fake = fake_of(kth, able=dict.fromkeys(BOTH, ("right",)))
    play(fake)
    assert not [query for query in moved(fake) if query.startswith("park")] and not fake.turns


@pytest.mark.parametrize(("is_in_state", "n_parkings"), [(True, 0), (False, 1)])
def test_an_arm_that_is_parked_already_does_not_move_again(
    kth: Workcell, is_in_state: bool, n_parkings: int
) -> None:
    """It is parked if its tool is in the state of that configuration, too."""
    parked = kth.parked["right"]
    state = parked.tool_state if is_in_state else MOVING
    fake = fake_of(kth, able=dict.fromkeys(BOTH, ("left",)), q=parked.q, tool_state=state)
    assert play(fake).items_in_tote == 3
    assert fake.turns == ["left"] and moved(fake).count("park right") == n_parkings


def test_an_item_is_toppled_by_an_arm_with_a_cup(kth: Workcell) -> None:
    """The left arm, which has acted last, has a gripper."""
    fake = fake_of(kth)
    runner = AttemptRunner(fake.interfaces(), TrialSettings(), 900.0, lambda *_: None)
    runner.let_move("left")
    target, clock = ORDER.targets[0], runner.clock
    attempt = Attempt(
        target, "crayola_24_ct", 0, 0.0, Outcome.NO_PLAN, into="bin_B", out_of="bin_B", topples=True
    )  # fmt: skip
    plan = runner.toppling(attempt, runner.scene()).plan
    assert plan is not None and plan.arm == "right"
    assert runner.clock.now == pytest.approx(clock.now + PLANNING_CHARGE)


def test_parking_takes_time_and_a_planning_call(kth: Workcell) -> None:
    one, both = fake_of(kth, able=dict.fromkeys(BOTH, ("right",))), fake_of(kth, able=BOTH)
    alone, turns = play(one), play(both)
    n_parked = len(both.turns)
    more = n_parked * (DURATION + PLANNING_CHARGE)
    assert turns.clock - alone.clock == pytest.approx(more)


def test_another_arm_is_planned_with_from_where_it_is_parked(kth: Workcell) -> None:
    fake = fake_of(kth, able=dict.fromkeys(BOTH, ("left",)))
    starts = []
    interfaces = fake.interfaces()

    def plan(scene, query, start, seed, certify):  # type: ignore[no-untyped-def]
        starts.append((scene.cell.arm, start.q.tolist()))
        return fake.plan(scene, query, start, seed, certify)

    run_trial(ORDER, replace(interfaces, plan=plan), TrialSettings())
    assert starts[0] == ("left", kth.parked["left"].q.tolist())


def test_where_the_first_arm_finds_no_plan_the_next_one_is_asked_and_both_are_charged(kth: Workcell) -> None:
    fake = fake_of(kth, able=dict.fromkeys(BOTH, ("right", "left")))
    interfaces = fake.interfaces()
    asked = []

    def plan(scene, query, start, seed, certify):  # type: ignore[no-untyped-def]
        asked.append(scene.cell.arm)
        if scene.cell.arm == "right":
            fake.no_plan = frozenset((query.item,))
        try:
            return fake.plan(scene, query, start, seed, certify)
        finally:
            fake.no_plan = frozenset()

    result = run_trial(ORDER, replace(interfaces, plan=plan), TrialSettings())
    assert asked == ["right", "left"] * 3
    assert result.arms == {"left": ArmSummary(3, 3), "right": ArmSummary(0, 0)}


def test_what_no_arm_is_able_to_take_is_told_with_the_reason_of_each(kth: Workcell) -> None:
    fake = fake_of(kth, able={"crayola_24_ct": ()})
    result = play(fake)
    told = next(t for t in result.targets if t.target.item == "crayola_24_ct")
    assert told.outcome is Outcome.NO_PLAN
    assert told.reason == "2 times cannot hold it, e.g. arm right, crayola_24_ct: cannot hold it"


def test_an_arm_that_stops_on_its_way_is_brought_out_and_the_attempt_tried_again(kth: Workcell) -> None:
    stopped = ExecutionResult(2.0, stopped="felt a contact", stop_cause=StopCause.CONTACT, path_time=2.0)
    fake = fake_of(kth, able=BOTH, executions={"park right": [stopped]})
    result = play(fake)
    assert result.items_in_tote == 3
    assert RecoveryLevel.AS_PLANNED in fake.levels
    failed = next(a for a in result.attempts if a.outcome is Outcome.NO_PLAN)
    assert failed.reason == "parking arm right: felt a contact" and failed.recovery
    assert failed.parking is stopped and stopped in result.executions


def test_an_arm_that_is_not_parked_in_the_end_leaves_the_other_where_it_is(kth: Workcell) -> None:
    fake = fake_of(kth, able=BOTH, strays=frozenset(("park right",)))
    result = play(fake)
    told = next(t for t in result.targets if t.target.item == "jane_eyre_dvd")
    assert "left" not in fake.turns
    assert told.reason == "it stands elsewhere"


def test_time_that_is_short_for_parking_and_pick_begins_neither(kth: Workcell) -> None:
    fake = fake_of(kth, able=dict.fromkeys(BOTH, ("left",)))
    play(fake, time_limit=1.5 * DURATION)
    assert not fake.executed


def test_the_record_tells_arms_and_why(kth: Workcell) -> None:
    fake = fake_of(kth, able=BOTH)
    result = play(fake)
    record = trial_record(result, "order.json", 0.0)
    assert record["arms"] == {
        "left": {"executed": 1, "delivered": 1},
        "right": {"executed": 2, "delivered": 2},
    }
    by_item = {attempt["item"]: attempt for attempt in record["attempts"]}
    left = by_item["jane_eyre_dvd"]
    assert left["arm"] == "left"
    assert [arm["arm"] for arm in left["arms_ranked"]] == ["left", "right"]
    assert left["parking"]["duration"] == DURATION or by_item["crayola_24_ct"]["parking"] is not None
    assert "arm left: 1 of 1 picks delivered" in summary(result)


def test_a_cell_with_one_arm_tells_nothing_of_arms(kth: Workcell) -> None:
    result = play(ScriptedTrial(scene_of(ORDER, kth.preferred)))
    record = trial_record(result, "order.json", 0.0)
    assert "arms" not in record
    assert not {"arm", "arms_ranked", "parking"} & set(record["attempts"][0])
