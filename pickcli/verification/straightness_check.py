"""Check straight segments: lines, slow contact along the cup's axis, and touching that ends early."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array, rotation_angle, rotation_vector
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import positions_at
from pickcli.verification.state_sampling import States

STRAIGHT = (
    SegmentKind.PREAPPROACH,
    SegmentKind.APPROACH,
    SegmentKind.CONTACT,
    SegmentKind.LIFT,
    SegmentKind.RETREAT,
    SegmentKind.INSERT,
    SegmentKind.PLACE,
    SegmentKind.PUSH,
    SegmentKind.DEPART,
)
OFF_LINE = 0.002  # m
OFF_ANGLE = np.radians(1.0)
FIRST_LIFT = 0.055  # m, first of the lift or last of the place, in which the item may touch others
CONTACT_WAY = 0.025  # m: distance at which the cup may meet an uncertain item, plus the stroke of its bellows
TOUCHED_WAY = {
    SegmentKind.CONTACT: CONTACT_WAY,
    SegmentKind.LIFT: FIRST_LIFT,
    SegmentKind.PLACE: FIRST_LIFT,
    SegmentKind.DEPART: FIRST_LIFT,
}
SPEED_TOLERANCE = 1e-3  # of the contact speed


def check_lines(plan: Plan, robot: Robot, states: States) -> tuple[Reason, ...]:
    """Check the tool's path in single segments: straightness, contact and touching.

    Args:
        plan: The plan.
        robot: The robot.
        states: The motion's states.

    Returns:
        The faults.
    """
    reasons: list[Reason] = []
    touched = dict.fromkeys(TOUCHED_WAY, 0.0)
    for k, segment in enumerate(plan.segments):
        first, last = states.between(segment.t_start, segment.t_end)
        tips = tip_poses(robot, states.links[:, first : last + 1], segment.tool_state)
        where = f"segment {k} ({segment.kind})"
        if segment.kind in STRAIGHT:
            reasons += _straight(tips, where)
        if segment.kind is (SegmentKind.APPROACH if robot.tool.grip.takes_widths else SegmentKind.CONTACT):
            reasons += _contact(plan, robot, segment, tips, where)
        if segment.kind in touched and segment.touching:
            touched[segment.kind] += float(np.linalg.norm(np.diff(tips[:, :3, 3], axis=0), axis=1).sum())
    return (*reasons, *_touched_too_long(touched))


def _straight(tips: Array, where: str) -> Iterator[Reason]:
    """Check that every pose (N, 4, 4) is near the line from the first to the last."""
    along = tips[-1, :3, 3] - tips[0, :3, 3]
    squared = float(along @ along)
    off = tips[:, :3, 3] - tips[0, :3, 3]
    turning = np.linspace(0.0, 1.0, len(tips))  # evenly, if the line has no length
    s = np.clip(off @ along / squared, 0.0, 1.0) if squared > 1e-12 else turning
    distance = float(np.linalg.norm(off - s[:, None] * along, axis=1).max())
    if distance > OFF_LINE:
        yield Reason("not straight", where, f"{distance * 1e3:.2f} mm off the line")
    angle = _largest_angle(tips, s)
    if angle > OFF_ANGLE:
        yield Reason("not straight", where, f"turned {np.degrees(angle):.2f} deg away from the line")


def _largest_angle(tips: Array, s: Array) -> float:
    """Return the largest angle in rad between a pose and the line's pose at the same place."""
    turn = rotation_vector(tips[0, :3, :3].T @ tips[-1, :3, :3])
    line = tips[0, :3, :3] @ Rotation.from_rotvec(np.outer(s, turn)).as_matrix()
    worst = int(np.argmin(np.einsum("nij,nij->n", line, tips[:, :3, :3])))  # trace: least at largest angle
    return rotation_angle(line[worst].T @ tips[worst, :3, :3])


def _contact(plan: Plan, robot: Robot, segment: Segment, tips: Array, where: str) -> Iterator[Reason]:
    """Check that the tool moves outwards along its own axis, within the contact speed of the tool."""
    way = tips[-1, :3, 3] - tips[0, :3, 3]
    axis = tips[-1, :3, 2]
    aside = float(np.linalg.norm(way - (way @ axis) * axis))
    if way @ axis <= 0.0 or aside > OFF_LINE:
        yield Reason("not along the tool axis", where, f"{aside * 1e3:.2f} mm aside")
    speed = fastest_tip(plan, robot, segment.tool_state, segment.t_start, segment.t_end)
    limit = robot.tool.contact_speed
    if speed > limit * (1.0 + SPEED_TOLERANCE):
        yield Reason("contact speed", where, f"{speed:.4f} m/s, the tool takes {limit}")


def fastest_tip(plan: Plan, robot: Robot, tool_state: ToolState, t_start: float, t_end: float) -> float:
    """Return the greatest speed of the tip over every millisecond between two times, for one tool state.

    Args:
        plan: The plan.
        robot: The robot.
        tool_state: State of the tool.
        t_start: s.
        t_end: s.

    Returns:
        m/s.
    """
    times = every_millisecond(t_start, t_end)
    p = tip_points(plan, robot, tool_state, times)
    # The chord over a millisecond gives the mean speed in it.
    return float((np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(times)).max())


def tip_points(plan: Plan, robot: Robot, tool_state: ToolState, times: Array) -> Array:
    """Return the positions of the tip, for one tool state.

    Args:
        plan: The plan.
        robot: The robot.
        tool_state: State of the tool.
        times: (N,) s.

    Returns:
        (N, 3) m in the world.
    """
    return tip_poses(robot, link_poses(robot, positions_at(plan.trajectory, times)), tool_state)[:, :3, 3]


def every_millisecond(t_start: float, t_end: float) -> Array:
    """Return times from one to another, both included, at most a millisecond apart.

    Args:
        t_start: s.
        t_end: s.

    Returns:
        (N,) s, evenly spaced, at least two.
    """
    return np.linspace(t_start, t_end, max(2, int(np.ceil((t_end - t_start) * 1e3)) + 1))


def _touched_too_long(touched: Mapping[SegmentKind, float]) -> Iterator[Reason]:
    """Check that contact is planned over no more than the allowed path length, per kind of segment."""
    for kind, way in touched.items():
        if way > (most := TOUCHED_WAY[kind]):
            detail = f"{way * 1e3:.1f} mm of way name what may be touched; at most {most * 1e3:.0f} mm may"
            yield Reason("touching too long", str(kind), detail)
