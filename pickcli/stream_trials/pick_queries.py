"""Queries of a trial of a stream: which of the items on the belt can be picked, by which arm, and when."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.errors import Failures, NoPlanError
from pickcli.motion.plan import Certify, Plan, times_at_work
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.scene.scene import Scene
from pickcli.stream_trials.open_item import OpenItem
from pickcli.stream_trials.pick_schedule import PlannedPick, next_pick
from pickcli.stream_trials.stream_arms import LATE, StreamArm, StreamArms, destination_of
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.verification.verify import certifier

QUERY_CHARGE = 0.3  # s of the belt's time for a query, which takes 0.25 s with verification
LEAST_SHARE = 0.9  # of the least time that a pick took: a shorter one is not expected


@dataclass(frozen=True, eq=False)
class BeltLook:
    """What is known of the belt when the trial decides.

    Attributes:
        number: Of the look, from 1 on.
        t: s of the stream.
        stream: The items as they are perceived.
    """

    number: int
    t: float
    stream: ItemStream

    def seconds_left(self, item_id: str) -> float:
        """Return the time until an item leaves the window of a running belt.

        Args:
            item_id: Its id.

        Returns:
            s.
        """
        travel = self.stream.travel_at(self.stream.find(item_id), self.t)
        return (self.stream.belt.window[1] - travel) / self.stream.speed


@dataclass(frozen=True, eq=False)
class StreamPlan:
    """A plan of a trial.

    Attributes:
        plan: The certified plan.
        seen: The stream as it was perceived, in which the plan was certified from its time on.
    """

    plan: Plan
    seen: ItemStream

    @property
    def moves_from(self) -> float:
        """Time (s) of the plan at which the arm begins to move."""
        trajectory = self.plan.trajectory
        moves = np.flatnonzero(np.abs(trajectory.velocities).max(axis=1) > 0.0)
        return float(trajectory.times[max(0, int(moves[0]) - 1)])

    @property
    def rests_until(self) -> float:
        """Time (s) of the plan at which the arm begins to move, or a device is switched."""
        switched = (event.t_trigger for event in self.plan.events if event.t_trigger is not None)
        return min(self.moves_from, *switched)


@dataclass(frozen=True, eq=False)
class PickOption:
    """A pick that can be carried out next.

    Attributes:
        item: What is taken.
        arm: The arm that takes it.
        t: s of the stream at which the plan starts.
        planned: The plan.
    """

    item: OpenItem
    arm: StreamArm
    t: float
    planned: StreamPlan


def late_by(stream: ItemStream, plan: Plan) -> float:
    """Return by how much a plan may be late, as one belt tells the time of all arms.

    Args:
        stream: The stream as it was perceived, with the error of its speed.
        plan: The plan.

    Returns:
        s.
    """
    if stream.speed == 0.0:
        return LATE
    return LATE + stream.speed_error / stream.speed * plan.trajectory.duration


class PickQueries:
    """Asks the arms of a trial for picks, and remembers what the picks so far took.

    Args:
        request: The trial.
        arms: Its arms.

    Attributes:
        planning_ms: Of each query with a plan, ms by the wall clock.
        refusing_ms: Of each query without a plan, ms.
    """

    def __init__(self, request: StreamTrialRequest, arms: StreamArms) -> None:
        self.planning_ms: list[float] = []
        self.refusing_ms: list[float] = []
        self._request, self._arms, self._rule = request, arms, request.rule
        self._took: StreamArm | None = None  # the arm that took the last item
        self._least_taking = np.inf  # s from when the arm moves until an item is off the belt

    def are_made_in_turn(self, stream: ItemStream) -> bool:
        """Whether the first item with a plan is taken: queries are made one after the other then.

        Args:
            stream: The items as they are perceived.

        Returns:
            False if several are asked for side by side.
        """
        return self._rule.most_planned == 1 or stream.speed == 0.0

    def note_taking(self, arm: StreamArm, planned: StreamPlan) -> None:
        """Note which arm carries out a plan, and how long that takes.

        Args:
            arm: The arm.
            planned: The plan.
        """
        self._took, plan = arm, planned.plan
        if plan.tracking is not None:
            takes = times_at_work(plan.segments)[1] - planned.moves_from
            self._least_taking = min(self._least_taking, takes)

    def why_too_late(self, look: BeltLook, riding: RidingItem) -> str:
        """Say that an item leaves its window sooner than any pick so far took, or than any arm can by bounds.

        Both are told at once, at no charge.

        Args:
            look: What is known of the belt.
            riding: The item as it is perceived.

        Returns:
            The reason; "" if it may be taken.
        """
        if look.stream.speed == 0.0:
            return ""
        left = look.seconds_left(riding.id)
        if left < LEAST_SHARE * self._least_taking < np.inf:
            takes = f"no pick took less than {self._least_taking:.1f} s"
            return f"too late: it leaves the window in {left:.1f} s, {takes}"
        reasons = list[str]()
        for arm in self._arms.all:
            query, seen = self._query(riding.id, look.t, arm), replace(look.stream, cell=arm.context.cell)
            never = why_never(arm.context, seen, query, arm.start)
            if never is None:
                return ""
            reasons.append(str(never))
        return reasons[0]

    def option(self, look: BeltLook, item: OpenItem, t: float) -> tuple[PickOption | None, float]:
        """Plan to take an item with the first arm in turn that can, asked one after the other.

        Args:
            look: What is known of the belt.
            item: The item, which notes why an arm has no plan.
            t: s of the stream from which on the first is asked.

        Returns:
            The pick, None if no arm can take the item, and the s that refused queries took.
        """
        free, lasted = self._arms.free(look.t), 0.0
        for arm in self._rule.in_turn(self._arms.all, self._took):
            if arm not in free:
                continue
            planned = self._planned(look.stream, item, arm, t + lasted)
            if planned is not None:
                item.note_plan()
                return PickOption(item, arm, t + lasted, planned), lasted
            lasted += QUERY_CHARGE
        item.note_refusal(look.t, self._arms.next_rest(look.t))
        return None, lasted

    def chosen(self, look: BeltLook, options: Sequence[PickOption], items: Sequence[OpenItem]) -> PickOption:
        """Choose the pick after which most of the others can be begun in time.

        Args:
            look: What is known of the belt.
            options: At least one.
            items: Every item that may still be taken, those of the options among them.

        Returns:
            The one to be carried out.
        """
        picks = list[PlannedPick]()
        for each in options:
            lasts = each.t - look.t + each.planned.plan.trajectory.duration
            picks.append(PlannedPick(each.item.riding.id, lasts, lasts - each.planned.rests_until))
        deadlines: dict[str, float] = {}
        if look.stream.speed > 0.0:
            takes = self._least_taking if self._least_taking < np.inf else 0.0
            deadlines = {each.riding.id: look.seconds_left(each.riding.id) - takes for each in items}
        return options[next_pick(picks, deadlines)]

    def _apart(self, arm: StreamArm, seen: ItemStream, scene: Scene, t: float) -> Certify:
        """Return what certifies a plan of an arm from a time (s) on: it is apart from the others, too."""
        certify = certifier(scene)

        def certified(plan: Plan) -> Plan | Failures:
            why = self._arms.why_not_apart(arm, plan, scene, t, late_by(seen, plan))
            return certify(plan) if why is None else Failures.of(why)

        return certified

    def _query(self, item_id: str, t: float, arm: StreamArm) -> InterceptQuery:
        """Return the query for an item by an arm from a time (s) on."""
        place = self._rule.meeting_place(arm.context, self._request.stream.carrier)
        return InterceptQuery(item_id, t, destination_of(arm.context.cell), place)

    def _planned(self, believed: ItemStream, item: OpenItem, arm: StreamArm, t: float) -> StreamPlan | None:
        """Plan to take an item with an arm from a time (s) on; let it note why not."""
        context = arm.context
        seen = replace(believed, cell=context.cell)
        query = self._query(item.riding.id, t, arm)
        scene, seed = seen.scene_at(t), self._request.seed
        began = time.perf_counter()
        filtered = self._rule.filtered(context, seen, query, seed)
        try:
            certify = self._apart(arm, seen, scene, t)
            plan = plan_intercept(filtered.context, seen, query, arm.start, seed, certify)
        except NoPlanError as error:
            self.refusing_ms.append(1e3 * (time.perf_counter() - began))
            item.refuse(context.cell.arm, str(filtered.explained(error)))
            return None
        self.planning_ms.append(1e3 * (time.perf_counter() - began))
        return StreamPlan(plan, seen)
