"""I/O events: they resolve to the stated times, come in an order that works, and fit the tool states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import Reason
from pickcli.motion.event import AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.straightness_check import fastest_tip

TIME_TOLERANCE = 1e-6  # s
WAY_TOLERANCE = 5e-4  # m of tool path, for anchors by arc length
OPENS_WITHIN = 0.005  # m before the cup is pressed on: farther off, vacuum leaks and light items are dragged
CLOSES_WITHIN = 0.010  # m before the place of release
# m/s of the tool from the command to let go on: an item that leaves the cup at it, from the highest place
# that is allowed, lands 25 mm aside. From when the valve is closed on the tool stands.
RELEASE_SPEED, STANDING = 0.1, 0.002
RESTING = 1e-6  # rad or m by which a joint that rests may move: what a motion written as text rounds
LAST_MOMENT = 1e-3  # s before the release in which the tool's speed counts, however late the valve closes


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
        reasons = [*_apart(plan), *_order(plan, scene), *_tool_state(plan, scene)]
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
            device.kind is DeviceKind.TOOL_ACTUATOR
            and event.t_anchor > plan.trajectory.duration + TIME_TOLERANCE
        ):
            detail = (
                f"it moves until {event.t_anchor:.3f} s, the motion ends at {plan.trajectory.duration:.3f} s"
            )
            yield Reason("moves after the motion", where, detail)
        else:
            yield from _anchored(plan, scene, event, where)


def _apart(plan: Plan) -> Iterator[Reason]:
    """No device gets two commands at one moment: nobody knows which of them comes last."""
    events = sorted(plan.events, key=lambda event: (event.device, event.t_trigger or 0.0))
    for one, other in pairwise(events):
        assert one.t_trigger is not None and other.t_trigger is not None
        if one.device == other.device and other.t_trigger - one.t_trigger <= TIME_TOLERANCE:
            where = f"{one.device} {one.action} and {other.action}"
            yield Reason("commands at the same time", where, f"both at {one.t_trigger:.3f} s")


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
    a, b = sorted((segment.t_start, t))
    times = np.linspace(a, b, max(2, int(np.ceil((b - a) * 1e3)) + 1))
    robot = scene.cell.robot
    p = tip_poses(robot, link_poses(robot, plan.trajectory.sample(times)), segment.tool_state)[:, :3, 3]
    way = float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())
    return way if t >= segment.t_start else -way


def _order(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Vacuum when the cup is pressed on, sensor while holding, air again where the item is released."""
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    held = [s for s in plan.segments if s.held is not None]
    find = _finder(plan, scene)
    if contact is not None:
        lift_end = next((s.t_start for s in held if s.kind is not SegmentKind.LIFT), held[-1].t_end)
        sealing = contact.t_end - scene.cell.robot.tool.cup.seal_time
        yield from _rests(plan, sealing, contact.t_end)
        yield from _needed("pump on", find(DeviceKind.PUMP, "on"), 0.0, sealing)
        yield from _needed("valve on", find(DeviceKind.VALVE, "on"), 0.0, sealing)
        yield from _needed("sensor read", find(DeviceKind.SENSOR, "read"), lift_end, held[-1].t_end)
        for event in find(DeviceKind.VALVE, "on"):
            yield from _near(plan, scene, contact, event.t_anchor, OPENS_WITHIN, "valve on")
        for kind in (DeviceKind.PUMP, DeviceKind.VALVE):
            yield from _is_on(find(kind, "on"), find(kind, "off"), contact.t_end)
    if contact is None and not held:
        for event in find(DeviceKind.PUMP, "on") + find(DeviceKind.VALVE, "on"):
            yield Reason("vacuum for nothing", f"{event.device} on", "the plan takes and holds nothing")
    if held and plan.segments[-1].held is not None:
        yield from _kept(
            find(DeviceKind.PUMP, "off") + find(DeviceKind.VALVE, "off"), held[0].t_start, np.inf
        )
    if held and plan.segments[-1].held is None:
        yield from _release(plan, scene, held[0], held[-1], find)


def _rests(plan: Plan, t_start: float, t_end: float) -> Iterator[Reason]:
    """No joint moves while the vacuum builds up under the cup."""
    times = np.linspace(max(0.0, t_start), t_end, int(np.ceil((t_end - t_start) * 1e3)) + 1)
    q = plan.trajectory.sample(times)
    moved = float(np.abs(q - q[-1]).max())
    if t_start < 0.0 or moved > RESTING:
        needed = f"the tool is to rest on the item from {t_start:.3f} to {t_end:.3f} s"
        yield Reason("no time to seal", "contact", f"{needed}; a joint moves by {moved:.6f} rad or m")


def _release(
    plan: Plan, scene: Scene, first: Segment, last: Segment, find: Callable[[DeviceKind, str], list[Event]]
) -> Iterator[Reason]:
    """The valve closes where the item is released, the pump stops, and nothing lets the vacuum go before."""
    valves = find(DeviceKind.VALVE, "off")
    yield from _needed("valve off", valves, last.t_start, last.t_end)
    for event in valves:
        yield from _near(plan, scene, last, event.t_trigger, CLOSES_WITHIN, "valve off")
        yield from _slow(plan, scene, last, event)
    released = max((e.t_trigger for e in valves if e.t_trigger is not None), default=last.t_end)
    pumps = find(DeviceKind.PUMP, "off")
    yield from _needed("pump off", pumps, released, np.inf)
    yield from _kept(pumps + valves, first.t_start, released - TIME_TOLERANCE)


def _slow(plan: Plan, scene: Scene, last: Segment, event: Event) -> Iterator[Reason]:
    """The tool is nearly at rest where the item is let go: it is set down or dropped, and not thrown."""
    for at, most in ((event.t_trigger, RELEASE_SPEED), (event.t_anchor, STANDING)):
        if at is not None:
            t = max(last.t_start, min(at, last.t_end - LAST_MOMENT))
            speed = fastest_tip(plan, scene.cell.robot, last.tool_state, t, last.t_end)
            if speed > most:
                detail = f"the tool moves at {speed:.3f} m/s from {t:.3f} s on, at most {most} m/s"
                yield Reason("released too fast", "valve off", detail)
                return


def _is_on(on: list[Event], off: list[Event], t: float) -> Iterator[Reason]:
    """What was switched on last before a time is not switched off again until then."""
    since = max((e.t_trigger for e in on if e.t_trigger is not None and e.t_trigger <= t), default=np.inf)
    for event in off:
        if event.t_trigger is not None and since <= event.t_trigger <= t:
            at = f"at {event.t_trigger:.3f} s, before the contact is made"
            yield Reason("vacuum lost", f"{event.device} off", at)


def _kept(off: list[Event], t_start: float, t_end: float) -> Iterator[Reason]:
    """Nothing is switched off from one time on and before another."""
    for event in off:
        if event.t_trigger is not None and t_start - TIME_TOLERANCE <= event.t_trigger < t_end:
            where = f"{event.device} off"
            yield Reason("vacuum lost", where, f"at {event.t_trigger:.3f} s the item is still held")


def _near(
    plan: Plan, scene: Scene, segment: Segment, t: float | None, most: float, what: str
) -> Iterator[Reason]:
    """At a time the tool is at most so far, in m, from where the segment ends."""
    assert t is not None
    robot = scene.cell.robot
    at, end = tip_poses(
        robot, link_poses(robot, plan.trajectory.sample(np.array([t, segment.t_end]))), segment.tool_state
    )
    away = float(np.linalg.norm(at[:3, 3] - end[:3, 3]))
    if away > most:
        where = f"the tool is {away * 1e3:.0f} mm away, at most {most * 1e3:.0f}"
        yield Reason("event at the wrong place", what, where)


def _finder(plan: Plan, scene: Scene) -> Callable[[DeviceKind, str], list[Event]]:
    def find(kind: DeviceKind, action: str) -> list[Event]:
        return [e for e in plan.events if scene.cell.devices[e.device].kind is kind and e.action == action]

    return find


def _needed(what: str, events: Sequence[Event], earliest: float, latest: float) -> Iterator[Reason]:
    """Exactly one event whose effect is complete between two times."""
    times = [event.t_anchor for event in events if event.t_anchor is not None]
    if len(times) != 1:
        yield Reason(
            "event missing" if not times else "event twice", what, f"{len(times)} of them, needs one"
        )
    elif not earliest - TIME_TOLERANCE <= times[0] <= latest + TIME_TOLERANCE:
        yield Reason(
            "event at the wrong time", what, f"{times[0]:.3f} s, needs {earliest:.3f}..{latest:.3f} s"
        )


def _tool_state(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Segments say what the cup does; commands must make it so, at rest in the hand."""
    find = _finder(plan, scene)
    moves = sorted(
        (e.t_trigger, e.t_anchor, state)
        for state in scene.cell.robot.tool.states
        for e in find(DeviceKind.TOOL_ACTUATOR, state.name)
        if e.t_trigger is not None and e.t_anchor is not None
    )
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        if segment.tool_state == MOVING:
            if segment.held is not None:
                yield Reason(
                    "tool changes its state while holding", where, "the load on the cup would not be known"
                )
            continue
        yield from _still(segment, moves, where)
    yield from _changes(plan, moves)


def _still(segment: Segment, moves: Sequence[tuple[float, float, ToolState]], where: str) -> Iterator[Reason]:
    """No command moves the cup while a segment counts on its state."""
    for trigger, anchor, state in moves:
        if trigger < segment.t_end - TIME_TOLERANCE and anchor > segment.t_start + TIME_TOLERANCE:
            yield Reason("wrong tool state", where, f"moves to {state} from {trigger:.3f} to {anchor:.3f} s")


def _changes(plan: Plan, moves: Sequence[tuple[float, float, ToolState]]) -> Iterator[Reason]:
    """Every resting state is the one that the last command before it leads to, or the one at the start."""
    resting = [(k, s) for k, s in enumerate(plan.segments) if s.tool_state != MOVING]
    for k, segment in resting:
        done = [m[2] for m in moves if m[1] <= segment.t_start + TIME_TOLERANCE]
        first, at_start = resting[0]
        known = done[-1] if done else (at_start.tool_state if first == 0 else None)
        if known != segment.tool_state:
            said = f"the commands leave it {known}" if known else "no command says to where it moves before"
            yield Reason(
                "wrong tool state", f"segment {k} ({segment.kind})", f"stated {segment.tool_state}, {said}"
            )
