"""A pick from a running conveyor: the query, and the belt as it sees it."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.errors import NoPlanError, Reason
from pickcli.motion.plan import LineTracking, Plan, times_at_work
from pickcli.scene.belt_sweep import swept_along_belt
from pickcli.scene.item_stream import ItemStream, after_travel
from pickcli.scene.scene import TOTE, Scene

PACED_COMING = 0.9  # of the limits, the most on the way to a belt: its time is that of the belt
WIDELY_LATE = 0.25  # s that all grasps are too late, for which no others are searched: a rule, not a proof
DEVIATION = 0.015  # m by which the belt may be off the plan while an axis follows it: 1 to 4 mm are usual


def pumped_from(cell: Cell) -> float:
    """Return from when on the pump draws, which is switched on at the start of the plan.

    Args:
        cell: The cell.

    Returns:
        s; 0 without a pump.
    """
    leads = (each.lead for each in cell.devices.values() if each.kind is DeviceKind.PUMP)
    return max(leads, default=0.0)


@dataclass(frozen=True)
class InterceptQuery:
    """A requested pick from a stream.

    Attributes:
        item: Id of the item in the stream.
        now: s, time of the stream at which the plan starts.
        into: Place that the item is brought to.
        meet_at: m from the infeed, travel of the item's middle at which contact is to be made; None for the
            earliest contact that is found. It has no meaning for a belt that stands.
    """

    item: str
    now: float
    into: str = TOTE
    meet_at: float | None = None

    def label(self, place: str) -> str:
        """Name the query in plans and messages.

        Args:
            place: The conveyor.

        Returns:
            The name.
        """
        return f"pick {self.item} from {place}" + (f" into {self.into}" if self.into != TOTE else "")


@dataclass(frozen=True, eq=False)
class QueryBelt:
    """The belt as one query sees it; times are from the start of the plan.

    Attributes:
        stream: The items on it.
        now: s of the stream at the start of the plan.
        start: Scene then.
        first: s at which the item enters the window.
        last: s at which it leaves the window.
        meets: s at which contact is to be made; None for the earliest that is found.
        deviation: m by which the belt may be off the plan while the arm follows it.
    """

    stream: ItemStream
    now: float
    start: Scene
    first: float
    last: float
    meets: float | None = field(default=None, kw_only=True)
    deviation: float = field(default=DEVIATION, kw_only=True)

    @classmethod
    def of(cls, stream: ItemStream, scene: Scene, query: InterceptQuery) -> QueryBelt:
        """Describe the belt for a query.

        Args:
            stream: The items on the conveyor, which runs.
            scene: The scene at the start of the plan.
            query: The requested pick.

        Returns:
            The belt.

        Raises:
            NoPlanError: The item is not on the belt yet, has left the window, or has passed the place where
                it is to be met.
        """
        riding = stream.find(query.item)
        travel = stream.travel_at(riding, query.now)
        first, last = ((edge - travel) / stream.speed for edge in stream.belt.window)
        where = f"{riding.id} at {query.now:g} s"

        def never(what: str, detail: str) -> NoPlanError:
            return NoPlanError(query.label(stream.conveyor), [Reason(what, where, detail)])

        if not stream.is_on_belt(riding, query.now) and last > 0.0:
            behind = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[0])
            enters = riding.stamp + (behind - float(riding.T_belt_item[0, 3])) / stream.speed
            enters = float(np.ceil(100.0 * enters)) / 100.0
            raise never(
                "not on the belt yet", f"it is wholly past the infeed at {enters:.2f} s; plan for then"
            )
        if last <= 0.0:
            raise never("out of the window", f"it left the window {-last:.2f} s before")
        meets = None if query.meet_at is None else (query.meet_at - travel) / stream.speed
        if meets is not None and meets < 0.0:
            raise never(
                "past its meeting", f"it was {query.meet_at:g} m from the infeed {-meets:.2f} s before"
            )
        return cls(stream, query.now, scene, first, last, meets=meets)

    @property
    def tracking(self) -> LineTracking:
        """The belt as plans state it."""
        stream = self.stream
        return LineTracking(stream.conveyor, stream.speed, stream.speed_error, self.deviation, self.now)

    @property
    def only_there(self) -> str:
        """For reasons, the one place at which a rule lets items be met; "" if they may be met anywhere."""
        if self.meets is None:
            return ""
        place = self.stream.belt.window[0] + self.stream.speed * (self.meets - self.first)
        return f"; the rule lets items be met at {place:.2f} m from the infeed only"

    def brought_too_far(self, plan: Plan, grasp: str) -> Reason | None:
        """Say that the belt brings what is not known until a plan ends, at the most that it may run.

        Args:
            plan: The plan.
            grasp: Its grasp, for the message.

        Returns:
            The reason, or None.
        """
        t_left = times_at_work(plan.segments)[1]
        brought = self.tracking.brought_by(plan.trajectory.duration, t_left, self.stream.belt.max_speed)
        known = self.stream.belt.upstream
        if brought <= known:
            return None
        lasts = f"the belt brings {brought:.1f} m meanwhile, what comes is known for {known:.1f} m"
        return Reason("lasts too long", grasp, lasts)

    def at(self, t: float) -> Scene:
        """Return the scene at a time.

        Args:
            t: s.

        Returns:
            The scene.
        """
        return after_travel(self.start, self.stream.conveyor, self.stream.speed * t)

    @cached_property
    def coming(self) -> Scene:
        """The scene at the start with all that the items on the belt may come to."""
        return swept_along_belt(self.start, self.stream.conveyor)

    def left(self, t: float) -> Scene:
        """Return the scene with all that the items may come to once the tool has left the belt.

        Args:
            t: s at which it leaves it.

        Returns:
            The scene.
        """
        return swept_along_belt(self.at(t), self.stream.conveyor, self.deviation)
