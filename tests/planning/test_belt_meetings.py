"""Meetings with an item on a belt: how far an arm reaches, which grasps have room, what is tried first."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pickcli.geometry import Array, rotation_angle
from pickcli.grasping.search import USUAL
from pickcli.planning.belt_picks.arm_intercept import DEVIATION
from pickcli.planning.belt_picks.belt_grasps import BeltGrasps
from pickcli.planning.belt_picks.belt_meetings import EVERY, MOST_TRIED, BeltMeetings, MeetingTimes
from pickcli.planning.belt_picks.belt_query import InterceptQuery, QueryBelt
from pickcli.planning.belt_picks.belt_reach import STEP, BeltReach, belt_reaches
from pickcli.planning.pick_motion import ToolLines
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.stages.extraction import CorridorSet
from pickcli.planning.stages.grasp_motion import arm_seeds
from support.pr2_picks import context, home, stream

ALONG, SPEED = np.array([0.0, -1.0, 0.0]), 0.33
FIRST, LAST, SEARCHED = 1.5, 5.5, 2.9  # s


@cache
def belt() -> QueryBelt:
    items = stream()
    now = items.items[3].stamp + 0.3
    query = InterceptQuery(items.items[3].id, now, "bin_left")
    return QueryBelt.of(items, items.scene_at(now), query)


@cache
def problem(t: float = SEARCHED) -> PickProblem:
    query = PickQuery("belt", belt().stream.items[3].id, "bin_left")
    return replace(PickProblem.of(context(), belt().at(t), query, 0), over_rim=True)


@cache
def grasps(deviation: float = DEVIATION) -> BeltGrasps:
    return BeltGrasps.of(problem(), USUAL, CorridorSet.FEW, deviation * ALONG)


def seeds(by_named: bool = True) -> Array:
    return arm_seeds(replace(problem(), by_named=by_named), np.random.default_rng(0))


@cache
def reach() -> BeltReach:
    stretch = (SPEED * (FIRST - SEARCHED), SPEED * (LAST - SEARCHED))
    state = grasps().grasps[0].tool_state
    found = belt_reaches(context().arm, grasps().contact(0), state, ALONG, stretch, seeds())
    return next(found)


def test_a_reach_holds_the_tool_on_the_item_all_along() -> None:
    arm, state, T = context().arm, grasps().grasps[0].tool_state, grasps().contact(0)
    assert len(reach().travel) > 10 and np.diff(reach().travel).max() <= STEP + 1e-9
    for travel, q in zip(reach().travel, reach().configurations, strict=True):
        tip = arm.tip(q, state)
        assert np.linalg.norm(tip[:3, 3] - T[:3, 3] - travel * ALONG) < 1e-4
        assert rotation_angle(tip[:3, :3].T @ T[:3, :3]) < 1e-3
    middle = float(reach().travel[3:5].mean())
    off = arm.tip(reach().at(middle), state)[:3, 3] - T[:3, 3] - middle * ALONG
    assert np.linalg.norm(off) < 2e-3  # between two steps


def test_a_pose_out_of_reach_has_none() -> None:
    T = grasps().contact(0).copy()
    T[0, 3] += 2.0
    state = grasps().grasps[0].tool_state
    assert list(belt_reaches(context().arm, T, state, ALONG, (-0.3, 0.3), seeds(False))) == []


def test_lines_are_displaced_with_the_belt_and_have_the_contacts_of_the_scene_there() -> None:
    here, there = grasps().lines(0, problem()), grasps().lines(0, problem(3.5))
    assert isinstance(here, ToolLines) and isinstance(there, ToolLines)
    by = SPEED * (3.5 - SEARCHED) * ALONG
    for mine, other in zip(here.inward, there.inward, strict=True):
        for name in ("preapproach", "approach", "touch", "contact"):
            moved = getattr(other, name)[:3, 3] - getattr(mine, name)[:3, 3]
            assert moved == pytest.approx(by, abs=1e-12)
    for mine_out, other_out in zip(here.outward, there.outward, strict=True):
        assert other_out.lift[:3, 3] - mine_out.lift[:3, 3] == pytest.approx(by, abs=1e-12)
    T_item = problem(3.5).target.T_world_item
    assert there.contact == pytest.approx(T_item @ there.grasp.T_item_tip, abs=1e-12)


def test_a_grasp_without_room_for_the_deviation_is_told() -> None:
    without = grasps(0.0)
    assert len(without.grasps) > 0
    far = grasps(0.1)
    assert far.grasps == () and "with the belt off the plan" in str(list(far.failures))


def queue() -> BeltMeetings:
    times = MeetingTimes(FIRST, LAST, 0.25, 0.43, SEARCHED)
    return BeltMeetings(context(), grasps(), home().q, SPEED * ALONG, times)


def entered() -> BeltMeetings:
    found = queue()
    for k in range(len(grasps().grasps)):
        found.enter(k, seeds())
    return found


def test_the_earliest_meeting_comes_first_and_is_within_reach() -> None:
    meetings, times = entered(), list[float]()
    while (meeting := meetings.pop()) is not None:
        score = grasps().grasps[meeting.k].score
        times.append(meeting.t + 0.2 * score)
        first, last = meeting.reach.stretch
        assert first <= SPEED * (meeting.t - SEARCHED) <= last
        assert meeting.t >= FIRST - 1e-9 and meeting.t / EVERY == pytest.approx(round(meeting.t / EVERY))
    assert len(times) >= 2 and times == sorted(times)
    assert meetings.n_met == len(times)


def test_what_is_late_is_put_off_and_so_is_what_has_not_been_tried() -> None:
    meetings = entered()
    meeting = meetings.pop()
    assert meeting is not None
    meetings.put_off(meeting, 0.2)
    rest = []
    while (other := meetings.pop()) is not None:
        rest.append(other)
    assert rest and min(each.t for each in rest) >= meeting.t + 0.1
    again = next(each for each in rest if each.k == meeting.k and each.n_late)
    assert again.t >= meeting.t + 0.2


def test_a_meeting_that_fails_is_tried_elsewhere_but_not_for_ever() -> None:
    meetings = queue()
    meetings.enter(0, seeds())
    n, latest = 0, 0.0
    while (meeting := meetings.pop()) is not None:
        assert meeting.t > latest
        latest, n = meeting.t, n + 1
        meetings.put_off(meeting)
    assert 1 <= n <= MOST_TRIED


def test_an_arm_that_cannot_be_in_time_is_told_by_how_much() -> None:
    times = MeetingTimes(FIRST, 2.0, 0.25, 0.43, SEARCHED)
    late = BeltMeetings(context(), grasps(), home().q, SPEED * ALONG, times)
    late.enter(0, seeds())
    assert late.pop() is None and 0.0 < late.least_late < np.inf
    assert any(reason.what == "too late" for reason in late.failures)


def test_of_all_that_is_too_late_the_nearest_is_told_first() -> None:
    late = BeltMeetings(
        context(), grasps(), home().q, SPEED * ALONG, MeetingTimes(FIRST, 2.0, 0.25, 0.43, SEARCHED)
    )
    for k in range(len(grasps().grasps)):
        late.enter(k, seeds())
    told = [str(reason) for reason in late.failures if reason.what == "too late"]
    assert len(told) > 1 and f"about {late.least_late:.2f} s too soon" in told[0]
