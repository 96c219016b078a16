"""Check I/O events: they resolve to the stated times, come in a working order, and fit the tool states."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.errors import Reason
from pickcli.motion.event import AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.scene.scene import Scene
from pickcli.verification.finger_events import leads_to
from pickcli.verification.hold_choice import hold_checks
from pickcli.verification.straightness_check import every_millisecond, tip_points
from pickcli.verification.tool_change_check import check_tool_changes
from pickcli.verification.vacuum_events import EVENT_TIME_TOLERANCE, TimedEvent

WAY_TOLERANCE = 5e-4  # m of tool path, for anchors by arc length


def check_io(plan: Plan, scene: Scene) -> tuple[Reason, ...]:
    """Check all events of the plan against its motion and the cell's devices.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        The faults.
    """
    reasons = [*_resolved(plan, scene)]
    if not reasons:
        commands = [
            TimedEvent(e.device, scene.cell.devices[e.device].kind, e.action, e.t_trigger, e.t_anchor)
            for e in plan.events
            if e.t_trigger is not None
            if e.t_anchor is not None
        ]
        tool = scene.cell.robot.tool
        order = hold_checks(tool).events(plan, scene, commands)
        reasons = [*_apart(commands), *order, *_tool_state(plan, scene.cell.robot, commands)]
    return tuple(reasons)


def _resolved(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check device, lead and both times of every event."""
    for i, event in enumerate(plan.events):
        where = f"event {i} ({event.device} {event.action})"
        device = scene.cell.devices.get(event.device)
        if device is None or event.action not in device.actions:
            yield Reason("unknown device or action", where, "the cell has no such")
        elif event.lead != device.lead:
            yield Reason("wrong lead", where, f"{event.lead} s, the device needs {device.lead} s")
        elif event.t_anchor is None or event.t_trigger is None:
            yield Reason("not resolved", where, "an event needs its times before it may run")
        elif abs(event.t_trigger - (event.t_anchor - event.lead)) > EVENT_TIME_TOLERANCE:
            expected = event.t_anchor - event.lead
            yield Reason(
                "wrong trigger", where, f"at {event.t_trigger:.3f} s, anchor less lead is {expected:.3f} s"
            )
        elif not -EVENT_TIME_TOLERANCE <= event.t_trigger <= plan.trajectory.duration + EVENT_TIME_TOLERANCE:
            yield Reason("trigger outside the motion", where, f"at {event.t_trigger:.3f} s")
        elif (
            device.kind is scene.cell.robot.tool.mover
            and event.t_anchor > plan.trajectory.duration + EVENT_TIME_TOLERANCE
        ):
            detail = (
                f"it moves until {event.t_anchor:.3f} s, the motion ends at {plan.trajectory.duration:.3f} s"
            )
            yield Reason("moves after the motion", where, detail)
        else:
            yield from _anchored(plan, scene, event, where)


def _apart(commands: Iterable[TimedEvent]) -> Iterator[Reason]:
    """Check that no device gets two commands at the same time: their order would be undefined."""
    for one, other in pairwise(sorted(commands, key=lambda command: (command.device, command.trigger))):
        if one.device == other.device and other.trigger - one.trigger <= EVENT_TIME_TOLERANCE:
            where = f"{one.device} {one.action} and {other.action}"
            yield Reason("commands at the same time", where, f"both at {one.trigger:.3f} s")


def _anchored(plan: Plan, scene: Scene, event: Event, where: str) -> Iterator[Reason]:
    """Check that the anchor's place is passed at ``t_anchor``."""
    assert event.t_anchor is not None
    anchor, segment = event.anchor, plan.segments[event.anchor.segment]
    if anchor.kind is AnchorKind.ARC_LENGTH:
        way = _way(plan, scene, segment, event.t_anchor)
        if abs(way - anchor.offset) > WAY_TOLERANCE:
            yield Reason(
                "wrong anchor time", where, f"{way * 1e3:.1f} mm of way, {anchor.offset * 1e3:.1f} stated"
            )
        return
    start = segment.t_end if anchor.kind is AnchorKind.SEGMENT_END else segment.t_start
    if abs(event.t_anchor - (start + anchor.offset)) > EVENT_TIME_TOLERANCE:
        yield Reason(
            "wrong anchor time", where, f"{event.t_anchor:.3f} s, resolves to {start + anchor.offset:.3f} s"
        )


def _way(plan: Plan, scene: Scene, segment: Segment, t: float) -> float:
    """Return the path length of the tool in m from a segment's start to a time; negative before it."""
    times = every_millisecond(*sorted((segment.t_start, t)))
    p = tip_points(plan, scene.cell.robot, segment.tool_state, times)
    return float(np.copysign(np.linalg.norm(np.diff(p, axis=0), axis=1).sum(), t - segment.t_start))


def _tool_state(plan: Plan, robot: Robot, commands: Iterable[TimedEvent]) -> Iterator[Reason]:
    """Check that commands bring about the tool states that segments state, at rest if an item is held."""
    moves = sorted(
        (command for command in commands if command.kind is robot.tool.mover),
        key=lambda command: command.trigger,
    )
    for k, segment in enumerate(plan.segments):
        if segment.tool_state != MOVING:
            yield from _still(segment, moves, f"segment {k} ({segment.kind})")
    yield from check_tool_changes(plan, robot, moves)
    yield from _changes(plan.segments, robot.tool, moves)


def _still(segment: Segment, moves: Iterable[TimedEvent], where: str) -> Iterator[Reason]:
    """Check that no command moves the cup during a segment that states a fixed tool state."""
    for move in moves:
        if (
            move.trigger < segment.t_end - EVENT_TIME_TOLERANCE
            and move.complete > segment.t_start + EVENT_TIME_TOLERANCE
        ):
            detail = f"moves to {move.action} from {move.trigger:.3f} to {move.complete:.3f} s"
            yield Reason("wrong tool state", where, detail)


def _changes(segments: Sequence[Segment], tool: Tool, moves: Iterable[TimedEvent]) -> Iterator[Reason]:
    """Check that every resting state is the result of the last command before it, or the initial state."""
    at_start = segments[0].tool_state
    for k, segment in enumerate(segments):
        known = [] if at_start == MOVING else [at_start]
        known += [ToolState(m.action) for m in moves if m.complete <= segment.t_start + EVENT_TIME_TOLERANCE]
        if segment.tool_state != MOVING and not any(leads_to(tool, last, segment) for last in known[-1:]):
            said = (
                f"the commands leave it {known[-1]}" if known else "no command says to where it moves before"
            )
            where = f"segment {k} ({segment.kind})"
            yield Reason("wrong tool state", where, f"stated {segment.tool_state}, {said}")
