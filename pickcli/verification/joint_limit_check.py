"""Check joint limits at every instant of the trajectory's curve, not only at its points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene
from pickcli.verification.quintic import control_points, largest, motion
from pickcli.verification.state_sampling import merged

LIMIT_TOLERANCE = 1e-6  # of a ratio, and rad or m of a position: allowance for rounding only
REST_TOLERANCE = 1e-9  # rad/s or m/s, and rad/s^2 or m/s^2


@dataclass(frozen=True)
class Ratios:
    """Largest value over limit, over all times and joints.

    Attributes:
        velocity: Ratio for the velocity limits.
        acceleration: Ratio for the acceleration limits.
        jerk: Ratio for the jerk limits.
        reasons: Faults.
    """

    velocity: float
    acceleration: float
    jerk: float
    reasons: tuple[Reason, ...]


def check_limits(plan: Plan, scene: Scene) -> Ratios:
    """Check position, velocity, acceleration and jerk limits, rest at both ends, and carrying speeds.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        The largest ratios, and the faults.
    """
    cell = scene.cell
    limits = cell.robot.limits
    most = (limits.velocity * cell.speed_scale, limits.acceleration * cell.speed_scale, limits.jerk)
    reasons: list[Reason] = []
    worst = []
    for derivative, (name, limit) in enumerate(
        zip(("velocity", "acceleration", "jerk"), most, strict=True), 1
    ):
        ratios = _ratios(plan.trajectory, derivative, limit)
        worst.append(float(ratios.max()))
        reasons += _over(plan, name, ratios)
    reasons += _position(plan, cell)
    reasons += _rest(plan)
    reasons += _carrying(plan, scene)
    return Ratios(worst[0], worst[1], worst[2], tuple(reasons))


def _ratios(trajectory: Trajectory, derivative: int, limit: Array) -> Array:
    """Return an upper bound of the largest |derivative| over limit (n,)."""
    points = control_points(trajectory, derivative)
    return np.maximum(largest(points), largest(-points)) / limit


def _over(plan: Plan, name: str, ratios: Array, where: str = "", limit: float = 1.0) -> Iterator[Reason]:
    for joint, ratio in zip(plan.trajectory.joint_names, ratios, strict=True):
        if not ratio <= limit * (1.0 + LIMIT_TOLERANCE):
            yield Reason(f"{name} limit", where, f"{joint}: {ratio / limit:.4f} times the limit")


def _position(plan: Plan, cell: Cell) -> Iterator[Reason]:
    points = control_points(plan.trajectory, 0)
    high, low = largest(points), -largest(-points)
    limits = cell.robot.limits
    for j, joint in enumerate(plan.trajectory.joint_names):
        beyond = max(high[j] - limits.upper[j], limits.lower[j] - low[j])
        if not beyond <= LIMIT_TOLERANCE:
            yield Reason(
                "joint limit", "", f"{joint}: {beyond:.6f} beyond {limits.lower[j]}..{limits.upper[j]}"
            )


def _rest(plan: Plan) -> Iterator[Reason]:
    trajectory = plan.trajectory
    for end, name in ((0, "start"), (-1, "end")):
        for values in (trajectory.velocities[end], trajectory.accelerations[end]):
            if not np.abs(values).max() <= REST_TOLERANCE:
                yield Reason("not at rest", name, f"up to {np.abs(values).max():.3g} rad/s or rad/s^2")
                break


def _carrying(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check that segments with an item keep to the share of the velocity limits that item and plan state."""
    limits = scene.cell.robot.limits
    for k, segment in enumerate(plan.segments):
        if segment.held is None:
            continue
        scale = min(scene.item(segment.held).speed_scale, plan.speed_scale) * scene.cell.speed_scale
        if scale < 1.0:
            ratios = _ratios(_cut(plan.trajectory, segment.t_start, segment.t_end), 1, limits.velocity)
            yield from _over(plan, "carrying speed", ratios, f"segment {k} ({segment.kind})", scale)


def _cut(trajectory: Trajectory, t_start: float, t_end: float) -> Trajectory:
    """Return the part of a trajectory between two times, as the same curve."""
    times = merged(np.clip(trajectory.times, t_start, t_end))
    return Trajectory(trajectory.joint_names, times, *motion(trajectory, times))
