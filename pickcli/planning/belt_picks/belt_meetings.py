"""Meetings of an arm with an item on a belt that all of its joints follow, the earliest first.

A meeting is a grasp, a branch of the arm, and a time of contact. From how far along the belt the arm reaches
the grasp, and how long it takes to where it begins to follow the belt, it is estimated from when on a meeting
may be possible. That orders what is tried; whether it is possible is told by planning it.
"""

from __future__ import annotations

import heapq
import itertools
from dataclasses import dataclass, replace

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.belt_picks.belt_grasps import BeltGrasps
from pickcli.planning.belt_picks.belt_reach import BeltReach, belt_reaches
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.grasp_transit import SCORE_COST

UNREACHED = "no inverse-kinematics solution"
EVERY = 0.1  # s between contacts that are tried
ELSEWHERE = 0.2  # s that a contact is put off if it cannot be made for another reason than time
MOST_TRIED = 3  # contacts of one grasp in one branch of the arm, besides those put off for time
MOST_LATER = 8  # times that one is put off for time
INWARD, OUTWARD = (
    0.45,
    0.4,
)  # s that lines before and after a contact are taken to last, without ramps and rests
SPARE = 0.03  # s that all meetings are put off beyond what one of them was late
ROUNDING = 1e-9  # of a time between contacts


@dataclass(frozen=True)
class MeetingTimes:
    """When a contact may be made, and what it takes besides the lines.

    Attributes:
        first: s from the start of the plan, the first that is tried.
        last: s at which the item leaves the window.
        ramp: s in which the arm comes up to the speed of the belt, at least.
        rest: s for which it rests relative to the belt when the item is taken.
        searched: s at which the belt is where the grasps were searched.
        only: s of the one contact that is tried; None for all.
    """

    first: float
    last: float
    ramp: float
    rest: float
    searched: float
    only: float | None = None


@dataclass(frozen=True, eq=False)
class BeltMeeting:
    """A contact that may be possible.

    Attributes:
        k: Index of the grasp.
        reach: How far along the belt a branch of the arm reaches it.
        t: s of the contact from the start of the plan.
        n_tried: How often it was put off for other reasons than time.
        n_late: How often it was put off for time.
    """

    k: int
    reach: BeltReach
    t: float
    n_tried: int = 0
    n_late: int = 0


class BeltMeetings:
    """Meetings that may be possible, the earliest first.

    Args:
        context: The cell and its models.
        grasps: Grasps of the item.
        start: (n,) configuration of the arm at the start of the plan.
        along: (3,) m/s in the world, the velocity of the belt.
        times: When contacts may be made.

    Attributes:
        n_met: Number of meetings that were taken out.
    """

    def __init__(
        self, context: PlanningContext, grasps: BeltGrasps, start: Array, along: Array, times: MeetingTimes
    ) -> None:
        self._context, self._grasps, self._start = context, grasps, start
        self._velocity, self._speed = along, float(np.linalg.norm(along))
        self._times, self._order = times, itertools.count()
        self._longer = 0.0  # s that meetings take longer than is estimated without what was learnt
        self._queue: list[tuple[float, int, BeltMeeting]] = []
        self._unreached, self._late = Failures(), list[tuple[float, Reason]]()
        self.n_met = 0

    @property
    def failures(self) -> Failures:
        """Reasons against what is not in the queue; of those that are too late the nearest first."""
        late = sorted(self._late, key=lambda each: each[0])
        return self._unreached + Failures(tuple(reason for _, reason in late))

    @property
    def least_late(self) -> float:
        """The s by which all meetings that cannot be are too late at least, by estimates; inf without any."""
        return min((by for by, _ in self._late), default=np.inf)

    def enter(self, k: int, seeds: Array) -> None:
        """Enter a grasp in every branch of the arm that reaches it.

        Args:
            k: Index of the grasp.
            seeds: (K, n) from which inverse kinematics begins.
        """
        grasp, times = self._grasps.grasps[k], self._times
        stretch = tuple(self._speed * (t - times.searched) for t in (times.first, times.last))
        reaches = list(
            belt_reaches(
                self._context.arm, self._grasps.contact(k), grasp.tool_state, self._velocity / self._speed,
                (stretch[0], stretch[1]), seeds,
            )
        )  # fmt: skip
        for reach in reaches:
            self._put(BeltMeeting(k, reach, times.first))
        if not reaches:
            self._unreached += Reason(UNREACHED, str(grasp), "anywhere along the belt")

    def pop(self) -> BeltMeeting | None:
        """Take out the earliest meeting.

        Returns:
            The meeting; None if there are no more.
        """
        while self._queue:
            meeting = heapq.heappop(self._queue)[2]
            if self._missing(meeting) <= 0.0:
                self.n_met += 1
                return meeting
            self._put(meeting)  # more has been learnt since it was entered
        return None

    def put_off(self, meeting: BeltMeeting, by: float | None = None) -> None:
        """Enter a meeting that was tried again, if it may be possible later.

        Args:
            meeting: The meeting.
            by: s that it has to be later; None if it failed for another reason than time.
        """
        if self._times.only is not None:
            if by is not None:
                self._tell_late(meeting, by, f"by about {1e3 * by:.0f} ms")
        elif by is None:
            if meeting.n_tried + 1 < MOST_TRIED:
                self._put(replace(meeting, t=meeting.t + ELSEWHERE, n_tried=meeting.n_tried + 1), told=True)
        elif meeting.n_late < MOST_LATER:
            self._longer += max(0.0, by + SPARE - self._missing(meeting))
            self._put(replace(meeting, n_late=meeting.n_late + 1))
        else:
            self._tell_late(meeting, by, f"by about {1e3 * by:.0f} ms")

    def q_contact(self, meeting: BeltMeeting) -> Array:
        """Return about which configuration makes the contact.

        Args:
            meeting: The meeting.

        Returns:
            (n,).
        """
        return meeting.reach.at(self._speed * (meeting.t - self._times.searched))

    def _put(self, meeting: BeltMeeting, told: bool = False) -> None:
        """Enter a meeting at the first time from its own on at which it may be possible; else tell why."""
        t, late, why = self._possible_from(meeting)
        if late <= 0.0:
            cost = t + SCORE_COST * self._grasps.grasps[meeting.k].score
            heapq.heappush(self._queue, (cost, next(self._order), replace(meeting, t=t)))
        elif not told:
            self._tell_late(meeting, late, why)

    def _possible_from(self, meeting: BeltMeeting) -> tuple[float, float, str]:
        """Estimate the first s from some on at which a contact can be made; how many s it is late, and why.

        The arm has to reach the pose of the tool from where it begins to follow the belt to where it is at
        rest again, and to be there in time.
        """
        times, half = self._times, self._times.ramp / 2
        first, last = (times.searched + travel / self._speed for travel in meeting.reach.stretch)
        after = times.rest + OUTWARD + half
        soonest, end, missing = max(meeting.t, first + INWARD + half), min(last, times.last + half), 0.0
        t = EVERY * float(np.ceil(soonest / EVERY - ROUNDING))
        if times.only is not None:
            t = times.only
            if t < soonest:
                return t, soonest - t, f"by about {1e3 * (soonest - t):.0f} ms where it is to be met"
            end = min(end, t + after)
        while t + after <= end:
            if (missing := self._missing(replace(meeting, t=t))) <= 0.0:
                return t, 0.0, ""
            t += EVERY
        if missing > 0.0:
            return t, missing, f"by about {1e3 * missing:.0f} ms"
        ends = "the arm's reach" if last < times.last + half else "the window"
        return t, t + after - end, f"{ends} ends about {t + after - end:.2f} s too soon"

    def missing(self, meeting: BeltMeeting, inward: float, ramp: float) -> float:
        """Estimate the s by which the arm is too late for a meeting whose lines are timed.

        Args:
            meeting: The meeting.
            inward: s of the lines before the contact.
            ramp: s in which the arm comes up to the speed of the belt.

        Returns:
            s, negative if it is in time.
        """
        begins = meeting.t - inward - ramp / 2
        q = meeting.reach.at(self._speed * (begins - self._times.searched))
        q = unwound_towards(self._context.arm.limits, q, self._start)
        needed = estimated_duration(self._context.space, np.stack([self._start, q]))
        return needed + ramp + inward - meeting.t

    def _missing(self, meeting: BeltMeeting) -> float:
        """Estimate the s by which the arm is too late for a meeting, with what was learnt from others."""
        return self.missing(meeting, INWARD, self._times.ramp) + self._longer

    def _tell_late(self, meeting: BeltMeeting, by: float, why: str) -> None:
        self._late.append((by, Reason("too late", str(self._grasps.grasps[meeting.k]), why)))
