"""Trajectories: points with position, velocity and acceleration, and a quintic in between."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array

SAME_TIME = 1e-9  # s

# Coefficients of the quintic Hermite basis on [0, 1], by powers of u; rows: p0, v0, a0, p1, v1, a1.
_BASIS = np.array(
    [
        [1, 0, 0, -10, 15, -6],
        [0, 1, 0, -6, 8, -3],
        [0, 0, 0.5, -1.5, 1.5, -0.5],
        [0, 0, 0, 10, -15, 6],
        [0, 0, 0, -4, 7, -3],
        [0, 0, 0, 0.5, -1, 0.5],
    ]
)


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Points as in trajectory_msgs/JointTrajectory, and the curve between them.

    The curve between two points is the quintic that meets position, velocity and acceleration at both ends,
    as ros2_controllers interpolates. The trajectory *is* that curve: limits and clearance hold for it, not
    only for the points.

    Attributes:
        joint_names: Names of the n joints.
        times: (N,) s, strictly increasing from 0.
        positions: (N, n) rad or m.
        velocities: (N, n), zero at both ends.
        accelerations: (N, n).
    """

    joint_names: tuple[str, ...]
    times: Array
    positions: Array
    velocities: Array
    accelerations: Array

    @property
    def duration(self) -> float:
        """Time of the last point, s."""
        return float(self.times[-1])

    def sample(self, t: Array | float, derivative: int = 0) -> Array:
        """Return positions or one of their time derivatives.

        Args:
            t: (M,) s; times outside of the trajectory are clamped to its ends.
            derivative: 0 for positions, 1 to 3 for a derivative.

        Returns:
            (M, n).
        """
        return self._sampled(t, (derivative,))[0]

    def states(self, t: Array | float) -> tuple[Array, Array, Array]:
        """Return positions, velocities and accelerations.

        Args:
            t: (M,) s; times outside of the trajectory are clamped to its ends.

        Returns:
            (M, n) each.
        """
        positions, velocities, accelerations = self._sampled(t, (0, 1, 2))
        return positions, velocities, accelerations

    def between(self, t_start: float, t_end: float, tolerance: float = SAME_TIME) -> Trajectory:
        """Return the part between two of the points.

        Args:
            t_start: s, the time of a point.
            t_end: s, the time of another.
            tolerance: s by which the stated times may be off those of the points.

        Returns:
            These points and all in between, from 0 s on.
        """
        t = self.times
        kept = (t >= t_start - tolerance) & (t <= t_end + tolerance)
        rows = (self.positions, self.velocities, self.accelerations)
        return Trajectory(self.joint_names, t[kept] - t[kept][0], *(row[kept] for row in rows))

    def _sampled(self, t: Array | float, derivatives: tuple[int, ...]) -> list[Array]:
        """Return some of the time derivatives (M, n) at times (M,)."""
        t = np.atleast_1d(np.clip(t, 0.0, self.duration))
        i = np.clip(np.searchsorted(self.times, t, side="right") - 1, 0, len(self.times) - 2)
        h = self.times[i + 1] - self.times[i]
        u = (t - self.times[i]) / h
        powers = u[:, None] ** np.arange(6)
        p, v, a = self.positions, self.velocities, self.accelerations
        hh = h[:, None]
        ends = (p[i], v[i] * hh, a[i] * hh * hh, p[i + 1], v[i + 1] * hh, a[i + 1] * hh * hh)
        found = []
        for d in derivatives:
            weights = (_derived(powers, d) @ _BASIS.T)[:, :, None]
            found.append(np.asarray(sum(weights[:, r] * end for r, end in enumerate(ends)) / hh**d))
        return found


def _derived(powers: Array, derivative: int) -> Array:
    """Return derivatives (M, 6) by u of the powers 0 to 5 of u (M, 6)."""
    derived, factor = np.zeros_like(powers), np.ones(6)
    derived[:, derivative:] = powers[:, : 6 - derivative]
    for d in range(derivative):
        factor *= np.arange(6) - d
    return derived * factor
