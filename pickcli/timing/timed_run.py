"""Timed runs: the path between two stops, stitched from its segments and timed as one motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment, SegmentLimits
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.blend_validation import IsFree, proven_blend
from pickcli.timing.corner_blending import BlendedPath
from pickcli.timing.jerk_smoothing import TimeLaw, join, standing
from pickcli.timing.limit_check import LimitReport, check_limits, peaks
from pickcli.timing.path_constraint import PathConstraint
from pickcli.timing.path_limits import PLANE_STEP, PathBounds, ToolSpeed, path_bounds
from pickcli.timing.path_parts import PathParts
from pickcli.timing.polyline_simplification import NOWHERE
from pickcli.timing.time_parameterization import retime, to_trajectory
from pickcli.timing.trajectory_chords import trajectory_chords

POINT_TIME = 0.008  # s between trajectory points, before scaling time
MAX_TIME_SCALE = 2.0  # of the whole motion, for a path constraint that is broken in one place
CHECK_STEP = 1e-3  # s between the states at which a path constraint is checked


@dataclass(frozen=True, eq=False)
class TimedRun:
    """A run in time, from rest to rest.

    Attributes:
        trajectory: N points with quintics in between.
        part_times: (P + 1,) s when each segment begins, and the run's end (see ``PathParts``).
        piece_scales: (N - 1,) speed scale of each piece of the trajectory, for ``check_limits``.
        curve: The path that the trajectory follows.
        law: Time law along the path.
        time_scale: Factor by which time was stretched at the end to keep the limits strictly.
        report: Ratios to the limits.
    """

    trajectory: Trajectory
    part_times: Array
    piece_scales: Array
    curve: BlendedPath
    law: TimeLaw
    time_scale: float
    report: LimitReport

    @cached_property
    def deviation(self) -> float:
        """Bound on how far the trajectory's quintics deviate from the path, for any joint, in joint units."""
        return _deviation(self.curve, self.law, self.trajectory)


def time_run(
    joint_names: tuple[str, ...],
    segments: Sequence[PathSegment],
    limits: Limits,
    is_free: IsFree | None = None,
    jacobian_speed: ToolSpeed | None = None,
    step: float = POINT_TIME,
    constraint: PathConstraint | None = None,
) -> TimedRun:
    """Time one motion through all segments, at rest only at its ends and at corners that cannot be blended.

    Args:
        joint_names: Names of the n joints.
        segments: Segments of the motion, each starting at the end of the one before.
        limits: Limits of the joints.
        is_free: Returns for (index of a segment, chords, slack) the first chord not proven free, or -1; None
            trusts the blends' bound.
        jacobian_speed: Tool travel per unit of path, needed if a segment has ``max_tool_speed``.
        step: s between points of the trajectory.
        constraint: Constraint that is kept along the whole run, at every millisecond.

    Returns:
        The timed run.

    Raises:
        ValueError: If two segments do not join.
        NoPlanError: If the path is not free, or not even rest keeps the constraint.
        LimitError: If the result breaks a limit, which is a bug.
    """
    parts = PathParts.of(segments)
    curve = proven_blend(parts, limits, is_free)
    scales = np.array([segment.limits.speed_scale for segment in segments])
    caps = np.array([_cap(segment.limits) for segment in segments])
    bounds = path_bounds(curve, limits, parts.boundaries(curve), scales, caps, jacobian_speed, constraint)
    if constraint is not None:
        _check_rest(curve, constraint)
    law, time_scale = _time_law(curve, bounds, step)
    if jacobian_speed is not None:
        excess = _tool_excess(curve, bounds, law, jacobian_speed)
        law, time_scale = law.time_scaled(excess), time_scale * excess
    if constraint is not None:
        excess = _constraint_excess(to_trajectory(curve, law), constraint)
        law, time_scale = law.time_scaled(excess), time_scale * excess
    trajectory = _exact_ends(to_trajectory(curve, law, joint_names), parts.waypoints)
    piece_scales = bounds.lowest(scales, law.s[:-1], law.s[1:])
    report = check_limits(trajectory, limits, piece_scales)
    times = law.times_at(bounds.edges)
    return TimedRun(trajectory, times, piece_scales, curve, law, time_scale, report)


def _cap(limits: SegmentLimits) -> float:
    return np.inf if limits.max_tool_speed is None else limits.max_tool_speed


def _time_law(curve: BlendedPath, bounds: PathBounds, step: float) -> tuple[TimeLaw, float]:
    """Compute the whole curve's law, with rests at its stops, and the largest time scale of its parts."""
    if curve.length <= NOWHERE:
        return standing(curve.length, step), 1.0
    laws, start, time_scale = [], 0.0, 1.0
    for part in curve.split():
        local = bounds.shifted(start)
        timed = retime(part, local, step)
        laws.append(timed.law.time_scaled(timed.time_scale).shifted(start))
        time_scale = max(time_scale, timed.time_scale)
        start += part.length
    return join(laws), time_scale


def _tool_excess(curve: BlendedPath, bounds: PathBounds, law: TimeLaw, tool_speed: ToolSpeed) -> float:
    """Return the factor, at least 1, by which the tool's exact speed, not interpolated, exceeds a cap."""
    cap = bounds.lowest(bounds.tool_caps, law.s, law.s)
    capped = np.isfinite(cap)
    if not capped.any():
        return 1.0
    speed = tool_speed(*curve.evaluate_all(law.s[capped], 1)) * law.ds[capped]
    return max(float((speed / cap[capped]).max()), 1.0)


def _check_rest(curve: BlendedPath, constraint: PathConstraint) -> None:
    """Raise NoPlanError if not even rest keeps the constraint."""
    q = curve.evaluate(np.linspace(0.0, curve.length, int(np.ceil(curve.length / PLANE_STEP)) + 1))
    needed = constraint.time_scale(q, np.zeros_like(q), np.zeros_like(q))
    if not np.isfinite(needed).all():
        worst = int(np.argmax(needed))
        where = f"{worst / max(len(q) - 1, 1):.0%} of the way"
        raise NoPlanError(
            "a timed path", [Reason("limit broken even at rest", where, constraint.broken_at_rest(q[worst]))]
        )


def _constraint_excess(trajectory: Trajectory, constraint: PathConstraint) -> float:
    """Return the factor, at least 1, that slows the motion so that it keeps the constraint at every ms."""
    t = np.linspace(0.0, trajectory.duration, int(np.ceil(trajectory.duration / CHECK_STEP)) + 1)
    needed = constraint.time_scale(*trajectory.states(t))
    worst = int(np.argmax(needed))
    if needed[worst] > MAX_TIME_SCALE:
        at = f"at {t[worst]:.3f} s of {trajectory.duration:.3f} s"
        how = f"{constraint}: the whole motion would have to be {needed[worst]:.3g} times slower"
        raise NoPlanError("a timed path", [Reason("limit broken nearly at rest", at, how)])
    return float(needed[worst])


def _exact_ends(trajectory: Trajectory, waypoints: Array) -> Trajectory:
    """Set a trajectory's ends to the first and last waypoint exactly, at rest: changes it, and returns it."""
    trajectory.positions[[0, -1]] = waypoints[[0, -1]]
    trajectory.velocities[[0, -1]] = 0.0
    trajectory.accelerations[[0, -1]] = 0.0
    return trajectory


def _deviation(curve: BlendedPath, law: TimeLaw, trajectory: Trajectory) -> float:
    """Bound the distance, per joint, between the trajectory's quintics and the curve that they sample.

    The smaller of two bounds is used in each cell. Both curves meet at every point with velocity and
    acceleration: an error with triple zeros at both ends of a cell of length h is largest for the perfect
    spline with knots at cos(k pi / 4), h^3 (1 - 1 / sqrt 2) / 48 times the largest difference of the third
    derivatives. And the distance is at most the sum of the distances of both from their common chord.
    """
    h = np.diff(law.t)[:, None]
    start, end = law.s[:-1], law.s[1:]
    bend = curve.second_derivative_bound(start, end)
    pull = np.maximum(np.abs(law.dds[1:]), np.abs(law.dds[:-1]))[:, None]
    speed = np.maximum(law.ds[1:], law.ds[:-1])[:, None] + h * pull
    jerk = (
        curve.third_derivative_bound(start, end) * speed**3
        + 3.0 * bend * speed * pull
        + np.abs(np.diff(law.dds))[:, None] / h
    )
    by_jerk = h**3 * (1.0 - 0.5**0.5) / 48 * (jerk + peaks(trajectory)[2])
    by_chord = bend * (end - start)[:, None] ** 2 / 8 + trajectory_chords(trajectory)[1]
    return float(np.minimum(by_jerk, by_chord).max())
