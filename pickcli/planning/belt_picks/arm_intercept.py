"""A pick from a running conveyor that the whole arm follows, met at the earliest time that is found.

Without a linear axis along the belt every joint has to follow it, and another meeting is another motion. So
times of contact are tried one after the other: grasps and lines are found with the belt where it is then,
timed as if it stood, and followed with the belt (``timing.arm_tracking``); the arm has to be in time where
that begins, and everything is proven (``followed_stitching``).
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from pickcli.collision.motion_segment import scaled_segments
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.grasping.search import Search
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Certify, Plan
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.carried_motion import carried_motion
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.belt_picks.belt_grasps import BeltGrasps
from pickcli.planning.belt_picks.belt_meetings import INWARD, BeltMeeting, BeltMeetings, MeetingTimes
from pickcli.planning.belt_picks.belt_query import (
    PACED_COMING,
    WIDELY_LATE,
    InterceptQuery,
    QueryBelt,
    pumped_from,
)
from pickcli.planning.belt_picks.belt_raise import raised_over_belt
from pickcli.planning.belt_picks.follow_bounds import RideTimes, why_unreached
from pickcli.planning.belt_picks.followed_stitching import (
    FollowedMeeting,
    FollowedTaking,
    follow_lines,
    stitch_followed,
)
from pickcli.planning.belt_picks.line_pace import line_pace, paced_lines
from pickcli.planning.belt_picks.tracked_stitching import TimedTaking
from pickcli.planning.pick_motion import GraspMotion, GraspTransit, PickMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.region_query import RegionSearch
from pickcli.planning.stages.extraction import CorridorSet
from pickcli.planning.stages.grasp_motion import arm_seeds, plan_grasp_motion
from pickcli.planning.stages.grasp_selection import searches_of
from pickcli.planning.stages.grasp_transit import transits_to_grasps
from pickcli.planning.stages.transfer import plan_transfer
from pickcli.planning.start_state import Start
from pickcli.seeds import derived_rng
from pickcli.timing.line_tracking import ramp_time

SOONEST = 1.5  # s from the start until the arm follows the belt, at the soonest that is tried: a rule
LEFT_BEFORE = "leaves the window before it is lifted"
MOST_MET = 10  # meetings that one effort tries
WHERE_SEARCHED = (
    0.35  # of the way from the soonest contact to the end of the window: where grasps are searched
)
FOLLOWING = 0.5  # of the limits of acceleration and jerk, by which the arm comes up to the belt's speed
LEAST_RAMP = 0.25  # s
LONGER = (1.2, 2.0)  # times that ramp, until no joint is too slow for it
# m by which the belt may be off the plan while the arm follows it. Fingers pass the item on both sides, and
# need that room beside it, too.
DEVIATION = 0.005


@dataclass(frozen=True, eq=False)
class _Asked:
    """A query, with what it is planned by."""

    context: PlanningContext
    belt: QueryBelt
    picked: PickQuery
    start: Start
    seed: int
    along: Array
    pace: float

    @cached_property
    def _problems(self) -> dict[float, PickProblem]:
        """Problems that were posed, by the s at which the belt is there."""
        return {}

    def problem_at(self, t: float) -> PickProblem:
        """Return the pick with the belt where it is at a time (s)."""
        if t not in self._problems:
            posed = PickProblem.of(self.context, self.belt.at(t), self.picked, self.seed)
            self._problems[t] = replace(posed, over_rim=True)
        return self._problems[t]

    @cached_property
    def _grasps(self) -> dict[tuple[Search | RegionSearch, CorridorSet], BeltGrasps]:
        """Grasps that were found, by how they were searched."""
        return {}

    def grasps_by(self, t: float, search: Search | RegionSearch, corridors: CorridorSet) -> BeltGrasps:
        """Find grasps with the belt where it is at a time (s), which is always the same one."""
        if (search, corridors) not in self._grasps:
            off = self.belt.deviation * self.along
            self._grasps[search, corridors] = BeltGrasps.of(self.problem_at(t), search, corridors, off)
        return self._grasps[search, corridors]


def plan_arm_intercept(
    context: PlanningContext,
    belt: QueryBelt,
    query: InterceptQuery,
    start: Start,
    seed: int = 0,
    certify: Certify | None = None,
) -> Plan:
    """Plan the pick of an item that rides on a conveyor which the whole arm follows.

    Args:
        context: The cell, its models and its precomputed files.
        belt: The belt as the query sees it.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified.

    Returns:
        The plan, valid for the scene at its start.

    Raises:
        NoPlanError: The item cannot be met, with every reason.
    """
    began, stream = time.perf_counter(), belt.stream
    place = next(iter(stream.carrier.places))
    picked, along = PickQuery(place, query.item, query.into), stream.carrier.T_world_carrier[:3, 0]
    belt = replace(belt, deviation=DEVIATION)
    pace = line_pace(context.arm.limits, stream.belt.max_acceleration / stream.speed)
    asked = _Asked(context, belt, picked, start, seed, along, pace)
    failures, goes_wide = Failures(), True
    for effort in _efforts(asked):
        if effort.is_wide and not goes_wide:
            break
        search = _Search(asked, effort)
        for found in search.plans():
            if isinstance(found, Plan):
                found = found.with_statistics(planning_ms=1e3 * (time.perf_counter() - began))
                found = found if certify is None else certify(found)
            if isinstance(found, Plan):
                return found
            failures += found
        goes_wide = goes_wide and search.would_go_wide
    raise NoPlanError(query.label(place), failures)


def why_unmet(context: PlanningContext, belt: QueryBelt, query: InterceptQuery) -> NoPlanError | None:
    """Say that an item cannot be met from the first contact that is tried on, by bounds alone.

    Args:
        context: The cell.
        belt: The belt as the query sees it.
        query: The requested pick.

    Returns:
        The error; None if there may be a meeting.
    """
    first = _soonest(context, belt) + INWARD + LEAST_RAMP / 2
    times = RideTimes(belt.stream.speed, first, belt.last)
    reason = why_unreached(context, belt.stream.carrier, belt.start, query.item, times)
    place = next(iter(belt.stream.carrier.places))
    return None if reason is None else NoPlanError(query.label(place), [reason])


def _soonest(context: PlanningContext, belt: QueryBelt) -> float:
    """Time (s) from the start until the arm follows the belt at the soonest."""
    return max(belt.first, SOONEST, pumped_from(context.cell))


@dataclass(frozen=True)
class _Effort:
    """How grasps are searched, and from which configurations the arm tries to reach them.

    search: how candidates are found
    corridors: ways out that they choose from
    by_named: whether only from the configurations that the cell names for the belt
    is_wide: whether it is for where the arm can follow the lines of no grasp before
    """

    search: Search | RegionSearch
    corridors: CorridorSet
    by_named: bool
    is_wide: bool


def _efforts(asked: _Asked) -> Iterator[_Effort]:
    """Yield the efforts, one after the other."""
    first, *others = searches_of(asked.problem_at(_soonest(asked.context, asked.belt)))
    for by_named in (True, False):
        yield _Effort(*first, by_named, is_wide=False)
    for search in others:
        yield _Effort(*search, by_named=False, is_wide=True)


class _Search:
    """The search of one effort."""

    def __init__(self, asked: _Asked, effort: _Effort) -> None:
        self.asked, self._has_motion = asked, False
        context, belt = asked.context, asked.belt
        first = _soonest(context, belt)
        searched = first + WHERE_SEARCHED * (belt.last - first)
        self.problem = replace(asked.problem_at(searched), by_named=effort.by_named)
        self.grasps = asked.grasps_by(searched, effort.search, effort.corridors)
        rest = context.method.rests(context.cell.devices, context.settings.release_time).taking
        times = MeetingTimes(first, belt.last, LEAST_RAMP, rest, searched, belt.meets)
        velocity = belt.stream.speed * asked.along
        self.queue = BeltMeetings(context, self.grasps, asked.start.q, velocity, times)

    def plans(self) -> Iterator[Plan | Failures]:
        """Yield uncertified plans, the earliest contact first, and the reasons against others."""
        rng = derived_rng(self.asked.seed, "arm on the belt", self.asked.picked.item)
        for k in range(len(self.grasps.grasps)):
            self.queue.enter(k, arm_seeds(self.problem, rng))
        is_one_set = self.asked.context.settings.expansions is not None and self.asked.belt.meets is not None
        yield from self._plans_of_one_set() if is_one_set else self._plans_one_by_one()
        yield self.grasps.failures + self.queue.failures

    def _plans_one_by_one(self) -> Iterator[Plan | Failures]:
        """Yield what comes of meeting after meeting."""
        while self.queue.n_met < MOST_MET and (meeting := self.queue.pop()) is not None:
            met = self._met(meeting)
            found = next(_stitched(self.asked, [met], meeting.t)) if isinstance(met, FollowedTaking) else met
            if isinstance(found, float):
                self.queue.put_off(meeting, found)
                continue
            yield found
            self.queue.put_off(meeting)

    def _plans_of_one_set(self) -> Iterator[Plan | Failures]:
        """Yield what comes of all meetings at the one time, whose pregrasps are one set of goals (IV-B)."""
        ready, t_contact = list[FollowedTaking](), self.asked.belt.meets
        while self.queue.n_met < MOST_MET and (meeting := self.queue.pop()) is not None:
            found = self._met(meeting)
            if isinstance(found, FollowedTaking):
                ready.append(found)
            elif isinstance(found, float):
                self.queue.put_off(meeting, found)
            else:
                yield found
        if ready and t_contact is not None:
            for plan in _stitched(self.asked, ready, t_contact):
                if isinstance(plan, float):
                    yield Failures.of(Reason("too late", "transit", f"by {1e3 * plan:.0f} ms"))
                else:
                    yield plan

    @property
    def would_go_wide(self) -> bool:
        """Whether a wide search could help: not for an arm that follows lines, or is much too late."""
        are_late = not self.queue.n_met and WIDELY_LATE < self.queue.least_late < np.inf
        return not (self._has_motion or are_late)

    def _met(self, meeting: BeltMeeting) -> FollowedTaking | Failures | float:
        """Plan the motion on the belt; return the reasons against it, or the s by which it is too soon."""
        asked, problem = self.asked, self.asked.problem_at(meeting.t)
        lines = self.grasps.lines(meeting.k, problem)
        if isinstance(lines, Failures):
            return lines
        speed = asked.context.method.contact_speed(problem.contacts, lines.grasp)
        if speed is None:
            return Failures.of(Reason("tips the item", str(lines.grasp)))
        motion = plan_grasp_motion(problem, lines, speed, self.queue.q_contact(meeting)[None])
        if isinstance(motion, Failures):
            return motion
        self._has_motion = True
        return self._followed(problem, motion, meeting)

    def _followed(
        self, problem: PickProblem, motion: GraspMotion, meeting: BeltMeeting
    ) -> FollowedTaking | Failures | float:
        """Let the arm follow the belt with the lines of a grasp; or return why not, or how late it is (s)."""
        asked, context, belt = self.asked, self.asked.context, self.asked.belt
        motion = motion.unwound_towards(context.arm.limits, asked.start.q)
        raised = raised_over_belt(problem, motion, belt.coming, belt.left(meeting.t))
        if isinstance(raised, Failures):
            return raised
        motion = paced_lines(raised, asked.pace)
        inward = proven_run(context, problem.scene, scaled_segments(context.cell.speed_scale, motion.inward))
        if isinstance(inward, Failures):
            return inward
        ramp = _ramp(asked, motion)
        if (missing := self.queue.missing(meeting, inward.trajectory.duration, ramp)) > 0.0:
            return missing
        outward = carried_motion(
            problem,
            PickMotion(motion.inward[0], motion, Transfer((), PlaceMotion(problem.scene, (), (), 0.0))),
        )
        if isinstance(outward, Failures):
            return outward
        rest = context.method.rests(context.cell.devices, context.settings.release_time).taking
        taking = TimedTaking(problem, meeting.t, motion, inward, outward, rest)
        if meeting.t + taking.lasts > belt.last:
            late = f"by {1e3 * (meeting.t + taking.lasts - belt.last):.0f} ms"
            return Failures.of(Reason(LEFT_BEFORE, str(motion.grasp), late))
        for longer in LONGER:
            followed = follow_lines(taking, asked.along, belt.stream.speed, longer * ramp)
            if not isinstance(followed, Failures):
                break
        else:
            return followed
        begins = followed.trajectory.positions[0]
        begins_near = unwound_towards(context.arm.limits, begins, asked.start.q)
        needed = estimated_duration(context.space, np.stack([asked.start.q, begins_near]))
        missing = needed + followed.t_contact - meeting.t
        return missing if missing > 0.0 else followed.unwound(begins_near - begins)


def _ramp(asked: _Asked, motion: GraspMotion) -> float:
    """Return the s in which the arm comes up to the speed of the belt over the item."""
    arm, scale, speed = asked.context.arm, asked.context.cell.speed_scale, asked.belt.stream.speed
    J = arm.jacobian(motion.start, motion.inward[0].mode.tool_state)
    per_metre = np.abs(np.linalg.pinv(J) @ [*asked.along, 0.0, 0.0, 0.0])
    limits = arm.limits
    rates = (speed * per_metre).tolist()
    most = zip(rates, (FOLLOWING * scale * limits.acceleration).tolist(), limits.jerk.tolist(), strict=True)
    return max(LEAST_RAMP, *(ramp_time(rate, a, FOLLOWING * j) for rate, a, j in most))


def _stitched(
    asked: _Asked, ready: Sequence[FollowedTaking], t_contact: float
) -> Iterator[Plan | Failures | float]:
    """Plan the way to one of several motions on the belt, and yield the whole plan, or why there is none.

    A time (s) is that by which the contact has to be later.
    """
    before = replace(ready[0].taking.problem, scene=asked.belt.coming)
    for reached in transits_to_grasps(before, [each.ready for each in ready], asked.start):
        if isinstance(reached, Failures):
            yield reached
        else:
            begins = reached.taking.start
            followed = next(each for each in ready if np.array_equal(each.ready.start, begins))
            yield _left(asked, followed, reached, t_contact)


def _left(
    asked: _Asked, followed: FollowedTaking, reached: GraspTransit, t_contact: float
) -> Plan | Failures | float:
    """Plan the way from the belt to the placement, and stitch the whole plan."""
    context, belt, grasp = asked.context, asked.belt, str(followed.taking.motion.grasp)
    before = replace(followed.taking.problem, scene=belt.coming)
    transit = reached.transit.scaled(PACED_COMING)
    coming = proven_run(context, before.scene, scaled_segments(context.cell.speed_scale, [transit]))
    if isinstance(coming, Failures):
        return coming
    if (late := coming.trajectory.duration + followed.t_contact - t_contact) > 0.0:
        return late
    after = replace(followed.taking.problem, scene=belt.left(t_contact + followed.lasts))
    carried = plan_transfer(after, replace(reached, taking=followed.left))
    if isinstance(carried, Failures):
        return carried
    meeting = FollowedMeeting(belt.start, belt.coming, belt.tracking, t_contact, after)
    plan = stitch_followed(meeting, transit, coming, followed, carried)
    if not isinstance(plan, Plan):
        return plan
    too_far = belt.brought_too_far(plan, grasp)
    return plan.with_statistics(**reached.figures) if too_far is None else Failures.of(too_far)
