"""The rules by which streams are played: where items are met, when they are tried, and by which arm."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.errors import NoPlanError
from pickcli.grasping.recorded_grasp import RecordedGrasp, recorded_from_plan
from pickcli.grasping.recorded_grasp_file import write_recorded_grasps
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.item_stream import RidingItem
from pickcli.scene.stream_file import write_stream
from pickcli.stream_trials.stream_arms import StreamArms
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.stream_trials.stream_trial import play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.verification.verify import certifier
from support import belt_picks, pr2_picks
from support.command_line import apc, misused, refused
from support.pr2_picks import context, home, stream

ARMS = [context("left"), context("right")]


def place(arm: str = "left") -> float:
    found = StreamRule.PR2_2013.meeting_place(context(arm), stream().carrier)
    assert found is not None
    return found


def contact(plan: Plan, by: PlanningContext) -> float:
    """When the tool is where it takes the item, and begins to: s."""
    takes = by.method.rests(by.cell.devices, by.settings.release_time).taking
    return next(s.t_end for s in plan.segments if s.kind is SegmentKind.CONTACT) - takes


def test_items_are_met_abreast_of_the_shoulder_or_anywhere() -> None:
    """The shoulders of the PR2 are 0.188 m from its middle; the belt begins at 1.065 m."""
    assert (place("left"), place("right")) == pytest.approx((1.065 - 0.188, 1.065 + 0.188), abs=0.02)
    assert StreamRule.EARLIEST.meeting_place(context(), stream().carrier) is None


def test_arms_alternate_or_are_asked_as_they_are_preferred() -> None:
    arms = StreamArms(ARMS, move_together=False).all
    left, right = arms
    turns = StreamRule.PR2_2013.in_turn
    assert turns(arms, None) == (left, right)
    assert turns(arms, left) == (right, left) and turns(arms, right) == (left, right)
    for rule in (StreamRule.EARLIEST, StreamRule.ONE_AT_A_TIME):
        assert rule.in_turn(arms, right) == rule.in_turn(arms, left) == (left, right)
    assert [rule for rule in StreamRule if rule.moves_together] == [StreamRule.EARLIEST]


def test_the_contact_is_made_where_the_rule_has_it_and_the_arm_waits_over_the_belt() -> None:
    items = replace(stream(), cell=context("right").cell)
    riding, at = items.items[3], place("right")
    query = InterceptQuery(riding.id, riding.stamp + 0.1, "bin_right", at)
    plan = plan_intercept(context("right"), items, query, home("right"))
    assert items.travel_at(riding, query.now + contact(plan, context("right"))) == pytest.approx(at, abs=1e-9)
    moves = np.abs(plan.trajectory.velocities).max(axis=1) > 0.0
    assert moves[1]  # at once, and not after a wait where it stands
    assert isinstance(certifier(items.scene_at(query.now))(plan), Plan)


def test_an_item_that_is_there_sooner_than_the_arm_is_not_tried() -> None:
    """``t_pred > now + d_p + d_g`` does not hold."""
    items = replace(stream(), cell=context("right").cell)
    riding, at = items.items[3], place("right")
    now = riding.stamp + (at - 0.33 * 1.2 - float(riding.T_belt_item[0, 3])) / 0.33
    with pytest.raises(NoPlanError, match="where it is to be met"):
        plan_intercept(
            context("right"), items, InterceptQuery(riding.id, now, "bin_right", at), home("right")
        )


def test_an_item_that_has_passed_its_meeting_is_told_at_once() -> None:
    riding, at = stream().items[0], place()
    query = InterceptQuery(riding.id, riding.stamp + 3.0, "bin_left", at)
    never = why_never(context(), stream(), query, home())
    assert never is not None and "past its meeting: it was 0.877 m from the infeed" in str(never)


def test_an_axis_along_the_belt_meets_items_there_too() -> None:
    items = belt_picks.stream(0.33)
    riding, at = items.items[0], 2.0
    query = InterceptQuery(riding.id, riding.stamp, meet_at=at)
    plan = plan_intercept(belt_picks.context(), items, query, belt_picks.home())
    assert items.travel_at(riding, query.now + contact(plan, belt_picks.context())) == pytest.approx(
        at, abs=1e-6
    )


# Recorded grasps


def recorded(k: int = 3) -> list[RecordedGrasp]:
    """One that runs after the k-th item of the stream, the one of its plan, and one of which it is far to."""
    plan = certifier(pr2_picks.arm_pick("left", k).scene)(pr2_picks.arm_pick("left", k).plan)
    assert isinstance(plan, Plan)
    grasp, items = recorded_from_plan(plan, context().cell), stream()
    R_world_item = (items.carrier.T_world_carrier @ items.items[k].T_belt_item)[:3, :3]
    behind, far = grasp.T_item_pregrasp.copy(), grasp.T_item_pregrasp.copy()
    behind[:3, 3] = grasp.T_item_grasp[:3, 3] - 0.1 * R_world_item.T @ items.carrier.T_world_carrier[:3, 0]
    far[:3, 3] = grasp.T_item_grasp[:3, 3] - 0.45 * R_world_item.T @ np.eye(3)[2]
    return [
        replace(grasp, T_item_pregrasp=behind, source="behind"),
        grasp,
        replace(grasp, T_item_pregrasp=far, source="far"),
    ]


def query(k: int = 3) -> InterceptQuery:
    riding = stream().items[k]
    return InterceptQuery(riding.id, riding.stamp + 0.3, "bin_left", place())


def test_by_the_rules_of_2013_recorded_grasps_pass_both_filters() -> None:
    grasps = recorded()
    with_all = replace(context(), recorded=tuple(grasps))
    filtered = StreamRule.PR2_2013.filtered(with_all, stream(), query(), 0)
    assert filtered.context.recorded == (grasps[1],)
    assert [each.by for each in filtered.removed] == ["chase filter", "kinematic filter"]
    ours = StreamRule.EARLIEST.filtered(with_all, stream(), query(), 0)
    assert ours.context is with_all and not ours.removed and not ours.told
    plan = plan_intercept(filtered.context, stream(), query(), home())
    assert plan.grasp is not None and np.allclose(plan.grasp.T_item_tip, grasps[1].T_item_grasp, atol=1e-3)


def test_without_recorded_grasps_there_is_nothing_to_filter() -> None:
    assert StreamRule.PR2_2013.filtered(context(), stream(), query(), 0).context is context()


def test_on_a_belt_that_stands_nothing_is_chased() -> None:
    items = stream()
    at = place() - float(items.items[3].T_belt_item[0, 3])
    resting = replace(items, speed=0.0, items=(riding_on(items.items[3], at),))
    with_all = replace(context(), recorded=tuple(recorded()))
    standing = InterceptQuery(items.items[3].id, 0.0, "bin_left")
    filtered = StreamRule.PR2_2013.filtered(with_all, resting, standing, 0)
    assert [str(each).split(": ")[:2] for each in filtered.removed] == [
        ["recorded grasp 3 (far)", "kinematic filter"]
    ]


def riding_on(riding: RidingItem, by: float) -> RidingItem:
    T = riding.T_belt_item.copy()
    T[0, 3] += by
    return replace(riding, T_belt_item=T, stamp=0.0)


def test_where_the_filters_leave_none_the_reasons_are_theirs() -> None:
    behind, _, far = recorded()
    without = replace(context(), recorded=(behind, far))
    filtered = StreamRule.PR2_2013.filtered(without, stream(), query(), 0)
    with pytest.raises(NoPlanError) as none:
        plan_intercept(filtered.context, stream(), query(), home())
    told = filtered.explained(none.value)
    assert [reason.what for reason in told.failures] == ["chase filter", "kinematic filter"]
    assert "no recorded grasp passes the filters; recorded grasp 1 (behind): chase filter: it runs" in str(
        told
    )
    assert "recorded grasp 2 (far): kinematic filter: the arm does not reach its pregrasp" in str(told)


def test_many_removed_grasps_are_told_in_part() -> None:
    many = replace(context(), recorded=tuple(recorded()[:1] * 30))
    filtered = StreamRule.PR2_2013.filtered(many, stream(), query(), 0)
    assert len(filtered.removed) == 30 and len(filtered.told) == 21
    assert filtered.told[-1] == "the filters removed 10 more recorded grasps"


@pytest.mark.slow
def test_a_trial_is_played_with_filtered_grasps_and_ara_star_and_tells_both(tmp_path: Path) -> None:
    items = replace(stream(), items=stream().items[3:])
    for named, content in (("some", recorded()), ("none", recorded()[::2])):
        write_recorded_grasps(content, context().cell, tmp_path / f"{named}.json")
    write_stream(items, tmp_path / "one.json")
    played_as = ("run-trial", tmp_path / "one.json", "--arm", "left", "--perception", "truth")
    words = (
        *played_as,
        "--stream-rule",
        "pr2-2013",
        "--planner",
        "ara-star",
        "--expansions",
        "200",
        "--grasps",
    )
    played = apc(*words, tmp_path / "some.json", "-o", tmp_path / "some")
    assert played.code == 0 and "transits by ARA*: proven to cost at most " in played.out, played.err
    record = json.loads((tmp_path / "some" / "trial.json").read_text())
    assert (record["rule"], record["expansions"], record["recorded_grasps"]) == ("pr2-2013", 200, 3)
    assert record["delivered"] == 1 and record["items"][0]["cost_bound"] >= 1.0
    apc(*words, tmp_path / "none.json", "-o", tmp_path / "none")
    (item,) = json.loads((tmp_path / "none" / "trial.json").read_text())["items"]
    assert item["outcome"] == "not attempted" and item["cost_bound"] is None
    assert "chase filter" in item["reason"] and "kinematic filter" in item["reason"]
    apc(*words[:-2], "1", "--grasps", tmp_path / "some.json", "-o", tmp_path / "few")
    (item,) = json.loads((tmp_path / "few" / "trial.json").read_text())["items"]
    assert "ARA* found none on its lattice in the 1 expansions that it may take" in item["reason"]


def test_options_of_streams_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    for words, told in (
        (("jsk_pick_sample", "--planner", "ara-star"), "--planner applies to streams"),
        (
            ("jsk_pick_sample", "--grasps", "g.json"),
            "--grasps applies to streams, and this is none; leave it",
        ),
        (
            ("jsk_pick_sample", "--grasps", "g.json", "--planner", "ara-star", "--stream-rule", "earliest"),
            "--stream-rule, --grasps, --planner apply to streams, and this is none; leave them out",
        ),
        (("pr2_belt_moving", "--expansions", "20"), "--expansions limits ARA*; add --planner ara-star"),
        (("pr2_belt_moving", "--planner", "ara-star", "--expansions", "0"), "--expansions"),
        (
            ("pr2_belt_moving", "--grasps", "g.json", "--approach", "region"),
            "--grasps and --approach both say where grasps come from",
        ),
    ):
        for command in ("run-trial", "run-trials"):
            misused(apc(command, *words, "-o", tmp_path / "out"), told)
    missing = tmp_path / "none.json"
    for command in ("run-trial", "run-trials"):
        refused(apc(command, "pr2_belt_moving", "--grasps", missing, "-o", tmp_path / "out"), 3, missing)
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_trial_is_played_by_the_arms_in_turns() -> None:
    """On a belt that stands, where no place is kept; the left arm has no plan for the first item."""
    items = pr2_picks.stream(0.0, n=2, one_by_one=True)
    result = play_stream(StreamTrialRequest(items, rule=StreamRule.PR2_2013), ARMS).result
    taken = [each.arm for each in result.items if each.outcome is ItemOutcome.DELIVERED]
    assert result.is_clean and taken == ["right", "left"]


def test_the_rule_is_for_streams() -> None:
    misused(
        apc("run-trial", "jsk_pick_sample", "--stream-rule", "pr2-2013"), "--stream-rule applies to streams"
    )


def test_a_rule_that_there_is_not_is_refused() -> None:
    misused(apc("run-trial", "pr2_belt_moving", "--stream-rule", "pr2"), "'pr2'", "pr2-2013")
