"""From a straight line of the tool to a proven joint path.

KTH, section IV-A.2: inside the shelf only Cartesian straight lines, "a well predictable behavior".
Unlike a Cartesian planner that returns a fraction, a line here is whole or comes with its reason.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cartesian.line import line
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm

POSITION_TOLERANCE = 5e-4  # m, largest distance of the tool from its line between two kept waypoints
ANGLE_TOLERANCE = 3e-3  # rad


def follow_line(
    arm: Arm, checker: SceneChecker, T_a: Array, T_b: Array, tool_state: ToolState, q_a: Array, where: str
) -> Array | Reason:
    """Follow a straight line of the tool, proven free.

    Args:
        arm: Kinematics of the arm.
        checker: What proves the line.
        T_a: (4, 4) tool in the world where the line begins.
        T_b: (4, 4) tool in the world where it ends.
        tool_state: State of the tool.
        q_a: (n,) configuration of the arm at ``T_a``.
        where: The line, as reasons call it.

    Returns:
        Waypoints (N, n), N >= 2, of a joint polyline that holds the tool within 0.5 mm and 0.17 degrees of
        the line; or why there is none.
    """
    poses = line(T_a, T_b)
    result = arm.follow(poses[1:], tool_state, q_a)
    if not result.is_complete:
        assert result.reason is not None
        return result.reason.at(where)
    dense = np.vstack([q_a[None], result.configurations])
    kept = dense[_essential(arm, tool_state, dense, poses)]
    blocked = _blocked(checker, kept)
    return kept if blocked is None else blocked.at(where)


def _blocked(checker: SceneChecker, waypoints: Array) -> Reason | None:
    """Why a polyline is not proven free. The waypoints come first: cheap to test, and cheap to explain."""
    is_free = checker.are_valid(waypoints)
    if not is_free.all():
        i = int(np.argmin(is_free))
        reason = checker.explain(waypoints[i])
        return replace(reason, detail=f"{reason.detail} at waypoint {i + 1} of {len(waypoints)}")
    i = checker.first_invalid_edge(waypoints)
    return None if i < 0 else checker.explain_edge(waypoints[i], waypoints[i + 1])


def _essential(arm: Arm, tool_state: ToolState, dense: Array, poses: Array) -> list[int]:
    """Indices of the waypoints that are enough: greedy longest chords within the tolerances."""
    kept, i, last = [0], 0, len(dense) - 1
    while i < last:
        j = last
        while j > i + 1 and not _chord_is_straight(arm, tool_state, dense, poses, i, j):
            j = i + max(1, (j - i) // 2)
        kept.append(j)
        i = j
    return kept


def _chord_is_straight(arm: Arm, tool_state: ToolState, dense: Array, poses: Array, i: int, j: int) -> bool:
    """Whether the joint chord from waypoint i to j keeps the tool on the line."""
    s = np.arange(1, j - i)[:, None] / (j - i)
    tips = arm.tips(dense[i] + (dense[j] - dense[i]) * s, tool_state)
    # Only the distance from the line counts, not the progress along it.
    off, along = tips[:, :3, 3] - poses[i, :3, 3], poses[j, :3, 3] - poses[i, :3, 3]
    length = float(np.sqrt(along @ along))
    if length > 1e-9:
        off -= (off @ (along / length))[:, None] * (along / length)
    if np.einsum("kx,kx->k", off, off).max() > POSITION_TOLERANCE**2:
        return False
    # trace(R_a^T R_b) = 1 + 2 cos(angle), here against the pose at the same place
    traces = np.einsum("kij,kij->k", tips[:, :3, :3], poses[i + 1 : j, :3, :3])
    return bool(traces.min() >= 1.0 + 2.0 * np.cos(ANGLE_TOLERANCE))
