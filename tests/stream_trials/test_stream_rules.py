"""The rules by which streams are played: where items are met, when they are tried, and by which arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.stream_trials.stream_trial import StreamTrialRequest, play_stream
from pickcli.verification.verify import certifier
from support import belt_picks, pr2_picks
from support.command_line import apc, misused
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


def test_arms_alternate_or_go_on() -> None:
    left, right = ARMS
    turns = StreamRule.PR2_2013.in_turn
    assert turns(ARMS, left, None) == (left, right)
    assert turns(ARMS, left, left) == turns(ARMS, right, left) == (right, left)
    assert turns(ARMS, right, right) == (left, right)
    assert StreamRule.EARLIEST.in_turn(ARMS, right, right) == (right, left)


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
    """``t_pred > now + d_p + d_g`` does not hold; where there is no such place, the same item has a plan."""
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
