"""I/O events: they resolve to the stated times, come in an order that works, and fit the tool states."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.errors import Reason
from pickcli.motion.event import AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.finger_events import check_finger_events, leads_to
from pickcli.verification.straightness_check import every_millisecond, fastest_tip, tip_points

TIME_TOLERANCE = 1e-6  # s
WAY_TOLERANCE = 5e-4  # m of tool path, for anchors by arc length
OPENS_WITHIN = 0.005  # m before the cup is pressed on: farther off, vacuum leaks and light items are dragged
CLOSES_WITHIN = 0.010  # m before the place of release
# m/s of the tool from the command to let go on: an item that leaves the cup at it, from the highest place
# that is allowed, lands 25 mm aside. From when the valve is closed on the tool stands.
RELEASE_SPEED, STANDING = 0.1, 0.002
RESTING = 1e-6  # rad or m by which a joint that rests may move: what a motion written as text rounds
LAST_MOMENT = 1e-3  # s before the release in which the tool's speed counts, however late the valve closes


@dataclass(frozen=True)
class _Command:
    """An event whose times are known.

    device, action: as of the event. kind: what the device does
    trigger: s, when the command is given. complete: s, when its effect is
    """

    device: str
    kind: DeviceKind
    action: str
    trigger: float
    complete: float


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
            _Command(e.device, scene.cell.devices[e.device].kind, e.action, e.t_trigger, e.t_anchor)
            for e in plan.events
            if e.t_trigger is not None
            if e.t_anchor is not None
        ]
        tool = scene.cell.robot.tool
        if tool.gripper is None:
            order = [*_order(plan, scene, commands)]
        else:
            order = [*check_finger_events(plan, scene)]
        reasons = [*_apart(commands), *order, *_tool_state(plan, tool, commands)]
    return tuple(reasons)


def _resolved(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Device, lead and both times of every event."""
    for i, event in enumerate(plan.events):
        where = f"event {i} ({event.device} {event.action})"
        device = scene.cell.devices.get(event.device)
        if device is None or event.action not in device.actions:
            yield Reason("unknown device or action", where, "the cell has no such")
        elif event.lead != device.lead:
            yield Reason("wrong lead", where, f"{event.lead} s, the device needs {device.lead} s")
        elif event.t_anchor is None or event.t_trigger is None:
            yield Reason("not resolved", where, "an event needs its times before it may run")
        elif abs(event.t_trigger - (event.t_anchor - event.lead)) > TIME_TOLERANCE:
            expected = event.t_anchor - event.lead
            yield Reason(
                "wrong trigger", where, f"at {event.t_trigger:.3f} s, anchor less lead is {expected:.3f} s"
            )
        elif not -TIME_TOLERANCE <= event.t_trigger <= plan.trajectory.duration + TIME_TOLERANCE:
            yield Reason("trigger outside the motion", where, f"at {event.t_trigger:.3f} s")
        elif (
            device.kind is scene.cell.robot.tool.mover
            and event.t_anchor > plan.trajectory.duration + TIME_TOLERANCE
        ):
            detail = (
                f"it moves until {event.t_anchor:.3f} s, the motion ends at {plan.trajectory.duration:.3f} s"
            )
            yield Reason("moves after the motion", where, detail)
        else:
            yield from _anchored(plan, scene, event, where)


def _apart(commands: Iterable[_Command]) -> Iterator[Reason]:
    """No device gets two commands at one moment: nobody knows which of them comes last."""
    for one, other in pairwise(sorted(commands, key=lambda command: (command.device, command.trigger))):
        if one.device == other.device and other.trigger - one.trigger <= TIME_TOLERANCE:
            where = f"{one.device} {one.action} and {other.action}"
            yield Reason("commands at the same time", where, f"both at {one.trigger:.3f} s")


def _anchored(plan: Plan, scene: Scene, event: Event, where: str) -> Iterator[Reason]:
    """The anchor's place is passed at ``t_anchor``."""
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
    if abs(event.t_anchor - (start + anchor.offset)) > TIME_TOLERANCE:
        yield Reason(
            "wrong anchor time", where, f"{event.t_anchor:.3f} s, resolves to {start + anchor.offset:.3f} s"
        )


def _way(plan: Plan, scene: Scene, segment: Segment, t: float) -> float:
    """Way of the tool in m from a segment's start to a time; negative before it."""
    times = every_millisecond(*sorted((segment.t_start, t)))
    p = tip_points(plan, scene.cell.robot, segment.tool_state, times)
    return float(np.copysign(np.linalg.norm(np.diff(p, axis=0), axis=1).sum(), t - segment.t_start))


def _order(plan: Plan, scene: Scene, commands: Sequence[_Command]) -> Iterator[Reason]:
    """Vacuum when the cup is pressed on, sensor while holding, air again where the item is released."""
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    held = [s for s in plan.segments if s.held is not None]
    find = _finder(commands)
    if contact is not None:
        lift_end = next((s.t_start for s in held if s.kind is not SegmentKind.LIFT), held[-1].t_end)
        sealing = contact.t_end - scene.cell.robot.tool.cup.seal_time
        yield from _rests(plan, sealing, contact.t_end)
        yield from _needed("pump on", find(DeviceKind.PUMP, "on"), latest=sealing)
        yield from _needed("valve on", find(DeviceKind.VALVE, "on"), latest=sealing)
        yield from _needed("sensor read", find(DeviceKind.SENSOR, "read"), lift_end, held[-1].t_end)
        for valve in find(DeviceKind.VALVE, "on"):
            yield from _near(plan, scene, contact, valve.complete, OPENS_WITHIN, "valve on")
        for kind in (DeviceKind.PUMP, DeviceKind.VALVE):
            yield from _is_on(find(kind, "on"), find(kind, "off"), contact.t_end)
    off = find(DeviceKind.PUMP, "off") + find(DeviceKind.VALVE, "off")
    if not held:
        for command in find(DeviceKind.PUMP, "on") + find(DeviceKind.VALVE, "on"):
            if contact is None:
                yield Reason("vacuum for nothing", f"{command.device} on", "the plan takes and holds nothing")
    elif plan.segments[-1].held is not None:
        yield from _kept(off, held[0].t_start, np.inf)
    else:
        yield from _release(plan, scene, held[0], held[-1], find)


def _rests(plan: Plan, t_start: float, t_end: float) -> Iterator[Reason]:
    """No joint moves while the vacuum builds up under the cup."""
    q = plan.trajectory.sample(every_millisecond(max(0.0, t_start), t_end))
    moved = float(np.ptp(q, axis=0).max())
    if t_start < 0.0 or moved > RESTING:
        needed = f"the tool is to rest on the item from {t_start:.3f} to {t_end:.3f} s"
        yield Reason("no time to seal", "contact", f"{needed}; a joint moves by {moved:.6f} rad or m")


def _release(
    plan: Plan,
    scene: Scene,
    first: Segment,
    last: Segment,
    find: Callable[[DeviceKind, str], list[_Command]],
) -> Iterator[Reason]:
    """The valve closes where the item is released, the pump stops, and nothing lets the vacuum go before."""
    valves, pumps = find(DeviceKind.VALVE, "off"), find(DeviceKind.PUMP, "off")
    yield from _needed("valve off", valves, last.t_start, last.t_end)
    if not valves:
        yield from _needed("pump off", pumps, last.t_end)
    for valve in valves:
        yield from _near(plan, scene, last, valve.trigger, CLOSES_WITHIN, "valve off")
        yield from _slow(plan, scene, last, valve)
        yield from _needed("pump off", pumps, valve.trigger)
        yield from _kept(pumps + valves, first.t_start, valve.trigger - TIME_TOLERANCE)


def _slow(plan: Plan, scene: Scene, last: Segment, valve: _Command) -> Iterator[Reason]:
    """The tool is nearly at rest where the item is let go: it is set down or dropped, and not thrown."""
    for at, most in ((valve.trigger, RELEASE_SPEED), (valve.complete, STANDING)):
        t = max(last.t_start, min(at, last.t_end - LAST_MOMENT))
        speed = fastest_tip(plan, scene.cell.robot, last.tool_state, t, last.t_end)
        if speed > most:
            detail = f"the tool moves at {speed:.3f} m/s from {t:.3f} s on, at most {most} m/s"
            yield Reason("released too fast", "valve off", detail)
            return


def _is_on(on: Iterable[_Command], off: Iterable[_Command], t: float) -> Iterator[Reason]:
    """What was switched on last before a time is not switched off again until then."""
    since = max((command.trigger for command in on if command.trigger <= t), default=np.inf)
    for command in off:
        if since <= command.trigger <= t:
            at = f"at {command.trigger:.3f} s, before the contact is made"
            yield Reason("vacuum lost", f"{command.device} off", at)


def _kept(off: Iterable[_Command], t_start: float, t_end: float) -> Iterator[Reason]:
    """Nothing is switched off from one time on and before another."""
    for command in off:
        if t_start - TIME_TOLERANCE <= command.trigger < t_end:
            where = f"{command.device} off"
            yield Reason("vacuum lost", where, f"at {command.trigger:.3f} s the item is still held")


def _near(plan: Plan, scene: Scene, segment: Segment, t: float, most: float, what: str) -> Iterator[Reason]:
    """At a time the tool is at most so far, in m, from where the segment ends."""
    times = np.array([t, segment.t_end])
    at, end = tip_points(plan, scene.cell.robot, segment.tool_state, times)
    away = float(np.linalg.norm(at - end))
    if away > most:
        where = f"the tool is {away * 1e3:.0f} mm away, at most {most * 1e3:.0f}"
        yield Reason("event at the wrong place", what, where)


def _finder(commands: Iterable[_Command]) -> Callable[[DeviceKind, str], list[_Command]]:
    def find(kind: DeviceKind, action: str) -> list[_Command]:
        return [command for command in commands if command.kind is kind and command.action == action]

    return find


def _needed(
    what: str, commands: Sequence[_Command], earliest: float = 0.0, latest: float = np.inf
) -> Iterator[Reason]:
    """Exactly one command whose effect is complete between two times."""
    if len(commands) != 1:
        found = f"{len(commands)} of them, needs one"
        yield Reason("event twice" if commands else "event missing", what, found)
    for command in commands:
        if not earliest - TIME_TOLERANCE <= command.complete <= latest + TIME_TOLERANCE:
            needs = f"{command.complete:.3f} s, needs {earliest:.3f}..{latest:.3f} s"
            yield Reason("event at the wrong time", what, needs)


def _tool_state(plan: Plan, tool: Tool, commands: Iterable[_Command]) -> Iterator[Reason]:
    """Segments say what the cup does; commands must make it so, at rest in the hand."""
    moves = sorted(
        (command for command in commands if command.kind is tool.mover),
        key=lambda command: command.trigger,
    )
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        if segment.tool_state != MOVING:
            yield from _still(segment, moves, where)
        elif segment.held is not None:
            detail = "the load on the cup would not be known"
            yield Reason("tool changes its state while holding", where, detail)
    yield from _changes(plan.segments, tool, moves)


def _still(segment: Segment, moves: Iterable[_Command], where: str) -> Iterator[Reason]:
    """No command moves the cup while a segment counts on its state."""
    for move in moves:
        if move.trigger < segment.t_end - TIME_TOLERANCE and move.complete > segment.t_start + TIME_TOLERANCE:
            told = f"moves to {move.action} from {move.trigger:.3f} to {move.complete:.3f} s"
            yield Reason("wrong tool state", where, told)


def _changes(segments: Sequence[Segment], tool: Tool, moves: Iterable[_Command]) -> Iterator[Reason]:
    """Every resting state is the one that the last command before it leads to, or the one at the start."""
    at_start = segments[0].tool_state
    for k, segment in enumerate(segments):
        known = [] if at_start == MOVING else [at_start]
        known += [ToolState(m.action) for m in moves if m.complete <= segment.t_start + TIME_TOLERANCE]
        if segment.tool_state != MOVING and not any(leads_to(tool, last, segment) for last in known[-1:]):
            said = (
                f"the commands leave it {known[-1]}" if known else "no command says to where it moves before"
            )
            where = f"segment {k} ({segment.kind})"
            yield Reason("wrong tool state", where, f"stated {segment.tool_state}, {said}")
