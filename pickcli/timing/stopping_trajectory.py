"""Protective stop at any time, and the resume after it: both along the path of the trajectory.

The robot's state is q(tau): tau is the trajectory's own time, and only its rate changes. ruckig plans tau(t)
with limits on d2tau/dt2 and d3tau/dt3; the motion of the joints is then

    dq = v tau',    ddq = a tau'^2 + v tau'',    dddq = j tau'^3 + 3 a tau' tau'' + v tau'''

with v, a, j of the trajectory at tau. How hard tau may be braked depends on the current state of the joints,
so several rates are tried, from the hardest, and the result is checked strictly. If the joints already brake
at their limits, the stop is delayed for a moment: limits are never exceeded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.errors import LimitError
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.limit_check import LIMIT_TOLERANCE, measure_limits

_POINT_TIME = 0.008  # s between points, at most
_TOO_CLOSE = 5e-4  # s: points nearer than this are one
_HOPELESS_TIME_SCALE = 1.5  # time scale beyond which no exact value is computed
_SLOWEST = 0.02  # s: ratio of velocity to acceleration limit below which a joint counts as at rest
_RATES = 0.65 ** np.arange(9)  # of the fastest change of tau' that the limits could ever allow
_WAITS = np.concatenate([np.arange(0.0, 0.2, 0.01), np.arange(0.2, 0.8, 0.03)])  # s until braking begins


@dataclass(frozen=True, eq=False)
class StoppedTrajectory:
    """A motion until standstill.

    Attributes:
        trajectory: The original up to the stop, then braking along the same path.
        path_time: s; time in the original trajectory of the configuration at standstill.
        law: (K, 3) times in this trajectory and in the original, s, and the rate of the latter, which is
            cubic in between; both times are the same before. None if this is the original.
    """

    trajectory: Trajectory
    path_time: float
    law: Array | None = None

    def path_times(self, t: Array) -> Array:
        """Return the times in the original trajectory at times of this one.

        Args:
            t: (N,) s.

        Returns:
            (N,) s.
        """
        if self.law is None:
            return t
        return np.asarray(np.where(t < self.law[0, 0], t, _cubic(self.law, t)))


@dataclass(frozen=True, eq=False)
class ResumedTrajectory:
    """The rest of a motion after a stop.

    Attributes:
        trajectory: From rest to the end of the original along its path; times from 0.
        law: (K, 3) times in this trajectory and in the original, s, and the rate of the latter, which is
            cubic in between.
    """

    trajectory: Trajectory
    law: Array

    def path_times(self, t: Array) -> Array:
        """Return the times in the original trajectory at times of this one.

        Args:
            t: (N,) s.

        Returns:
            (N,) s.
        """
        return _cubic(self.law, t)


@dataclass(frozen=True, eq=False)
class _TimeLaw:
    """tau and its derivatives at times t since the request."""

    t: Array
    tau: Array
    first: Array  # tau'
    second: Array  # tau''


def stop(trajectory: Trajectory, at: float, limits: Limits) -> StoppedTrajectory:
    """Find the fastest stop that keeps the path and all limits.

    If the robot comes to rest at the trajectory's end before any other stop is possible, it stops there.

    Args:
        trajectory: The trajectory to be stopped.
        at: Time of the request, s.
        limits: Limits of the joints.

    Returns:
        The motion until standstill.
    """
    best = StoppedTrajectory(trajectory, trajectory.duration)
    for wait in _WAITS:
        begin = (at if at > _TOO_CLOSE else 0.0) + float(wait)
        if begin >= best.trajectory.duration:
            break
        for rate in _fastest_rate(trajectory, begin, limits) * _RATES:
            law = _law(begin, 1.0, 0.0, rate, limits, trajectory)
            if begin + law.t[-1] >= best.trajectory.duration:
                break  # lower rates take longer still
            if (
                _needed_time_scale(trajectory, law, limits) <= 1.0 + LIMIT_TOLERANCE / 3
            ):  # jerk scales with the cube
                times = np.column_stack([law.t + law.tau[0], law.tau, law.first])
                driven = _driven(trajectory, law, with_start=True)
                best = StoppedTrajectory(driven, float(law.tau[-1]), times)
                break
    return best


def resume(trajectory: Trajectory, path_time: float, limits: Limits) -> ResumedTrajectory:
    """Continue a stopped trajectory along its path, from rest to its end.

    The trajectory's own timing is resumed; time is stretched as far as its limits require, and the fastest of
    several variants is returned.

    Args:
        trajectory: The stopped trajectory.
        path_time: s; time on it at which the robot stands.
        limits: Limits of the joints.

    Returns:
        The rest of the motion.

    Raises:
        LimitError: If the trajectory is not finite there.
    """
    left = trajectory.duration - path_time
    best_duration, best = np.inf, None
    for rate in _fastest_rate(trajectory, path_time, limits) * _RATES:
        law = _law(path_time, 0.0, 1.0, rate, limits, trajectory)
        duration = (law.t[-1] + left - (law.tau[-1] - path_time)) * _needed_time_scale(
            trajectory, law, limits
        )
        if duration < best_duration:
            best_duration, best = duration, law
    if best is None:
        raise LimitError(f"no resume at {path_time:.3f} s: the trajectory is not finite there")
    candidate = _driven(trajectory, best, with_start=False)
    factor = max(measure_limits(candidate, limits).time_scale, 1.0)
    times = [[*best.t, candidate.duration], [*best.tau, trajectory.duration], [*best.first, 1.0]]
    return ResumedTrajectory(_time_scaled(candidate, factor), np.array(times).T * (factor, 1.0, 1.0 / factor))


def _cubic(law: Array, t: Array) -> Array:
    """Interpolate a law (K, 3) of times, values and rates at times (N,), clipped to its ends."""
    at, value, rate = law.T
    t = np.clip(t, at[0], at[-1])
    i = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(at) - 2)
    span = np.maximum(at[i + 1] - at[i], np.finfo(float).tiny)
    x = (t - at[i]) / span
    change = value[i + 1] - value[i]
    a, b = rate[i] * span - change, change - rate[i + 1] * span
    return np.asarray(value[i] + x * change + x * (1.0 - x) * (a * (1.0 - x) + b * x))


def _needed_time_scale(trajectory: Trajectory, law: _TimeLaw, limits: Limits) -> float:
    """Return the factor of time, at least 1, at which the part driven by the law keeps the limits."""
    t, q, v, a = _law_rows(trajectory, law)
    at_points = float(np.sqrt((np.abs(a) / limits.acceleration).max()))
    if not at_points <= _HOPELESS_TIME_SCALE:
        return at_points
    return max(measure_limits(Trajectory(trajectory.joint_names, t, q, v, a), limits).time_scale, 1.0)


def _time_scaled(trajectory: Trajectory, factor: float) -> Trajectory:
    return Trajectory(
        trajectory.joint_names,
        trajectory.times * factor,
        trajectory.positions,
        trajectory.velocities / factor,
        trajectory.accelerations / factor**2,
    )


def _fastest_rate(trajectory: Trajectory, tau: float, limits: Limits) -> float:
    """Return the tau'' (1/s) at which the first joint around tau would need all of its acceleration."""
    velocity = np.abs(trajectory.sample(tau + np.linspace(-0.1, 0.1, 9), 1))
    return 1.0 / max(float((velocity / limits.acceleration).max()), _SLOWEST)


def _law(
    tau: float, speed: float, target: float, rate: float, limits: Limits, trajectory: Trajectory
) -> _TimeLaw:
    """Compute by ruckig the change of tau' from ``speed`` to ``target``, starting at tau."""
    import ruckig

    given, plan = ruckig.InputParameter(1), ruckig.Trajectory(1)
    given.control_interface = ruckig.ControlInterface.Velocity
    given.current_position, given.current_velocity, given.current_acceleration = [tau], [speed], [0.0]
    given.target_velocity, given.target_acceleration = [target], [0.0]
    given.max_acceleration = [rate]
    given.max_jerk = [rate * float((limits.jerk / limits.acceleration).min())]
    ruckig.Ruckig(1).calculate(given, plan)
    phases = plan.profiles[0][0]
    ends = np.cumsum(phases.t)
    start = np.array([phases.p[:7], phases.v[:7], phases.a[:7], phases.j])
    fine = np.linspace(0.0, plan.duration, int(np.ceil(plan.duration / 1e-3)) + 2)
    t = _points(fine, _along(start, ends, fine)[0], ends, trajectory.times)
    position, first, second = _along(start, ends, t)
    first[-1], second[-1] = target, 0.0
    return _TimeLaw(t, np.minimum(position, trajectory.duration), first, second)


def _along(start: Array, ends: Array, t: Array) -> tuple[Array, Array, Array]:
    """Return tau, tau', tau'' at times t, from the starts (4, 7) of seven phases of constant jerk."""
    i = np.minimum(np.searchsorted(ends, t), 6)
    p, v, a, j = start[:, i]
    x = t - np.concatenate([[0.0], ends])[i]
    return p + x * (v + x * (a / 2 + x * j / 6)), v + x * (a + x * j / 2), a + x * j


def _points(t: Array, tau: Array, ends: Array, knots: Array) -> Array:
    """Return times for trajectory points: the knots of law and trajectory, and evenly in between."""
    crossed = np.interp(knots[(knots > tau[0]) & (knots < tau[-1])], tau, t)
    times = np.sort(np.concatenate([[0.0, t[-1]], ends[ends < t[-1]], crossed]))
    times = times[np.concatenate([[True], np.diff(times) > _TOO_CLOSE])]
    times[-1] = t[-1]
    counts = np.ceil(np.diff(times) / _POINT_TIME - 1e-9).astype(int)
    pieces = [
        np.linspace(a, b, n, endpoint=False) for a, b, n in zip(times[:-1], times[1:], counts, strict=True)
    ]
    return np.concatenate([*pieces, t[-1:]])


def _law_rows(trajectory: Trajectory, law: _TimeLaw) -> tuple[Array, Array, Array, Array]:
    """Return times from 0, positions, velocities and accelerations while the law drives."""
    q, v, a = (trajectory.sample(law.tau, derivative) for derivative in range(3))
    first, second = law.first[:, None], law.second[:, None]
    return law.t, q, v * first, a * first**2 + v * second


def _driven(trajectory: Trajectory, law: _TimeLaw, with_start: bool) -> Trajectory:
    """Join the trajectory before the law (optional), the law, and the rest if the law ends at full speed."""
    rows = [_law_rows(trajectory, law)]
    points = (trajectory.times, trajectory.positions, trajectory.velocities, trajectory.accelerations)
    if with_start:
        before = trajectory.times < law.tau[0] - _TOO_CLOSE
        rows = [tuple(row[before] for row in points), (law.t + law.tau[0], *rows[0][1:])]
    if law.first[-1] > 0.0:
        after = trajectory.times > law.tau[-1] + _TOO_CLOSE
        later = trajectory.times[after] + (rows[-1][0][-1] - law.tau[-1])
        rows.append((later, *(row[after] for row in points[1:])))
    t, q, v, a = (np.concatenate(column) for column in zip(*rows, strict=True))
    v[-1] = a[-1] = 0.0
    return Trajectory(trajectory.joint_names, t - t[0], q, v, a)
