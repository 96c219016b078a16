"""Trials of streams: every item is decided, with a reason, and the same trial gives the same record."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from pickcli.errors import NoPlanError, Reason
from pickcli.motion.plan import Plan
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.grasp_filtering import FilteredContext
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import Scene
from pickcli.simulation import world as world_module
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.reality import Reality
from pickcli.simulation.scene_bodies import true_masses
from pickcli.simulation.world import World
from pickcli.stream_trials import pick_queries, stream_trial
from pickcli.stream_trials.belt_camera import BeltCamera
from pickcli.stream_trials.pick_queries import QUERY_CHARGE, PickOption
from pickcli.stream_trials.pick_schedule import PlannedPick, next_pick
from pickcli.stream_trials.stream_result import ItemOutcome, StreamTrialResult
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.stream_trials.stream_trial import MOST_ATTEMPTS, play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from support.belt_picks import cell, context


def of(n: int, speed: float, gap: tuple[float, float], seed: int = 3) -> ItemStream:
    return make_stream(cell(), StreamRequest(n, speed, gap), seed)


@pytest.fixture(scope="module")
def result() -> StreamTrialResult:
    """Two items that come far apart, so that the arm has time for both."""
    return play_stream(StreamTrialRequest(of(2, 0.33, (2.0, 2.2))), [context()]).result


def test_items_that_come_far_apart_are_delivered(result: StreamTrialResult) -> None:
    assert result.is_clean and result.n_stops == 0
    assert [each.outcome for each in result.items] == [ItemOutcome.DELIVERED] * 2
    assert result.n_attempted == 2


def test_items_are_met_by_the_tracks_of_a_camera() -> None:
    seen = play_stream(StreamTrialRequest(of(2, 0.33, (2.0, 2.2)), camera=BeltCamera()), [context()]).result
    assert seen.is_clean and [each.outcome for each in seen.items] == [ItemOutcome.DELIVERED] * 2
    assert all(each.met is not None and each.met.offset < 0.008 for each in seen.items)


def test_a_pick_is_planned_once_more_with_what_was_seen_since(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every 0.3 s until the arm has to move, with no wider bounds each time; it rests at home meanwhile."""
    asked: list[tuple[float, float, bool]] = []

    def noted(
        context: PlanningContext, seen: ItemStream, query: InterceptQuery, start: Start, *rest: Any
    ) -> Plan:
        noise = seen.find(query.item).noise
        assert noise is not None
        asked.append((query.now, noise.position, np.array_equal(start.q, context.cell.home.q)))
        return plan_intercept(context, seen, query, start, *rest)

    monkeypatch.setattr(pick_queries, "plan_intercept", noted)
    seen_by = StreamTrialRequest(of(1, 0.2, (2.0, 2.2)), camera=BeltCamera())
    (only,) = play_stream(seen_by, [context()]).result.items
    times, bounds, rested = zip(*asked, strict=True)
    assert only.outcome is ItemOutcome.DELIVERED and len(asked) > 4 and all(rested)
    assert np.diff(times)[-4:] == pytest.approx(QUERY_CHARGE, abs=1e-9)
    assert all(after <= before + 1e-9 for before, after in pairwise(bounds)) and bounds[-1] < 0.8 * bounds[0]


class Answers:
    """Notes what a trial asks for and takes; some queries are refused, and nothing is carried out."""

    def __init__(self, patch: pytest.MonkeyPatch, refuses: Callable[[Answers, InterceptQuery], bool]) -> None:
        self.asked, self.taken, self._refuses = list[InterceptQuery](), list[str](), refuses
        patch.setattr(pick_queries, "plan_intercept", self._planned)
        patch.setattr(stream_trial._StreamTrial, "_execute", self._executed())

    def _planned(self, context: PlanningContext, seen: ItemStream, query: InterceptQuery, *rest: Any) -> Plan:
        self.asked.append(query)
        if self._refuses(self, query):
            raise NoPlanError(query.label("belt"), [Reason("no grasp", query.item, "as the test says")])
        return plan_intercept(context, seen, query, *rest)

    def _executed(self) -> Callable[..., None]:
        def execute(trial: Any, option: PickOption) -> None:
            self.taken.append(option.item.riding.id)
            option.item.attempts += 1
            trial.t += option.planned.plan.trajectory.duration
            trial._close(option.item.riding.id, ItemOutcome.DELIVERED)

        return execute


def test_of_the_next_items_not_always_the_first_is_taken(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what had a plan and passes, the reason is that the arm took others, or what was found since."""
    choices = list[tuple[int, int]]()

    def noted(picks: Sequence[PlannedPick], deadlines: Mapping[str, float]) -> int:
        choices.append((len(picks), chosen := next_pick(picks, deadlines)))
        assert {pick.item for pick in picks} <= set(deadlines)
        return chosen

    Answers(monkeypatch, refuses=lambda answers, query: False)
    monkeypatch.setattr(pick_queries, "next_pick", noted)
    result = play_stream(StreamTrialRequest(of(16, 0.33, (0.25, 0.4), seed=5)), [context()]).result
    assert any(n > 1 for n, _ in choices) and any(k > 0 for _, k in choices)
    passed = [each.reason for each in result.items if each.outcome is ItemOutcome.NOT_ATTEMPTED]
    assert passed and all("busy" in reason or "late" in reason for reason in passed)


def test_off_a_belt_that_stands_what_has_no_plan_beside_another_is_asked_for_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The second item is refused as long as the first is there."""
    items = of(2, 0.0, (0.2, 0.3))
    first, second = (each.id for each in sorted(items.items, key=lambda each: -each.T_belt_item[0, 3]))

    def is_beside(answers: Answers, query: InterceptQuery) -> bool:
        return query.item == second and first not in answers.taken

    answers = Answers(monkeypatch, refuses=is_beside)
    result = play_stream(StreamTrialRequest(items), [context()]).result
    assert result.count(ItemOutcome.DELIVERED) == 2 and answers.taken == [first, second]


def test_what_had_a_plan_just_before_is_asked_for_again_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every third query is refused; the item that is waited for does not pass for that."""
    answers = Answers(monkeypatch, refuses=lambda answers, query: len(answers.asked) % 3 == 0)
    played = play_stream(StreamTrialRequest(of(1, 0.2, (2.0, 2.2)), camera=BeltCamera()), [context()])
    assert played.result.count(ItemOutcome.DELIVERED) == 1
    times = [query.now for query in answers.asked]
    assert np.diff(times)[-5:] == pytest.approx(QUERY_CHARGE, abs=1e-9)


def test_the_cup_meets_its_place_at_the_speed_of_the_belt(result: StreamTrialResult) -> None:
    for each in result.items:
        assert each.met is not None
        assert each.met.slip < 0.005 and each.met.offset < 0.008 and abs(each.met.late) < 0.05


def test_the_record_has_what_the_result_says(result: StreamTrialResult) -> None:
    record = result.record()
    assert (record["presented"], record["attempted"], record["delivered"]) == (2, 2, 2)
    assert (record["collisions"], record["limit_violations"]) == (0, 0)
    assert record["offset_m"]["worst"] == max(each.met.offset for each in result.items if each.met)


def test_the_same_trial_gives_the_same_record(result: StreamTrialResult) -> None:
    again = play_stream(StreamTrialRequest(of(2, 0.33, (2.0, 2.2))), [context()]).result
    assert _timeless(again.record()) == _timeless(result.record())


def _timeless(record: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in record.items() if key != "statistics"}


def test_what_comes_too_fast_is_not_attempted_and_says_why() -> None:
    items = of(3, 0.5, (0.03, 0.05))
    result = play_stream(StreamTrialRequest(items), [context()]).result
    left = [each for each in result.items if each.outcome is ItemOutcome.NOT_ATTEMPTED]
    assert left and all(each.reason and each.attempts == 0 and each.met is None for each in left)
    assert [each.item for each in result.items] == [each.id for each in items.items]
    assert result.count(ItemOutcome.DELIVERED) + len(left) == 3


def test_the_stated_error_of_the_speed_holds_the_true_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    believed = []

    def remember(context: PlanningContext, stream: ItemStream, *rest: Any) -> Plan:
        believed.append(stream)
        raise NoPlanError("pick", [Reason("no", "", "")])

    monkeypatch.setattr("pickcli.stream_trials.pick_queries.plan_intercept", remember)
    play_stream(StreamTrialRequest(of(2, 0.33, (0.3, 0.4))), [context()])
    assert len(believed) > 5
    assert all(each.speed - each.speed_error <= 0.33 <= each.speed for each in believed)


def test_an_item_that_cannot_be_held_is_given_up_on_a_belt_that_stands(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The cup never holds it: without a last attempt the trial would not end."""
    monkeypatch.setattr(World, "held", property(lambda world: None))
    monkeypatch.setattr("pickcli.simulation.suction.Suction._attach", lambda *args: None)
    result = play_stream(StreamTrialRequest(of(1, 0.0, (0.2, 0.3))), [context()]).result
    (each,) = result.items
    assert each.outcome is ItemOutcome.LOST and 1 <= each.attempts <= MOST_ATTEMPTS and each.reason


def test_an_item_that_was_knocked_off_the_belt_is_decided(monkeypatch: pytest.MonkeyPatch) -> None:
    stream = of(2, 0.33, (0.2, 0.3))
    bystander = stream.items[1].id

    def push(plan: Plan, world: World, **rest: Any) -> Execution:
        world.engine.set_velocity(bystander, np.array([0.0, 2.0, 1.5]))
        return execute(plan, world, **rest)

    monkeypatch.setattr("pickcli.stream_trials.stream_trial.execute", push)
    result = play_stream(StreamTrialRequest(stream), [context()]).result
    assert result.items[1].outcome is ItemOutcome.LOST and "knocked off" in result.items[1].reason


def test_an_item_has_one_mass_at_every_attempt(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[float] = []

    def weighed(scene: Scene, reality: Reality, seed: int) -> dict[str, float]:
        found = true_masses(scene, reality, seed)
        drawn.extend(mass for name, mass in found.items() if name == first)
        return found

    def missed(plan: Plan, world: World, **rest: Any) -> Execution:
        return execute(replace(plan, events=()), world, **rest)  # nothing is switched on

    monkeypatch.setattr(world_module, "true_masses", weighed)
    monkeypatch.setattr("pickcli.stream_trials.stream_trial.execute", missed)
    items = of(1, 0.1, (2.0, 2.2))
    first = items.items[0].id
    result = play_stream(StreamTrialRequest(items), [context()]).result
    assert result.items[0].attempts > 1 and len(drawn) == result.items[0].attempts
    assert len({*drawn}) == 1 and drawn[0] != items.items[0].item.mass


def test_an_item_that_leaves_sooner_than_any_pick_takes_costs_no_query(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: dict[str, list[float]] = {}

    def remember(context: PlanningContext, stream: ItemStream, query: InterceptQuery, *rest: Any) -> Plan:
        left = (stream.belt.window[1] - stream.travel_at(stream.find(query.item), query.now)) / stream.speed
        asked.setdefault(query.item, []).append(left)
        return plan_intercept(context, stream, query, *rest)

    monkeypatch.setattr("pickcli.stream_trials.pick_queries.plan_intercept", remember)
    result = play_stream(StreamTrialRequest(of(4, 0.33, (0.25, 0.3))), [context()]).result
    first, *others = result.items
    assert first.outcome is ItemOutcome.DELIVERED and len(asked[first.item]) == 1
    assert all(left > 2.0 for name, every in asked.items() for left in every if name != first.item)
    assert any(each.reason.startswith("too late: it leaves the window in") for each in others)


def test_from_a_belt_that_stands_all_items_are_taken() -> None:
    result = play_stream(StreamTrialRequest(of(2, 0.0, (0.2, 0.3))), [context()]).result
    assert result.count(ItemOutcome.DELIVERED) == 2 and result.is_clean


@pytest.mark.parametrize("camera", [None, BeltCamera()])
def test_what_is_not_on_a_belt_that_stands_is_decided(camera: BeltCamera | None) -> None:
    items = of(1, 0.0, (0.1, 0.2))
    (riding,) = items.items
    T = riding.T_belt_item.copy()
    T[0, 3] = -0.3
    before = replace(items, items=(replace(riding, T_belt_item=T),))
    (told,) = play_stream(StreamTrialRequest(before, camera=camera), [context()]).result.items
    assert (told.outcome, told.reason) == (ItemOutcome.NOT_ATTEMPTED, "it is not on the belt, which stands")


def test_the_time_of_a_query_is_all_that_it_took_with_a_plan_or_without(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The filters take a while; the plan itself says that it took none."""
    unfiltered, n_asked = StreamRule.filtered, 0

    def filtered(rule: StreamRule, *rest: Any) -> FilteredContext:
        time.sleep(0.02)
        return unfiltered(rule, *rest)

    def refuse_first(*rest: Any) -> Plan:
        nonlocal n_asked
        n_asked += 1
        if n_asked == 1:
            raise NoPlanError("pick", [Reason("no", "", "")])
        return plan_intercept(*rest).with_statistics(planning_ms=0.0)

    monkeypatch.setattr(StreamRule, "filtered", filtered)
    monkeypatch.setattr("pickcli.stream_trials.pick_queries.plan_intercept", refuse_first)
    result = play_stream(StreamTrialRequest(of(1, 0.1, (2.0, 2.2))), [context()]).result
    assert result.n_attempted == 1 and result.planning_ms[0] >= 20.0 and result.refusing_ms[0] >= 20.0
