"""Exact check of a trajectory against its limits, at every instant and not only at its points.

Every piece is a quintic, so its acceleration is a cubic and its jerk a quadratic whose largest values are
known in closed form; the velocity, a quartic, is bounded by its Bernstein coefficients.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.errors import LimitError
from pickcli.geometry import Array
from pickcli.kernel import quintic_peaks
from pickcli.motion.trajectory import Trajectory

LIMIT_TOLERANCE = 1e-6  # relative, for rounding only
# rad or m: measured starts are rounded, and curves may exceed limits between two checked nodes
POSITION_TOLERANCE = 1e-6


@dataclass(frozen=True)
class PeakRatio:
    """Place where the ratio to a limit is largest.

    Attributes:
        ratio: Value over limit.
        joint: Name of the joint.
        time: s, start of the piece.
    """

    ratio: float
    joint: str
    time: float

    def __str__(self) -> str:
        return f"{self.joint} at {self.ratio:.3f} of its limit at {self.time:.3f} s"


@dataclass(frozen=True)
class LimitReport:
    """Largest ratios of a trajectory to its limits; 1 is exactly at the limit.

    Attributes:
        velocity: Largest ratio to a velocity limit.
        acceleration: Largest ratio to an acceleration limit.
        jerk: Largest ratio to a jerk limit.
    """

    velocity: PeakRatio
    acceleration: PeakRatio
    jerk: PeakRatio

    @property
    def time_scale(self) -> float:
        """Factor of time that brings every ratio to 1 or below; below 1 the motion could be faster."""
        return float(max(self.velocity.ratio, self.acceleration.ratio**0.5, self.jerk.ratio ** (1 / 3)))


def peaks(trajectory: Trajectory) -> tuple[Array, Array, Array]:
    """Compute the largest velocity, acceleration and jerk of every joint on every piece.

    Args:
        trajectory: N points with quintics in between.

    Returns:
        |velocity| (an upper bound), |acceleration| and |jerk| (both exact), each (N - 1, n).
    """
    at = trajectory
    return quintic_peaks(at.times, at.positions, at.velocities, at.accelerations)


def measure_limits(trajectory: Trajectory, limits: Limits, scale: Array | float = 1.0) -> LimitReport:
    """Compute the largest ratios of velocity, acceleration and jerk to their limits.

    Args:
        trajectory: N points with quintics in between.
        limits: Limits of the joints.
        scale: Factor on all limits: one number, or one for each piece (N - 1,).

    Returns:
        The ratios with their joints and times.
    """
    share = np.broadcast_to(np.asarray(scale, dtype=float), (len(trajectory.times) - 1,))[:, None]
    bounds = (limits.velocity, limits.acceleration, limits.jerk)
    ratios = [peak / (share * bound) for peak, bound in zip(peaks(trajectory), bounds, strict=True)]
    return LimitReport(*(_worst(trajectory, ratio) for ratio in ratios))


def check_limits(trajectory: Trajectory, limits: Limits, scale: Array | float = 1.0) -> LimitReport:
    """Check a trajectory strictly against its limits.

    Args:
        trajectory: N points with quintics in between.
        limits: Limits of the joints.
        scale: Factor on velocity, acceleration and jerk limits: one number, or one for each piece (N - 1,).

    Returns:
        The largest ratios.

    Raises:
        LimitError: If a ratio is over 1 (the message names quantity, joint and time), a value is not finite,
            times do not increase strictly from 0, a point is outside of the position limits, or the
            trajectory does not start and end at rest.
    """
    rows = (trajectory.times, trajectory.positions, trajectory.velocities, trajectory.accelerations)
    if not all(np.isfinite(row).all() for row in rows):
        raise LimitError("trajectory has values that are not finite: rebuild the trajectory")
    if trajectory.times[0] != 0.0 or np.any(np.diff(trajectory.times) <= 0.0):
        raise LimitError("trajectory times must increase strictly from 0: rebuild the trajectory")
    ends = trajectory.velocities[[0, -1]]
    if np.any(ends != 0.0):
        raise LimitError(
            f"trajectory must start and end at rest, but moves by up to {np.abs(ends).max():.3g} per s"
        )
    _check_positions(trajectory, limits)
    report = measure_limits(trajectory, limits, scale)
    for name, worst in (
        ("velocity", report.velocity),
        ("acceleration", report.acceleration),
        ("jerk", report.jerk),
    ):
        if not worst.ratio <= 1.0 + LIMIT_TOLERANCE:
            raise LimitError(
                f"{name} of joint {worst.joint} is {worst.ratio:.6f} of its limit at {worst.time:.3f} s of "
                f"{trajectory.duration:.3f} s: time the path again with time_run"
            )
    return report


def _check_positions(trajectory: Trajectory, limits: Limits) -> None:
    q = trajectory.positions
    beyond = np.maximum(limits.lower - q, q - limits.upper)
    i, j = np.unravel_index(int(np.argmax(beyond)), beyond.shape)
    if not beyond[i, j] <= POSITION_TOLERANCE:
        raise LimitError(
            f"joint {trajectory.joint_names[j]} is {beyond[i, j]:.3g} outside its position limits "
            f"{limits.lower[j]:.4f}..{limits.upper[j]:.4f} at {trajectory.times[i]:.3f} s"
        )


def _worst(trajectory: Trajectory, ratio: Array) -> PeakRatio:
    i, j = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    return PeakRatio(float(ratio[i, j]), trajectory.joint_names[j], float(trajectory.times[i]))
