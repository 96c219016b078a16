"""The trial loop's promises, played without physics, by script."""

from __future__ import annotations

import json
from dataclasses import dataclass, field, replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError, NoPlanError, Reason
from pickcli.motion.plan import Certify, Grasp, GraspKind, Plan
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.progress import Progress
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.reality import DEFAULT, IDEAL
from pickcli.statics.unrecognised import NOT_RECOGNISED
from pickcli.strategy.strategy_tree import Strategy, StrategyNode
from pickcli.trial.action_values import MOST_CLEARINGS, MOST_FAILURES, MOST_REFUSALS
from pickcli.trial.final_state import Drop
from pickcli.trial.loop import _Trial, run_trial
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.trial_clock import PLANNING_CHARGE
from pickcli.trial.trial_interfaces import ARRIVAL, ExecutionResult
from pickcli.trial.trial_perception import BoundedErrors, Touched
from pickcli.trial.trial_record import record_text, trial_record
from pickcli.trial.trial_result import Attempt, Outcome, TrialResult
from pickcli.trial.trial_settings import TrialSettings
from pickcli.trial.trial_summary import rows, summary, why_it_ended
from pickcli.verification.verdict import Verdict
from support.order_builders import pick_order
from support.scripted_trial import DURATION, ScriptedTrial, scene_of

ORDER = pick_order(
    {
        "bin_A": ("crayola_24_ct", "crayola_24_ct"),
        "bin_B": ("dove_beauty_bar", "jane_eyre_dvd", "scotch_duct_tape"),
        "bin_C": ("dasani_water_bottle",),
        "bin_D": ("fitness_gear_3lb_dumbbell",),
    },
    ("bin_A", "crayola_24_ct"),
    ("bin_B", "scotch_duct_tape"),
    ("bin_C", "dasani_water_bottle"),
    ("bin_D", "fitness_gear_3lb_dumbbell"),
)
LOST = ExecutionResult(4.0, stopped="vacuum lost in retreat", has_item=False)
EARLY = ExecutionResult(2.0, stopped="early contact", stop_cause=StopCause.EARLY_CONTACT, path_time=2.0)


def play(fake: ScriptedTrial, order: Order = ORDER, **settings: object) -> TrialResult:
    return run_trial(order, fake.interfaces(), TrialSettings(**settings))  # type: ignore[arg-type]


def outcomes(result: TrialResult) -> dict[str, Outcome]:
    return {t.target.item: t.outcome for t in result.targets}


def test_when_everything_works_the_score_is_the_maximum(cell: Cell) -> None:
    result = play(ScriptedTrial(scene_of(ORDER, cell)))
    assert result.score.total == result.score.maximum
    assert result.items_in_tote == 4
    assert result.is_clean
    assert [t.target for t in result.targets] == list(ORDER.work_order)


def test_the_richest_target_comes_first_and_what_cannot_be_held_last(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell))
    play(fake)
    items = [item for item, _, _ in fake.planned]
    assert items[0] == "scotch_duct_tape"  # 15 + 1 points; the slow bottle gives 12
    assert items[-1] == "fitness_gear_3lb_dumbbell"


def test_lost_vacuum_is_recovered_and_retried_with_a_grasp_of_another_kind(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    tries = [(seed, exclude) for item, seed, exclude in fake.planned if item == "scotch_duct_tape"]
    assert len(tries) == 2
    assert tries[0][0] != tries[1][0]
    assert tries[0][1] == ()
    failed, kind = tries[1][1]
    assert isinstance(failed, Grasp) and kind == GraspKind(failed.kind, failed.face)
    queries = [plan.query for plan in fake.executed]
    assert queries[queries.index("pick scotch_duct_tape") + 1] == "recover as planned"
    first = next(a for a in result.attempts if a.item == "scotch_duct_tape")
    assert first.outcome is Outcome.NOT_PICKED
    assert "vacuum lost in retreat" in first.reason and "bin_B" in first.reason


def test_what_was_seen_wrongly_is_picked_by_the_same_grasp_once_it_is_seen_again(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [EARLY]})
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    assert [exclude for item, _, exclude in fake.planned if item == "scotch_duct_tape"] == [(), ()]
    first = next(a for a in result.attempts if a.item == "scotch_duct_tape")
    assert first.outcome is Outcome.NOT_PICKED and "early contact" in first.reason


def test_retries_go_on_while_a_grasp_is_new_and_end_before_the_time_does(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST] * 5})
    assert outcomes(play(fake))["scotch_duct_tape"] is Outcome.IN_TOTE
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST] * 50})
    result = play(fake)
    assert [item for item, _, _ in fake.planned].count("scotch_duct_tape") == MOST_FAILURES
    assert outcomes(result)["scotch_duct_tape"] is Outcome.NOT_PICKED
    assert result.items_in_tote == 3 and result.clock < 900.0


def test_where_no_other_kind_of_grasp_is_left_another_place_is_taken(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
    plan = fake.plan

    def plan_one_kind(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        found = plan(scene, query, start, seed, certify)
        if any(isinstance(excluded, GraspKind) for excluded in query.exclude):
            raise NoPlanError("pick", [Reason("no face within reach")])
        return found

    fake.plan = plan_one_kind  # type: ignore[method-assign]
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    excluded = [exclude for item, _, exclude in fake.planned if item == "scotch_duct_tape"]
    assert [len(exclude) for exclude in excluded] == [0, 2, 1]


def test_what_got_into_another_bin_is_picked_from_there(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
    execute = fake.execute

    def roll_away(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is LOST:
            fake.put("scotch_duct_tape", "bin_E")
        return done

    fake.execute = roll_away  # type: ignore[method-assign]
    result = play(fake)
    places = [(a.out_of, a.outcome) for a in result.attempts if a.item == "scotch_duct_tape"]
    assert places == [("bin_B", Outcome.LOST), ("bin_E", Outcome.IN_TOTE)]
    assert result.score.total == result.score.maximum


def test_what_is_in_the_way_is_moved_into_the_emptiest_bin_once_all_else_is_done(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), blocked={"scotch_duct_tape": "jane_eyre_dvd"})
    result = play(fake)
    assert result.items_in_tote == 4 and result.is_clean
    assert result.score.total == result.score.maximum
    queries = [plan.query for plan in fake.executed]
    aside, after = queries.index("pick jane_eyre_dvd into bin_C"), queries.index("pick scotch_duct_tape")
    assert aside > queries.index("pick dasani_water_bottle") and after == aside + 1
    # Empty since the bottle was picked, and the first of several by name.
    moved = next(a for a in result.attempts if a.outcome is Outcome.MOVED)
    assert (moved.target.item, moved.item, moved.into) == ("scotch_duct_tape", "jane_eyre_dvd", "bin_C")
    assert result.final.claim is not None
    assert "jane_eyre_dvd" in result.final.claim.bin_contents["bin_C"]


@dataclass(frozen=True)
class Hiding(BoundedErrors):
    """Perception to which one item hides another as long as it is in its bin; it names what hides most."""

    hidden: str = "scotch_duct_tape"
    by: str = "jane_eyre_dvd"
    names: tuple[str, ...] = ("jane_eyre_dvd", "dove_beauty_bar")
    home: str = "bin_B"
    last: list[Scene] = field(default_factory=list)

    def look(self, true: Scene, number: int, touched: Touched) -> Scene:
        seen = super().look(true, number, touched)
        hides = any(placed.id == self.by for placed in seen.in_location(self.home))
        self.last[:] = [seen.without(self.hidden) if hides else seen]
        return self.last[0]

    def homes(self, first: Scene) -> dict[str, str]:
        return {**super().homes(first), self.hidden: self.home}

    def refusal(self, item: str, home: str) -> str:
        is_there = any(placed.id == item for placed in self.last[0].items)
        return "" if item != self.hidden or is_there else "no two looks find it"

    def hiding(self, place: str) -> tuple[str, ...]:
        here = {placed.id for placed in self.last[0].in_location(place)}
        return tuple(name for name in self.names if name in here)


def hide(monkeypatch: pytest.MonkeyPatch, **how: object) -> None:
    hiding = Hiding(PoseNoise(), 0, **how)  # type: ignore[arg-type]
    monkeypatch.setattr(TrialSettings, "perceiving", lambda *_: hiding)


def test_what_hides_a_target_is_moved_aside_and_the_target_picked_once_it_is_seen(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide(monkeypatch)
    fake = ScriptedTrial(scene_of(ORDER, cell))
    result = play(fake)
    assert result.items_in_tote == 4 and result.score.total == result.score.maximum
    queries = [plan.query for plan in fake.executed]
    aside = next(query for query in queries if query.startswith("pick jane_eyre_dvd into "))
    assert queries.index("pick scotch_duct_tape") > queries.index(aside)
    assert not any(query.startswith("pick dove_beauty_bar") for query in queries)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE


def test_what_hides_most_comes_first_and_what_cannot_be_moved_is_left(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide(monkeypatch, names=("dove_beauty_bar", "jane_eyre_dvd"))
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"dove_beauty_bar"}))
    assert outcomes(play(fake))["scotch_duct_tape"] is Outcome.IN_TOTE
    moved = [plan.query for plan in fake.executed if " into " in plan.query]
    assert len(moved) == 1 and moved[0].startswith("pick jane_eyre_dvd")
    fixed = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"dove_beauty_bar", "jane_eyre_dvd"}))
    result = play(fixed)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.NOT_RECOGNISED
    assert result.clock < 300.0  # it is left alone although there is time


def test_what_may_rest_on_a_target_unrecognised_is_uncovered_alike(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The target is seen, but refused as something that nobody recognised touches it."""
    hide(monkeypatch, hidden="nothing", names=("scotch_duct_tape", "jane_eyre_dvd", "dove_beauty_bar"))
    fake = ScriptedTrial(scene_of(ORDER, cell))
    plan = fake.plan

    def refuse(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        is_covered = fake.scene.find("jane_eyre_dvd").location == "bin_B"  # whatever is left out to see why
        if query.item == "scotch_duct_tape" and is_covered:
            raise NoPlanError("pick", [Reason(NOT_RECOGNISED, "at rest", "unrecognised_bin_B_0")])
        return plan(scene, query, start, seed, certify)

    fake.plan = refuse  # type: ignore[method-assign]
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    moved = [plan.query for plan in fake.executed if " into " in plan.query]
    assert len(moved) == 1 and moved[0].startswith("pick jane_eyre_dvd")


def test_other_targets_are_not_moved_aside_for_one_that_is_hidden(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide(monkeypatch, names=("jane_eyre_dvd",))
    targets = (*((t.bin, t.item) for t in ORDER.work_order), ("bin_B", "jane_eyre_dvd"))
    order = pick_order(ORDER.bin_contents, *targets)
    fake = ScriptedTrial(scene_of(order, cell))
    result = play(fake, order)
    assert outcomes(result)["jane_eyre_dvd"] is Outcome.IN_TOTE
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    assert not any(" into " in plan.query for plan in fake.executed)


def test_nothing_is_moved_aside_that_does_not_help_or_cannot_be_moved(cell: Cell) -> None:
    others = {"jane_eyre_dvd", "dove_beauty_bar"}
    fixed = ScriptedTrial(scene_of(ORDER, cell), blocked={"scotch_duct_tape": "jane_eyre_dvd"})
    result = play(replace(fixed, no_plan=frozenset(others)))
    assert outcomes(result)["scotch_duct_tape"] is Outcome.NO_PLAN
    tries = [(a.item, a.outcome) for a in result.attempts if a.target.item == "scotch_duct_tape"]
    assert set(tries) == {(name, Outcome.NO_PLAN) for name in ("scotch_duct_tape", *others)}
    # The scene never changes: so many looks, then it is left alone although there is time. Two searches
    # for what is in the way are in the scene of one look, and the second need not ask for the item again.
    assert tries.count(("scotch_duct_tape", Outcome.NO_PLAN)) == MOST_REFUSALS
    assert tries.count(("jane_eyre_dvd", Outcome.NO_PLAN)) == MOST_CLEARINGS - 1 and result.clock < 300.0
    useless = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"scotch_duct_tape"}))
    play(useless)
    assert useless.executed and not any(" into " in plan.query for plan in useless.executed)


def test_a_target_is_tried_anew_when_something_changed_where_it_lies_now(cell: Cell) -> None:
    """The tape has got from its bin into another; what happens there matters, and not at home."""
    fake = ScriptedTrial(scene_of(ORDER, cell))
    trial = _Trial(ORDER, fake.interfaces(), TrialSettings(), lambda *told: None)
    fake.put("scotch_duct_tape", "bin_C")
    trial.runner.look()
    tape, bottle = trial.targets.states[1:3]

    def refusals_after(bin_name: str) -> int:
        trial.targets.put(tape.refused())
        start = Start(fake.q, fake.tool_state)
        plan = fake.plan(fake.scene, PickQuery(bin_name, "dasani_water_bottle"), start, 0, lambda plan: plan)
        done = Attempt(bottle.target, "dasani_water_bottle", 1, 0.0, Outcome.NOT_PICKED, out_of=bin_name,
                       plan=plan, execution=ExecutionResult(1.0))  # fmt: skip
        trial._note(bottle, done)
        return trial.targets.open[tape.index].refusals

    assert refusals_after("bin_B") == 1 and refusals_after("bin_C") == 0


def test_planning_ends_with_the_time_while_it_is_asked_what_is_in_the_way(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset(ORDER.bin_contents["bin_B"]))
    limits = [DEFAULT.look_time + 40.0 + k for k in range(12)]
    assert all(play(fake, time_limit=limit).clock <= limit for limit in limits)


def test_a_motion_after_which_there_is_no_time_to_look_is_not_begun(cell: Cell) -> None:
    least = DEFAULT.look_time + PLANNING_CHARGE + DURATION + ARRIVAL + DEFAULT.look_time
    assert play(ScriptedTrial(scene_of(ORDER, cell)), time_limit=least - 0.05).items_in_tote == 0
    assert play(ScriptedTrial(scene_of(ORDER, cell)), time_limit=least + 0.05).items_in_tote == 1


def test_a_pick_order_with_something_in_the_tote_is_refused(cell: Cell) -> None:
    filled = replace(ORDER, tote_contents=("jane_eyre_dvd", "dove_beauty_bar"))
    with pytest.raises(InputError, match=r"2 items \(jane_eyre_dvd, dove_beauty_bar\).*empty tote"):
        play(ScriptedTrial(scene_of(ORDER, cell)), filled)


def test_in_2015_nothing_else_is_moved(cell: Cell) -> None:
    order = replace(ORDER, year=2015)
    fake = ScriptedTrial(scene_of(ORDER, cell), blocked={"scotch_duct_tape": "jane_eyre_dvd"})
    assert outcomes(play(fake, order))["scotch_duct_tape"] is Outcome.NO_PLAN
    assert fake.executed and not any(" into " in plan.query for plan in fake.executed)


def test_no_plan_is_an_outcome_with_its_reason(cell: Cell) -> None:
    result = play(ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"dasani_water_bottle"})))
    missed = next(t for t in result.targets if t.outcome is Outcome.NO_PLAN)
    assert missed.target.item == "dasani_water_bottle"
    assert "does not hold" in missed.reason
    assert result.items_in_tote == 3 and result.is_clean


def test_what_the_tool_cannot_hold_is_asked_once(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"fitness_gear_3lb_dumbbell"}))
    play(fake)
    assert [item for item, _, _ in fake.planned].count("fitness_gear_3lb_dumbbell") == 1


def test_a_rejected_plan_is_never_executed(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), rejects=frozenset({"scotch_duct_tape"}))
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.REJECTED
    assert fake.executed and not any("scotch_duct_tape" in plan.query for plan in fake.executed)
    assert all(plan.certificate is not None for plan in fake.executed)
    told = [attempt for attempt in result.attempts if attempt.item == "scotch_duct_tape"]
    assert all(attempt.rejected and attempt.reasons and attempt.plan is None for attempt in told)
    assert {reason.where for attempt in told for reason in attempt.reasons} == {
        "rejected by the verifier, lift"
    }


def test_what_a_rejection_names_is_moved_aside_first(cell: Cell) -> None:
    """The tape is refused as long as the film beside it, which would fall, is there: nobody asks again."""
    fake = ScriptedTrial(scene_of(ORDER, cell))
    other, verify = "jane_eyre_dvd", fake.verify

    def needed(plan: Plan, scene: Scene, stopped: object = None) -> Verdict:
        here = {placed.id for placed in scene.in_location("bin_B")}
        if "scotch_duct_tape" in plan.query and other in here:
            return Verdict(None, (Reason("takes away what others need", "lift", "it would fall", other),))
        return verify(plan, scene, stopped)

    fake.verify = needed  # type: ignore[method-assign]
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.IN_TOTE
    tape = [a for a in result.attempts if a.target.item == "scotch_duct_tape"]
    assert [(a.item, a.outcome) for a in tape][:2] == [
        ("scotch_duct_tape", Outcome.REJECTED), (other, Outcome.MOVED)
    ]  # fmt: skip
    assert sum(len(attempt.rejected) for attempt in tape) == 1


@pytest.mark.parametrize("n_fits", [0, 1, 2])
def test_nothing_is_executed_past_the_time_limit(cell: Cell, n_fits: int) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell))
    limit = n_fits * (DEFAULT.look_time + DURATION + PLANNING_CHARGE) + 0.9 * DURATION
    result = play(fake, time_limit=limit)
    assert result.items_in_tote == n_fits == len(fake.executed)
    assert result.clock <= limit
    late = [target for target in result.targets if target.outcome is Outcome.NO_TIME]
    assert len(late) == len(result.targets) - n_fits and all(target.reason for target in late)


def test_the_clock_is_simulated_time_plus_planning_calls(cell: Cell) -> None:
    result = play(ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"fitness_gear_3lb_dumbbell"})))
    looks = 4 * DEFAULT.look_time  # at the start, and after every motion
    assert result.simulated == pytest.approx(3 * DURATION + looks)
    assert result.clock == pytest.approx(3 * DURATION + looks + 4 * PLANNING_CHARGE)


def test_planning_sees_noise_and_its_bound_never_the_truth(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell))
    play(fake)
    truth = scene_of(ORDER, cell)
    assert fake.perceived and truth.items
    for seen in fake.perceived:
        assert seen.noise.position > 0.0 and seen.noise.angle > 0.0
        assert all(
            (a.T_world_item != b.T_world_item).any() for a, b in zip(seen.items, truth.items, strict=True)
        )


def test_a_fallen_item_is_missing_and_costs_points(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell))
    dropped = ExecutionResult(4.0, stopped="vacuum lost in transfer", has_item=True,
                        drops=(Drop("scotch_duct_tape", 1.2),))  # fmt: skip
    fake.executions["scotch_duct_tape"] = [dropped]
    execute = fake.execute

    def execute_and_drop(plan):  # type: ignore[no-untyped-def]
        done = execute(plan)
        if done is dropped:
            fake.put("scotch_duct_tape", OUTSIDE)
        return done

    fake.execute = execute_and_drop  # type: ignore[method-assign]
    result = play(fake)
    assert outcomes(result)["scotch_duct_tape"] is Outcome.MISSING
    assert [a.outcome for a in result.attempts if a.target.bin == "bin_B"] == [Outcome.LOST, Outcome.MISSING]
    assert result.drops == ("scotch_duct_tape",)
    assert result.score.total == result.score.maximum - 16 - 10 - 5


def test_the_state_after_a_task_is_refused(cell: Cell) -> None:
    output = Order(OrderKind.OUTPUT, 2016, ORDER.bin_contents, (), ())
    with pytest.raises(InputError, match="output file, with nothing to do"):
        play(ScriptedTrial(scene_of(ORDER, cell)), output)


def test_same_seed_same_bytes_but_for_statistics(cell: Cell) -> None:
    def record(seed: int) -> dict[str, object]:
        fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
        record = trial_record(play(fake, seed=seed), "order.json", wall_s=1.0)
        record.pop("statistics")
        return record

    assert record_text(record(1)) == record_text(record(1))
    assert record_text(record(1)) != record_text(record(2))


def test_the_record_has_what_is_promised_and_counts_agree(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
    result = play(fake)
    record = json.loads(record_text(trial_record(result, "order.json", wall_s=1.0)))
    assert set(record) >= {
        "score", "max_score", "items_in_tote", "items", "collisions", "limit_violations", "drops",
        "simulated_s", "statistics",
    }  # fmt: skip
    assert record["items_in_tote"] == sum(i["outcome"] == "in tote" for i in record["items"]) == 4
    assert record["score"] == sum(line["points"] for line in record["score_lines"])
    assert [i["bin"] for i in record["items"]] == [t.bin for t in ORDER.work_order]
    wall_clock = [key for key in json.dumps({**record, "statistics": None}).split('"') if key.endswith("_ms")]
    assert wall_clock == []


def test_a_trial_that_leaves_targets_says_why_it_ended(cell: Cell) -> None:
    """Of a trial that did all nothing is said."""
    assert not any("the trial ended" in line for line in summary(play(ScriptedTrial(scene_of(ORDER, cell)))))
    left = play(ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"scotch_duct_tape"})))
    assert left.items_in_tote < len(left.targets)
    assert "the trial ended as nothing was left to try" in summary(left)
    assert why_it_ended([("choose_target", True), ("has_time_to_plan", False)]) == "no time was left to plan"
    assert why_it_ended([]) == why_it_ended([("pick", False)]) == ""


def test_the_table_has_a_row_per_target_and_the_summary_names_the_noise(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), executions={"scotch_duct_tape": [LOST]})
    result = play(fake)
    table = {row.item: row for row in rows(result)}
    assert list(table) == [t.item for t in ORDER.work_order]
    assert table["scotch_duct_tape"].reason.startswith("after: ")
    assert table["scotch_duct_tape"].motion_s == pytest.approx(4.0 + 0.5 + DURATION + DURATION)
    assert sum(row.points for row in table.values()) == result.score.total
    seen = "an error of up to 2 mm and 1 degrees, 2 % of them of up to 3 times as much"
    assert any(seen in line for line in summary(result))
    assert "the pod stood +0.0 mm in x, +0.0 mm in y, +0.00 degrees off its place" in summary(result)
    exact = play(ScriptedTrial(scene_of(ORDER, cell)), reality=IDEAL)
    assert any(line.endswith("1 degrees") for line in summary(exact))


def test_a_strategy_that_tries_nothing_is_named_in_the_summary(cell: Cell) -> None:
    idle = Strategy("own", "", StrategyNode("sequence", {}, (StrategyNode("has_time_to_plan"),)))
    result = play(ScriptedTrial(scene_of(ORDER, cell)), strategy=idle)
    assert any("the strategy tried nothing in 100 ticks" in line for line in summary(result))


def test_names_in_a_strategy_that_the_cell_does_not_have_are_warned_of(
    cell: Cell, caplog: pytest.LogCaptureFixture
) -> None:
    by = {"by": ("item_priority",), "items": ("scotch_duct_tape", "dove_beauty_baar")}
    tree = StrategyNode("sequence", {}, (StrategyNode("choose_target", by), StrategyNode("pick")))
    play(ScriptedTrial(scene_of(ORDER, cell)), strategy=Strategy("own", "", tree))
    (line,) = (r.getMessage() for r in caplog.records if "strategy own" in r.getMessage())
    assert "choose_target.items: 'dove_beauty_baar'" in line and "'dove_beauty_bar'" in line


def test_targets_that_the_strategy_gave_up_were_not_missed_for_time(cell: Cell) -> None:
    choose = StrategyNode("choose_target", {"by": ("order",)})
    giving_up = Strategy("own", "", StrategyNode("sequence", {}, (choose, StrategyNode("give_up"))))
    result = play(ScriptedTrial(scene_of(ORDER, cell)), strategy=giving_up)
    assert {t.outcome for t in result.targets} == {Outcome.NOT_TRIED} and not result.attempts
    assert [tick.node for tick in result.ticks[:2]] == ["choose_target (by order)", "give_up"]
    assert result.ticks[-1].target == "" and not result.ticks[-1].is_success  # nothing is left to choose


def test_the_hook_is_called_after_every_attempt(cell: Cell) -> None:
    calls: list[int] = []
    interfaces = ScriptedTrial(scene_of(ORDER, cell)).interfaces()
    result = run_trial(ORDER, interfaces, after_attempt=lambda _: calls.append(len(calls)))
    assert len(calls) == len(result.attempts) > 0


def test_progress_counts_up_to_all_targets(cell: Cell) -> None:
    seen: list[Progress] = []
    run_trial(ORDER, ScriptedTrial(scene_of(ORDER, cell)).interfaces(), on_progress=seen.append)
    done = [progress.done for progress in seen]
    assert done == sorted(done)
    assert (seen[0].done, seen[0].total, seen[0].what) == (0, 4, "looking into all places")
    assert (seen[-1].done, seen[-1].total) == (4, 4)
    assert any("planning" in each.what and "s left" in each.what for each in seen)


def test_an_interrupted_trial_says_what_is_lost_with_it(cell: Cell) -> None:
    fake = ScriptedTrial(scene_of(ORDER, cell), no_plan=frozenset({"scotch_duct_tape"}))
    n_left = 2

    def stop(_: object) -> None:
        nonlocal n_left
        n_left -= 1
        if not n_left:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        run_trial(ORDER, fake.interfaces(), after_attempt=stop)
    (note,) = stopped.value.__notes__
    assert note.startswith("1 of 4 targets were in the tote after 2 attempts; a trial cannot be continued")
