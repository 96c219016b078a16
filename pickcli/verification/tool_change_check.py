"""Changes of the tool's state with the item: the arm rests while the actuator of the cup moves it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.verification.forward_kinematics import (
    T_parent_child,
    joint_position,
    lance_index,
    last_joint_index,
    link_poses,
    stated_position,
)
from pickcli.verification.quintic import motion, positions_at
from pickcli.verification.straightness_check import every_millisecond
from pickcli.verification.vacuum_events import EVENT_TIME_TOLERANCE, JOINT_REST_TOLERANCE, TimedEvent


def check_tool_changes(plan: Plan, robot: Robot, moves: Sequence[TimedEvent]) -> Iterator[Reason]:
    """Check every segment in which the tool may be in any state while it holds the item.

    The load on the cup is only known if the arm rests and the cup does all of its way within the segment.

    Args:
        plan: The plan.
        robot: The robot.
        moves: Commands that move the tool.

    Yields:
        The faults.
    """
    for k, segment in enumerate(plan.segments):
        if segment.held is None or segment.tool_state != MOVING:
            continue
        where = f"segment {k} ({segment.kind})"
        if robot.tool.joint is None or not _is_between_holds(plan.segments, k):
            detail = "the load on the cup is known only between two segments that hold the item"
            yield Reason("tool changes its state while holding", where, detail)
            continue
        q = positions_at(plan.trajectory, every_millisecond(segment.t_start, segment.t_end))
        moved = float(np.ptp(q, axis=0).max())
        if moved > JOINT_REST_TOLERANCE:
            detail = f"a joint moves by {moved:.6f} rad or m; the arm is to rest"
            yield Reason("tool changes its state while holding", where, detail)
        if not any(_spans(move, segment) for move in moves):
            detail = "no command of the tool begins and ends with it"
            yield Reason("tool changes its state while holding", where, detail)


def _is_between_holds(segments: Sequence[Segment], k: int) -> bool:
    """Whether the segments before and after a segment hold its item, in one state of the tool each."""
    if not 0 < k < len(segments) - 1:
        return False
    beside = segments[k - 1], segments[k + 1]
    return all(s.held == segments[k].held and s.tool_state != MOVING for s in beside)


def _spans(move: TimedEvent, segment: Segment) -> bool:
    off = max(abs(move.trigger - segment.t_start), abs(move.complete - segment.t_end))
    return off <= EVENT_TIME_TOLERANCE


def held_tip_poses(plan: Plan, robot: Robot, times: Array) -> Array:
    """Compute poses of the tool frame while the item is held, also while the tool changes its state.

    Between two states the joint of the cup follows the quintic from rest to rest over the whole segment.
    Plans in which it would move otherwise are refused by ``check_tool_changes``.

    Args:
        plan: A plan that holds an item.
        robot: The robot.
        times: (N,) s, increasing.

    Returns:
        (N, 4, 4) in the world.
    """
    held = [segment for segment in plan.segments if segment.held is not None]
    cup = last_joint_index(robot)
    lance = link_poses(robot, motion(plan.trajectory, times)[0])[lance_index(robot)]
    out: Array = np.empty_like(lance)
    for k, segment in enumerate(held):
        since = -np.inf if k == 0 else segment.t_start
        until = np.inf if k == len(held) - 1 else segment.t_end
        here = np.flatnonzero((times >= since) & (times <= until))
        if segment.tool_state != MOVING or k in (0, len(held) - 1):
            stated = np.full(len(here), stated_position(robot, segment.tool_state))
        else:
            a, b = (stated_position(robot, s.tool_state) for s in (held[k - 1], held[k + 1]))
            share = (times[here] - segment.t_start) / (segment.t_end - segment.t_start)
            stated = a + (b - a) * np.polyval((6.0, -15.0, 10.0, 0.0, 0.0, 0.0), share)
        positions, index = np.unique(stated, return_inverse=True)
        turned = [T_parent_child(robot, cup, joint_position(robot, cup, p)) for p in positions.tolist()]
        out[here] = lance[here] @ np.array(turned).reshape(-1, 4, 4)[index] @ robot.tool.T_last_tip
    return out
