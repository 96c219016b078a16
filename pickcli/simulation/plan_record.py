"""Record of how a driver carried out a plan, as values."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.motion.event import Event
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.stream import Violation


@dataclass(frozen=True)
class FiredEvent:
    """An event when it fired.

    Attributes:
        event: The event.
        t: s, by the driver's clock.
        distance: m of tool path between where the robot was and the event's resolved trigger point.
        reading: What a sensor answered, else None.
    """

    event: Event
    t: float
    distance: float
    reading: bool | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PlanRecord:
    """What a driver was told and what was measured. Times are those of the driver's clock.

    Attributes:
        t_start: s.
        t_end: s.
        stop: Why it ended before the plan did, None if it did not.
        stopped_in: The segment it was in then.
        events: Events that fired.
        missed: Events that never fired.
        limit_violations: Limits that the commands broke.
        max_lag: m, farthest that the tool was from where it was told to be.
        path_time: Where the robot came to rest after a stop, as a time of the plan's trajectory, s; None
            without one.
        stopping_time: s from the request of a stop to standstill; None without one.
    """

    t_start: float
    t_end: float
    stop: ProtectiveStop | None
    stopped_in: SegmentKind | None
    events: tuple[FiredEvent, ...]
    missed: tuple[Event, ...]
    limit_violations: tuple[Violation, ...]
    max_lag: float
    path_time: float | None = None
    stopping_time: float | None = None

    @property
    def duration(self) -> float:
        """Duration from the first command to the last step, s."""
        return self.t_end - self.t_start

    @property
    def stopped(self) -> str:
        """Why the execution ended before the plan did, in words; "" if it did not."""
        return "" if self.stop is None else str(self.stop)

    @property
    def stop_cause(self) -> StopCause | None:
        """What the robot knew that made it stop, None if it did not."""
        return None if self.stop is None else self.stop.cause

    @property
    def has_item(self) -> bool | None:
        """What the vacuum said last: the sensor's answer, or the stop for want of vacuum after it.

        None if neither was there.
        """
        if self.stop is not None and self.stop.is_empty:
            return False
        readings = [fired.reading for fired in self.events if fired.reading is not None]
        return readings[-1] if readings else None

    @property
    def is_clean(self) -> bool:
        """Whether the plan was carried out to its end, and nothing went wrong."""
        return not self.trouble

    @property
    def counts(self) -> tuple[tuple[int, str], ...]:
        """How often what must not happen did, and what."""
        return ((len(self.limit_violations), "limit violations"), (len(self.missed), "events missed"))

    @property
    def trouble(self) -> str:
        """What went wrong, in one sentence; "" if nothing did."""
        parts = [f"{n} {what}" for n, what in self.counts if n]
        if self.stopped:
            where = f" in {self.stopped_in}" if self.stopped_in else ""
            parts.append(f"stopped{where}: {self.stopped}")
        return "; ".join(parts)
