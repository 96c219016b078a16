"""Whether start and goals of a query are usable, and if not, why."""

from __future__ import annotations

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace


def free_goals(
    checker: MotionValidator, space: JointSpace, q_start: Array, goals: Array, label: str
) -> list[int]:
    """Tell which goals are within the joint limits and free.

    Args:
        checker: Proves configurations free in the scene.
        space: The joints and their limits.
        q_start: (n,) start.
        goals: (G, n) goals.
        label: What is planned, for the message.

    Returns:
        Indices of the usable goals, at least one.

    Raises:
        NoPlanError: The start or all goals are not usable; with every reason.
    """
    reason = _why_not(checker, space, q_start, "start")
    if reason is not None:
        raise NoPlanError(label, [reason])
    reasons = [_why_not(checker, space, goal, f"goal {g}") for g, goal in enumerate(goals)]
    free = [g for g, reason in enumerate(reasons) if reason is None]
    if not free:
        raise NoPlanError(label, [reason for reason in reasons if reason is not None])
    return free


def _why_not(checker: MotionValidator, space: JointSpace, q: Array, where: str) -> Reason | None:
    """What makes a configuration unusable, or None."""
    if not space.holds(q):
        return Reason("joint limit", where, _outside(space, q))
    if not checker.is_valid(q):
        return checker.explain(q).at(where)
    return None


def _outside(space: JointSpace, q: Array) -> str:
    """Which joint breaks its limit by how much."""
    if np.shape(q) != (space.n,) or not np.all(np.isfinite(q)):
        return f"expected {space.n} finite numbers"
    excess = np.maximum(space.lower - q, q - space.upper)
    j = int(np.argmax(excess))
    return f"{space.joint_names[j]} at {q[j]:.4f} is {excess[j]:.2g} outside of its limits"
