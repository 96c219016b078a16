"""Picks from a belt that the whole arm follows: certified, at the belt's speed, or with a reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import Failures, NoPlanError
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks.arm_intercept import DEVIATION
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.timing.limit_check import measure_limits
from pickcli.verification.verify import certifier
from support.pr2_picks import arm_pick, context, home, stream

ARMS = ("left", "right")


@pytest.mark.parametrize("arm", ARMS)
def test_the_verifier_accepts_the_pick(arm: str) -> None:
    pick = arm_pick(arm)
    assert isinstance(certifier(pick.scene)(pick.plan), Plan)
    assert pick.plan.tracking is not None and pick.plan.tracking.deviation == DEVIATION


@pytest.mark.parametrize("arm", ARMS)
def test_the_fingers_close_at_rest_relative_to_the_belt(arm: str) -> None:
    pick, kinematics = arm_pick(arm), context(arm).arm
    contact = next(s for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)
    assert contact.t_end - contact.t_start == pytest.approx(0.43)  # the gripper's lead
    along = pick.stream.carrier.T_world_carrier[:3, 0]
    times = np.linspace(contact.t_start, contact.t_end, 100)
    state = context(arm).cell.robot.tool.default_state
    tips = np.array([kinematics.tip(q, state) for q in pick.plan.trajectory.sample(times)])
    seen = tips[:, :3, 3] - np.outer(0.33 * times, along)
    assert float(np.ptp(seen, axis=0).max()) < 1e-6 and float(np.ptp(tips[:, :3, :3], axis=0).max()) < 1e-6
    assert float(np.linalg.norm(tips[-1, :3, 3] - tips[0, :3, 3])) == pytest.approx(0.33 * 0.43, abs=1e-5)


@pytest.mark.parametrize("arm", ARMS)
def test_limits_hold_and_the_item_is_dropped_from_over_the_rim(arm: str) -> None:
    plan, cell = arm_pick(arm).plan, context(arm).cell
    assert measure_limits(plan.trajectory, cell.robot.limits, cell.speed_scale).time_scale <= 1.0 + 1e-6
    assert [str(s.kind) for s in plan.segments[-3:]] == ["transfer", "depart", "depart"]
    assert [event.action for event in plan.events] == ["closed", "open"]


def test_a_plan_for_another_speed_is_rejected() -> None:
    """Seen from a belt at another speed the tool moves while the fingers close."""
    pick = arm_pick()
    assert pick.plan.tracking is not None
    slower = replace(pick.plan, tracking=replace(pick.plan.tracking, speed=0.32))
    rejected = certifier(pick.scene)(slower)
    assert isinstance(rejected, Failures)
    assert any("fingers close while the arm moves" in reason.what for reason in rejected)


def test_the_same_query_gives_the_same_plan() -> None:
    pick = arm_pick()
    assert pick.plan.tracking is not None and pick.plan.grasp is not None
    query = InterceptQuery(pick.plan.grasp.item, pick.plan.tracking.t_stream, "bin_left")
    again = plan_intercept(context(), pick.stream, query, home())
    assert np.array_equal(again.trajectory.positions, pick.plan.trajectory.positions)


def test_an_item_that_has_left_the_window_is_told_by_bounds() -> None:
    items = stream()
    query = InterceptQuery(items.items[0].id, 7.0, "bin_left")
    told = why_never(context(), items, query, home())
    assert told is not None and "left the window" in str(told)
    with pytest.raises(NoPlanError, match="left the window"):
        plan_intercept(context(), items, query, home())


def test_an_item_that_comes_too_near_the_end_of_the_window_has_reasons() -> None:
    items = stream()
    query = InterceptQuery(items.items[0].id, 4.5, "bin_left")
    with pytest.raises(NoPlanError, match=r"too late: by .* for the first contact that is tried"):
        plan_intercept(context(), items, query, home())
    assert why_never(context(), items, query, home()) is not None
    reachable = InterceptQuery(items.items[0].id, 0.8, "bin_left")
    assert why_never(context(), items, reachable, home()) is None


def test_from_a_belt_that_stands_the_plan_is_that_of_any_place() -> None:
    items = stream(0.0, n=12, one_by_one=True)
    near = next(each.id for each in items.items if each.T_belt_item[0, 3] < 1.0)
    query = InterceptQuery(near, 0.0, "bin_left")
    plan = plan_intercept(context(), items.presenting(near), query, home())
    assert plan.tracking is None
