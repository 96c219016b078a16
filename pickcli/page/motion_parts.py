"""Converts plans to data of a page: positions, held items, segments, devices and joint limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import Device, DeviceKind
from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING, ToolState
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, inverse
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Event
from pickcli.motion.limit_shares import limit_shares, limits_of
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.page.cell_parts import tool_positions
from pickcli.page.page_motion import Carried, Lane, PageMotion, Signal, Span, Track
from pickcli.page.page_scene import posed
from pickcli.scene.item_stream import after_travel
from pickcli.scene.scene import Scene

SAMPLE_RATE = 100.0  # Hz of sampling: at 10 rad/s^2 interpolation errors are up to 0.13 mrad
MOST_SAMPLES = 6000  # per motion; longer motions are sampled at a lower rate
TIME_RESOLUTION = 1e-4  # s, resolution of times
POSITION_RESOLUTION = 1e-5  # rad or m, resolution of joint positions
POSE_RESOLUTION = 1e-5  # m, and of components of quaternions
RATIO_RESOLUTION = 1e-3  # resolution of shares of a limit


@dataclass(frozen=True, eq=False)
class Samples:
    """A sampled motion.

    Attributes:
        times: (N,) s, including the ends of segments.
        Q: (N, n) positions of the planned joints.
        tool: (N, k) positions of the tool's joints.
    """

    times: Array
    Q: Array
    tool: Array

    @property
    def positions(self) -> Array:
        """Positions (N, n + k) in rad or m of all moving joints."""
        return np.hstack([self.Q, self.tool])


def samples_of(plan: Plan, robot: Robot) -> Samples:
    """Sample a plan.

    Args:
        plan: The plan.
        robot: The robot.

    Returns:
        The samples.
    """
    duration = plan.trajectory.duration
    n = min(int(np.ceil(duration * SAMPLE_RATE)), MOST_SAMPLES)
    ends = [t for segment in plan.segments for t in (segment.t_start, segment.t_end)]
    times = (
        np.unique(np.round(np.append(np.linspace(0.0, duration, n + 1), ends) / TIME_RESOLUTION))
        * TIME_RESOLUTION
    )
    times = np.clip(times, 0.0, duration)
    return Samples(times, plan.trajectory.sample(times), _tool_motion(plan, robot, times))


def motion_part(samples: Samples, carried: Sequence[Carried], tracks: Sequence[Track] = ()) -> PageMotion:
    """Convert the motion of a plan.

    Args:
        samples: Samples of the plan.
        carried: Items held meanwhile.
        tracks: Items that ride on a conveyor.

    Returns:
        The motion.
    """
    duration = float(samples.times[-1])
    return PageMotion(
        duration,
        packed(samples.times, TIME_RESOLUTION),
        packed(samples.positions, POSITION_RESOLUTION),
        tuple(carried),
        tuple(tracks),
    )


def riding_tracks(plan: Plan, scene: Scene) -> tuple[Track, ...]:
    """Find the poses over time of the items that ride on the conveyor of a plan.

    Args:
        plan: The plan.
        scene: The scene at its start.

    Returns:
        A track of each, over the whole plan; empty for a plan without a running conveyor.
    """
    if plan.tracking is None:
        return ()
    ends = np.array([0.0, plan.trajectory.duration])
    scenes = [_as_the_belt_runs(plan, scene, t) for t in ends.tolist()]
    places = scene.cell.carriers[plan.tracking.conveyor].places
    return tuple(
        Track(
            placed.id, packed(ends, TIME_RESOLUTION),
            packed(np.array([posed(at.find(placed.id).T_world_item) for at in scenes]), POSE_RESOLUTION),
        )
        for placed in scene.items if placed.location in places
    )  # fmt: skip


def _as_the_belt_runs(plan: Plan, scene: Scene, t: float) -> Scene:
    """Return the scene at a time (s) of a plan, if the belt of the plan, if any, runs on."""
    if plan.tracking is None:
        return scene
    return after_travel(scene, plan.tracking.conveyor, plan.tracking.speed * t)


def carried_items(plan: Plan, scene: Scene) -> tuple[Carried, ...]:
    """Find the item held by a plan, with its times and pose.

    Args:
        plan: The plan.
        scene: The scene of the plan.

    Returns:
        The item from the end of the contact until its release; empty for a move with an empty tool.
    """
    held = [segment for segment in plan.segments if segment.held is not None]
    if not held:
        return ()
    item = held[0].held
    assert item is not None
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    if contact is None:
        T_tip_item = None if scene.held is None else scene.held.T_tip_item
    else:
        state = held[0].tool_state if contact.tool_state == MOVING else contact.tool_state
        tip = Arm(scene.cell.robot).tip(plan.trajectory.sample(contact.t_end)[0], state)
        met = _as_the_belt_runs(plan, scene, contact.t_end)
        T_tip_item = inverse(tip) @ met.find(item).T_world_item
    if T_tip_item is None:
        return ()
    return (Carried(item, held[0].t_start, held[-1].t_end, posed(T_tip_item)),)


def segment_lane(segments: Sequence[Segment], name: str = "segments") -> Lane:
    """Convert the segments of a motion to a lane.

    Args:
        segments: The segments.
        name: Heading.

    Returns:
        The lane.
    """
    return Lane(
        name,
        tuple(
            Span(round(s.t_start, 4), round(s.t_end, 4), str(s.kind), str(s.kind), _described(s))
            for s in segments
        ),
    )


def device_lanes(events: Sequence[Event], cell: Cell, duration: float) -> tuple[Lane, ...]:
    """Convert the device events of a plan to lanes.

    Args:
        events: Resolved events, in any order.
        cell: The cell.
        duration: s.

    Returns:
        A lane for each device with an event.
    """
    switched = [
        (e.t_trigger, e.device, e.action, f"commanded at {e.t_trigger:.3f} s, full effect {e.lead:g} s later")
        for e in events
        if e.t_trigger is not None
    ]
    return switched_lanes(switched, cell.devices, duration)


def switched_lanes(
    switched: Sequence[tuple[float, str, str, str]], devices: Mapping[str, Device], duration: float
) -> tuple[Lane, ...]:  # fmt: skip
    """Convert switching times of devices to lanes.

    Args:
        switched: (s, device, action, details) in any order.
        devices: Devices by name.
        duration: s.

    Returns:
        A lane for each device with an event; readings of sensors and states "off" have no colour.
    """
    lanes = []
    for name, device in devices.items():
        own = sorted(each for each in switched if each[1] == name)
        ends = [*(t for t, *_ in own[1:]), duration]
        if not own:
            continue
        if device.kind is DeviceKind.SENSOR:
            spans = [Span(round(t, 4), round(t, 4), action, "mark", detail) for t, _, action, detail in own]
        else:
            spans = [
                Span(round(t, 4), round(end, 4), action, "off" if action == "off" else "on", detail)
                for (t, _, action, detail), end in zip(own, ends, strict=True)
            ]
        lanes.append(Lane(name.replace("_", " "), tuple(spans)))
    return tuple(lanes)


def limit_signals(
    trajectory: Trajectory, cell: Cell, times: Array, t_start: float = 0.0
) -> tuple[Signal, ...]:
    """Convert velocity, acceleration and jerk of every joint to signals, as shares of their limits.

    Between two samples the largest share is used, so that no peak is lost.

    Args:
        trajectory: The trajectory.
        cell: The cell, for its limits.
        times: (N,) s, sample times on the trajectory.
        t_start: Start of the trajectory on the page's clock, s.

    Returns:
        Three signals.
    """
    return tuple(
        limit_signal(derivative, limit_shares(trajectory, cell, times, derivative), cell, times + t_start)
        for derivative in (1, 2, 3)
    )


def limit_signal(derivative: int, shares: Array, cell: Cell, times: Array, arm: str = "") -> Signal:
    """Convert one derivative of the joints' positions to a signal.

    Args:
        derivative: 1 for velocity, 2 for acceleration, 3 for jerk.
        shares: (N, n) shares of the limits.
        cell: The cell, for its limits.
        times: (N,) s on the page's clock.
        arm: Name of the arm, if the page shows several.

    Returns:
        The signal.
    """
    name = f"{arm} {('velocity', 'acceleration', 'jerk')[derivative - 1]}".strip()
    suffix = ("/s", "/s²", "/s³")[derivative - 1]
    return Signal(
        name, "of the limit", packed(times, TIME_RESOLUTION), packed(shares, RATIO_RESOLUTION),
        cell.robot.joint_names,
        tuple(limits_of(cell)[derivative - 1].tolist()), tuple(unit + suffix for unit in cell.robot.units),
        -1.1, 1.1, 1.0,
    )  # fmt: skip


def _tool_motion(plan: Plan, robot: Robot, times: Array) -> Array:
    """Positions (N, k) of the tool's joints, which move from each command until its full effect."""
    known = [(s.t_start, s.t_end, s.tool_state) for s in plan.segments if s.tool_state != MOVING]
    first = known[0][2] if known else robot.tool.default_state
    moving = [s for s in plan.segments if s.tool_state == MOVING]
    state = first if not moving or moving[0].t_start > 0.0 else _state_before(robot, first)
    knots, values = [0.0], [tool_positions(robot, state)]
    for segment in moving:
        after = next((k[2] for k in known if k[0] >= segment.t_end - TIME_RESOLUTION), state)
        began, lead = _switched_in(plan, segment)
        knots += [began, began + lead]
        values += [values[-1], tool_positions(robot, after)]
    table = np.array(values)
    columns = [np.interp(times, knots, column) for column in table.T]
    return np.array(columns).reshape(table.shape[1], len(times)).T


def _state_before(robot: Robot, after: ToolState) -> ToolState:
    """State of the tool before a plan that begins with its motion: with two states the other one."""
    others = [state for state in robot.tool.states if state != after]
    default = robot.tool.default_state
    return default if default != after or not others else others[0]


def _switched_in(plan: Plan, segment: Segment) -> tuple[float, float]:
    """Time of the tool's command in a segment, and its lead."""
    span = segment.t_end - segment.t_start
    for event in plan.events:
        t = event.t_trigger
        is_other = event.action in ("on", "off", "read")
        if t is not None and not is_other and segment.t_start - TIME_RESOLUTION <= t <= segment.t_end:
            return t, event.lead
    return segment.t_start, span


def _described(segment: Segment) -> str:
    parts = [f"{segment.t_end - segment.t_start:.2f} s, tool {segment.tool_state}"]
    parts += [f"holds {segment.held}"] if segment.held else []
    parts += [f"may touch {', '.join(segment.touching)}"] if segment.touching else []
    parts += [f"may push {', '.join(segment.pushing)}"] if segment.pushing else []
    return "; ".join(parts)
