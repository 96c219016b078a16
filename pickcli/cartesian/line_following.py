"""Conversion of a straight line of the tool to a proven joint path.

KTH, section IV-A.2: inside the shelf only Cartesian straight lines, "a well predictable behavior". Unlike a
Cartesian planner that returns a fraction, the result here is a complete line or a reason.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cartesian.line import line
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.follow import Deviation

BETWEEN_WAYPOINTS = Deviation(position=5e-4, angle=3e-3)  # of the tool from its line


def follow_line(
    arm: Arm, checker: SceneChecker, T_a: Array, T_b: Array, tool_state: ToolState, q_a: Array, where: str
) -> Array | Failures:
    """Follow a straight line of the tool, and prove it free.

    Args:
        arm: Kinematics of the arm.
        checker: Checker that proves the line.
        T_a: (4, 4) pose of the tool in the world at the start.
        T_b: (4, 4) pose of the tool in the world at the end.
        tool_state: State of the tool.
        q_a: (n,) configuration of the arm at ``T_a``.
        where: Name of the line in reasons.

    Returns:
        Waypoints (N, n), N >= 2, of a joint polyline that keeps the tool within 0.5 mm and 0.17 degrees of
        the line; or the reasons for failure.
    """
    poses = line(T_a, T_b)
    result = arm.follow(poses[1:], tool_state, q_a)
    if result.reason is not None:
        return Failures.of(result.reason.at(where))
    dense = np.vstack([q_a[None], result.configurations])
    kept = dense[arm.longest_chords(dense, poses, tool_state, BETWEEN_WAYPOINTS)]
    # Waypoints are checked first, because they are cheap to check and to explain.
    is_free = checker.are_valid(kept)
    if not is_free.all():
        blocked = int(np.argmin(is_free))
        return Failures((lambda: [_at_waypoint(checker, kept, blocked).at(where)],))
    edge = checker.first_blocked_edge(kept)
    if edge >= 0:
        return Failures((lambda: [checker.explain_path(kept[edge : edge + 2]).at(where)],))
    return kept


def _at_waypoint(checker: SceneChecker, waypoints: Array, i: int) -> Reason:
    """Explain why one of the waypoints (N, n) is not valid."""
    reason = checker.explain(waypoints[i])
    return replace(reason, detail=f"{reason.detail} at waypoint {i + 1} of {len(waypoints)}")
