"""Binding of the events of a pick to its timed motion, with the wait that a long lead needs."""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.cell.cell import Cell
from pickcli.errors import Failures
from pickcli.io_events.bind import bind_pick
from pickcli.io_events.resolve import delay_segments, resolve
from pickcli.motion.event import Event
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.concatenation import delayed

BoundEvents = tuple[tuple[Segment, ...], Trajectory, tuple[Event, ...]]


def bound_events(
    cell: Cell, segments: Sequence[Segment], trajectory: Trajectory, taking: float, releasing: float
) -> BoundEvents | Failures:
    """Bind the events of a pick to its timed motion.

    If a lead is longer than the motion before its anchor (a pump that takes 2 s, a near item), the robot
    first waits for the missing time.

    Args:
        cell: The cell, which has the tool and the devices.
        segments: The segments with their times.
        trajectory: The timed motion.
        taking: s for which the arm rests when the item is taken.
        releasing: s for which it rests when the item is released.

    Returns:
        Segments, trajectory and events with their times; or every event that cannot be bound.
    """
    tool, devices = cell.robot.tool, cell.devices
    events = bind_pick(segments, devices, tool, taking, releasing)
    resolution = resolve(events, segments, trajectory)
    if resolution.start_delay > 0.0:
        trajectory = delayed(trajectory, resolution.start_delay)
        segments = delay_segments(segments, resolution.start_delay)
        resolution = resolve(events, segments, trajectory)
    if resolution.reasons:
        return Failures(resolution.reasons)
    return tuple(segments), trajectory, resolution.events
