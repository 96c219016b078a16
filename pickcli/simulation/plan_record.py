"""Record of how a driver carried out a plan."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.motion.event import Event
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.operator_stop import OperatorStop
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.stream import Violation


@dataclass(frozen=True)
class FiredEvent:
    """A fired event.

    Attributes:
        event: The event.
        t: s, by the driver's clock.
        distance: m of tool path between the robot and the event's resolved trigger point.
        reading: A sensor's reading, else None.
    """

    event: Event
    t: float
    distance: float
    reading: bool | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class PlanRecord:
    """Commands and measurements of an execution. Times are those of the driver's clock.

    Attributes:
        t_start: s.
        t_end: s.
        stop: The stop that ended it early, or None.
        stopped_in: Kind of the segment in which it was requested.
        events: Events that fired.
        missed: Events that never fired.
        limit_violations: Limits that the commands exceeded.
        max_lag: m, largest distance between the actual and the commanded tool position.
        path_time: Time on the plan's trajectory at which the robot came to rest after a stop, s; None without
            one.
        stopping_time: s from the request of a stop to standstill; None without one.
        operator_stops: Stops by the operator, times since ``t_start``.
        is_clear: Whether the arm rests where nothing that a conveyor may bring touches it, after a stop of a
            motion that followed one; None without one.
        stops_on_way_off: What was judged to be amiss on the way off a conveyor, after the stop.
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
    operator_stops: tuple[OperatorStop, ...] = ()
    is_clear: bool | None = None
    stops_on_way_off: tuple[ProtectiveStop, ...] = ()

    @property
    def duration(self) -> float:
        """Duration from the first command to the last step, s."""
        return self.t_end - self.t_start

    @property
    def stopped(self) -> str:
        """Why the execution ended early, in words; "" if it did not."""
        return "" if self.stop is None else str(self.stop)

    @property
    def stop_cause(self) -> StopCause | None:
        """The cause of the stop, None without one."""
        return None if self.stop is None else self.stop.cause

    @property
    def has_item(self) -> bool | None:
        """Whether an item is held by the last reading: of a sensor, or a stop for lack of vacuum after it.

        None without either.
        """
        if self.stop is not None and any(each.is_empty for each in (self.stop, *self.stops_on_way_off)):
            return False
        readings = [fired.reading for fired in self.events if fired.reading is not None]
        return readings[-1] if readings else None

    @property
    def is_clean(self) -> bool:
        """Whether the plan was carried out completely and without faults."""
        return not self.trouble

    @property
    def counts(self) -> tuple[tuple[int, str], ...]:
        """Numbers and names of the kinds of events that must not happen."""
        return ((len(self.limit_violations), "limit violations"), (len(self.missed), "events missed"))

    @property
    def trouble(self) -> str:
        """Summary of all faults in one sentence; "" without any."""
        parts = [f"{n} {what}" for n, what in self.counts if n]
        if self.stopped:
            where = f" in {self.stopped_in}" if self.stopped_in else ""
            parts.append(f"stopped{where}: {self.stopped}")
        parts += [f"on the way off the conveyor: {stop}" for stop in self.stops_on_way_off]
        return "; ".join(parts)
