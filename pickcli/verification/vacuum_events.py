"""Check events of a cup: vacuum before the contact ends, a sensor read, release of the vacuum."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import positions_at
from pickcli.verification.straightness_check import every_millisecond, fastest_tip, tip_points

EVENT_TIME_TOLERANCE = 1e-6  # s
OPENS_WITHIN = 0.005  # m before the press: farther away, vacuum leaks and light items are dragged
CLOSES_WITHIN = 0.010  # m before the place of release
# m/s of the tool from the release command on: an item that leaves the cup at this speed, from the highest
# that is allowed, lands 25 mm aside. From when the valve is closed on the tool stands.
RELEASE_SPEED, STANDING = 0.1, 0.002
# rad or m by which a resting joint may move: rounding of a motion written as text
JOINT_REST_TOLERANCE = 1e-6
LAST_MOMENT = 1e-3  # s before the release in which the tool's speed counts, even if the valve closes later


@dataclass(frozen=True)
class TimedEvent:
    """An event with known times.

    Attributes:
        device: Name of the device.
        kind: Kind of the device.
        action: Its action.
        trigger: s, when the command is given.
        complete: s, when its effect is complete.
    """

    device: str
    kind: DeviceKind
    action: str
    trigger: float
    complete: float


def check_vacuum_events(plan: Plan, scene: Scene, commands: Sequence[TimedEvent]) -> Iterator[Reason]:
    """Check for vacuum when the cup is pressed on, a sensor read while holding, and release of the vacuum.

    Args:
        plan: The plan, its events resolved.
        scene: The plan's scene, of a cell with a cup or a bare flange.
        commands: All commands of the plan.

    Yields:
        The faults.
    """
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    held = [s for s in plan.segments if s.held is not None]
    find = _finder(commands)
    if contact is not None:
        lift_end = next((s.t_start for s in held if s.kind is not SegmentKind.LIFT), held[-1].t_end)
        sealing = contact.t_end - scene.cell.robot.tool.cup.seal_time
        if plan.tracking is None:
            yield from _rests(plan, sealing, contact.t_end)
        else:
            yield from _rides(plan, scene, contact, sealing)
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
    """Check that no joint moves while the vacuum builds up under the cup."""
    q = positions_at(plan.trajectory, every_millisecond(max(0.0, t_start), t_end))
    moved = float(np.ptp(q, axis=0).max())
    if t_start < 0.0 or moved > JOINT_REST_TOLERANCE:
        needed = f"the tool is to rest on the item from {t_start:.3f} to {t_end:.3f} s"
        yield Reason("no time to seal", "contact", f"{needed}; a joint moves by {moved:.6f} rad or m")


def _rides(plan: Plan, scene: Scene, contact: Segment, t_start: float) -> Iterator[Reason]:
    """Check that the tool does not move on a running belt, as seen from there, until the contact ends."""
    robot, times = scene.cell.robot, every_millisecond(max(0.0, t_start), contact.t_end)
    tips = tip_poses(robot, link_poses(robot, positions_at(plan.trajectory, times)), contact.tool_state)
    moved = float(np.ptp(tips, axis=0).max())
    if t_start < 0.0 or moved > JOINT_REST_TOLERANCE:
        needed = f"the tool is to rest on the item from {t_start:.3f} to {contact.t_end:.3f} s"
        yield Reason("no time to seal", "contact", f"{needed}; on the belt it moves by {moved:.6f} rad or m")


def _release(
    plan: Plan,
    scene: Scene,
    first: Segment,
    last: Segment,
    find: Callable[[DeviceKind, str], list[TimedEvent]],
) -> Iterator[Reason]:
    """Check that the valve closes at the release, the pump stops, and no command ends the vacuum before."""
    valves, pumps = find(DeviceKind.VALVE, "off"), find(DeviceKind.PUMP, "off")
    yield from _needed("valve off", valves, last.t_start, last.t_end)
    if not valves:
        yield from _needed("pump off", pumps, last.t_end)
    for valve in valves:
        yield from _near(plan, scene, last, valve.trigger, CLOSES_WITHIN, "valve off")
        yield from _slow(plan, scene, last, valve)
        yield from _needed("pump off", pumps, valve.trigger)
        yield from _kept(pumps + valves, first.t_start, valve.trigger - EVENT_TIME_TOLERANCE)


def _slow(plan: Plan, scene: Scene, last: Segment, valve: TimedEvent) -> Iterator[Reason]:
    """Check that the tool is nearly at rest at the release: the item is set down or dropped, not thrown."""
    for at, most in ((valve.trigger, RELEASE_SPEED), (valve.complete, STANDING)):
        t = max(last.t_start, min(at, last.t_end - LAST_MOMENT))
        speed = fastest_tip(plan, scene.cell.robot, last.tool_state, t, last.t_end)
        if speed > most:
            detail = f"the tool moves at {speed:.3f} m/s from {t:.3f} s on, at most {most} m/s"
            yield Reason("released too fast", "valve off", detail)
            return


def _is_on(on: Iterable[TimedEvent], off: Iterable[TimedEvent], t: float) -> Iterator[Reason]:
    """Check that the last device switched on before a time is not switched off again until then."""
    since = max((command.trigger for command in on if command.trigger <= t), default=np.inf)
    for command in off:
        if since <= command.trigger <= t:
            at = f"at {command.trigger:.3f} s, before the contact is made"
            yield Reason("vacuum lost", f"{command.device} off", at)


def _kept(off: Iterable[TimedEvent], t_start: float, t_end: float) -> Iterator[Reason]:
    """Check that nothing is switched off between two times."""
    for command in off:
        if t_start - EVENT_TIME_TOLERANCE <= command.trigger < t_end:
            where = f"{command.device} off"
            yield Reason("vacuum lost", where, f"at {command.trigger:.3f} s the item is still held")


def _near(plan: Plan, scene: Scene, segment: Segment, t: float, most: float, what: str) -> Iterator[Reason]:
    """Check that at a time the tool is at most a distance in m from its position at the segment's end."""
    times = np.array([t, segment.t_end])
    at, end = tip_points(plan, scene.cell.robot, segment.tool_state, times)
    away = float(np.linalg.norm(at - end))
    if away > most:
        where = f"the tool is {away * 1e3:.0f} mm away, at most {most * 1e3:.0f}"
        yield Reason("event at the wrong place", what, where)


def _finder(commands: Iterable[TimedEvent]) -> Callable[[DeviceKind, str], list[TimedEvent]]:
    def find(kind: DeviceKind, action: str) -> list[TimedEvent]:
        return [command for command in commands if command.kind is kind and command.action == action]

    return find


def _needed(
    what: str, commands: Sequence[TimedEvent], earliest: float = 0.0, latest: float = np.inf
) -> Iterator[Reason]:
    """Check for exactly one command, with its effect complete between two times."""
    if len(commands) != 1:
        found = f"{len(commands)} of them, needs one"
        yield Reason("event twice" if commands else "event missing", what, found)
    for command in commands:
        if not earliest - EVENT_TIME_TOLERANCE <= command.complete <= latest + EVENT_TIME_TOLERANCE:
            needs = f"{command.complete:.3f} s, needs {earliest:.3f}..{latest:.3f} s"
            yield Reason("event at the wrong time", what, needs)
