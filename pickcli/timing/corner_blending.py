"""Corner blending: a polyline becomes a C3 path that stays within a stated bound of it.

A polyline is a sum of ramps: at corner k, at arc length s_k, its direction changes by turn_k,

    p(s) = V_0 + d_0 s + sum_k turn_k max(s - s_k, 0).

Each ramp is replaced by a smooth one that differs from it only within h_k of the corner; its slope is the
quintic smoothstep, so position, direction, curvature and the rate of curvature are continuous and jerk has no
jumps. A single corner gets a blend between two straight lines. Where waypoints are dense, on a curved motion,
the blends overlap and the sum is the curve that the waypoints sample, without the ripple of blends confined
to half an edge. The distance to the polyline is a sum of bumps,

    q(s) - p(s) = sum_k turn_k h_k bump((s - s_k) / h_k),   0 <= bump <= DEPTH,

from which the bound follows. The parameter s is the arc length of the polyline, in the Euclidean norm of
joint units (rad and m alike); every waypoint is projected to its s on the polyline.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kernel import BlendedPolyline
from pickcli.timing.jerk_smoothing import TimeLaw
from pickcli.timing.polyline_simplification import POINT_TOLERANCE, arc_lengths, canonical

Indices: TypeAlias = NDArray[np.intp]
Mask: TypeAlias = NDArray[np.bool_]

DEPTH = 0.15625  # bump(0)
_SIMPLIFY = 0.05  # share of the tolerance that is used for dropping waypoints


@dataclass(frozen=True, eq=False)
class BlendedPath:
    """A polyline with smoothed corners, parametrised by the polyline's arc length s.

    Attributes:
        corners: (K, n), K >= 1, no two consecutive ones equal.
        half_lengths: (K,) h of every corner; 0 at both ends, and at corners where the motion must stop.
        waypoint_s: (N,) s of each original waypoint, not decreasing.
    """

    corners: Array
    half_lengths: Array
    waypoint_s: Array

    @cached_property
    def corner_s(self) -> Array:
        """(K,) s of every corner."""
        edges = np.linalg.norm(np.diff(self.corners, axis=0), axis=1)
        return np.concatenate([[0.0], np.cumsum(edges)])

    @property
    def length(self) -> float:
        """The largest s, in joint units."""
        return float(self.corner_s[-1])

    @cached_property
    def directions(self) -> Array:
        """(K + 1, n) unit direction before and after every corner; at the ends, that of their only edge."""
        if len(self.corners) == 1:
            return np.zeros((2, self.corners.shape[1]))
        edges = np.diff(self.corners, axis=0)
        unit = edges / np.linalg.norm(edges, axis=1)[:, None]
        return np.concatenate([unit[:1], unit, unit[-1:]])

    @cached_property
    def turns(self) -> Array:
        """(K, n) change of direction at every corner."""
        return np.diff(self.directions, axis=0)

    @cached_property
    def _kernel(self) -> BlendedPolyline:
        """The blended curve in the kernel, which evaluates it faster."""
        return BlendedPolyline(self.corners, self.corner_s, self.half_lengths, self.directions, self.turns)

    @property
    def stops(self) -> Indices:
        """Indices of the inner corners that are not smoothed: the motion must be at rest there."""
        return 1 + np.flatnonzero(self.half_lengths[1:-1] == 0.0)

    @cached_property
    def knots(self) -> Array:
        """Sorted s of both ends, all stops, and nodes within the blends, dense where the path bends fast.

        Between two knots outside of all blends the path is a straight line.
        """
        return self._kernel.knots()

    def is_line(self, start: Array, end: Array) -> Mask:
        """Whether the path is straight on intervals between knots.

        Args:
            start: (M,) s of the interval starts.
            end: (M,) s of the interval ends.

        Returns:
            (M,) True if it is straight.
        """
        return self._kernel.are_lines(start, end)

    def split(self) -> tuple[BlendedPath, ...]:
        """Cut the path at its stops.

        Returns:
            The pieces. Each counts s from 0, and its ``waypoint_s`` are those of its own corners.
        """
        cuts = np.concatenate([[0], self.stops, [len(self.corners) - 1]])
        pieces = [(self.corners[a : b + 1], self.half_lengths[a : b + 1]) for a, b in pairwise(cuts)]
        curves = [BlendedPath(corners, half, np.zeros(1)) for corners, half in pieces]
        return tuple(replace(c, waypoint_s=c.corner_s) for c in curves)

    def evaluate(self, s: Array | float, derivative: int = 0) -> Array:
        """Return the configuration or one of its derivatives by s.

        Args:
            s: (M,) path parameters.
            derivative: 0 for the configuration, 1 to 3 for a derivative.

        Returns:
            (M, n).
        """
        return np.asarray(self.evaluate_all(s, derivative)[derivative])

    def evaluate_all(self, s: Array | float, highest: int = 3) -> Array:
        """Return the configuration and its derivatives by s.

        Args:
            s: (M,) path parameters, clamped to the path.
            highest: Highest derivative, 0 to 3.

        Returns:
            (highest + 1, M, n): q, q', ... up to ``highest``.
        """
        return self._kernel.evaluate(np.atleast_1d(np.asarray(s, dtype=np.float64)), highest)

    def needed_time_scale(self, law: TimeLaw, limits: Limits, scale: Array) -> Array:
        """Return the factor of time at which a motion along the path keeps its limits, between points.

        Args:
            law: The time law of the motion, at K points in time.
            limits: Limits of the joints.
            scale: (K - 1,) factor on all limits, between consecutive points.

        Returns:
            (K - 1,) at least 1.
        """
        return self._kernel.needed_time_scale(
            law.t, law.s, law.ds, law.dds, limits.velocity, limits.acceleration, limits.jerk, scale
        )

    def second_derivative_bound(self, start: Array, end: Array) -> Array:
        """Return upper bounds of the absolute second derivative by s, on intervals.

        Args:
            start: (M,) s of the interval starts.
            end: (M,) s of the interval ends.

        Returns:
            (M, n), for each joint.
        """
        return self._kernel.second_derivative_bound(start, end)

    def third_derivative_bound(self, start: Array, end: Array) -> Array:
        """Return upper bounds of the absolute third derivative by s, on intervals.

        Args:
            start: (M,) s of the interval starts.
            end: (M,) s of the interval ends.

        Returns:
            (M, n), for each joint.
        """
        return self._kernel.third_derivative_bound(start, end)

    def deviation(self, start: Array, end: Array) -> Array:
        """Return upper bounds of the Euclidean distance to the polyline, on intervals.

        Args:
            start: (M,) s of the interval starts.
            end: (M,) s of the interval ends.

        Returns:
            (M,) in joint units.
        """
        return self._kernel.deviation(start, end)


def distinct(s: Array) -> Array:
    """Sort values and drop those that differ from a neighbour only by rounding; the largest is kept as is.

    Args:
        s: Values, at least one.

    Returns:
        The remaining values, sorted.
    """
    s = np.sort(s)
    tolerance = min(1e-8, 0.1 * float(s[-1]))
    keep = np.concatenate([[True], np.diff(s) > tolerance]) & (s < s[-1] - tolerance)
    return np.concatenate([s[keep], s[-1:]]) if s[-1] > 0.0 else np.zeros(1)


def blend(waypoints: Array, tolerances: Array | float, simplify: float = _SIMPLIFY) -> BlendedPath:
    """Blend a polyline to a smooth path that deviates from it by no more than the tolerances.

    Args:
        waypoints: (N, n) configurations.
        tolerances: (N,) or one for all, in joint units: bound on the Euclidean distance between path and
            polyline, along the half edges next to each waypoint. 0 makes the waypoint, if it is a corner, a
            stop.
        simplify: Share of the tolerance within which waypoints are dropped first; the rest is for the blends.

    Returns:
        The blended path.
    """
    tolerance = np.array(np.broadcast_to(np.asarray(tolerances, dtype=float), (len(waypoints),)))
    kept = canonical(waypoints, np.maximum(simplify * tolerance, POINT_TOLERANCE))
    curve = BlendedPath(waypoints[kept], np.zeros(len(kept)), arc_lengths(waypoints, kept))
    return smoothed(curve, (1.0 - simplify) * tolerance, (1.0 - simplify) * tolerance[kept])


def smoothed(curve: BlendedPath, allowed: Array, wanted: Array) -> BlendedPath:
    """Smooth the corners of a path as far as two sets of tolerances allow.

    Args:
        curve: The path, with its corners.
        allowed: (N,) bound on the deviation near every waypoint.
        wanted: (K,) bound on the contribution of each corner; 0 makes it a stop.

    Returns:
        The path with new half-lengths.
    """
    half = np.zeros(len(curve.corners))
    if len(half) < 3:
        return replace(curve, half_lengths=half)
    turn = np.maximum(np.linalg.norm(curve.turns, axis=1), POINT_TOLERANCE)
    fixed = np.concatenate([[True], wanted[1:-1] <= 0.0, [True]])  # no blend extends over ends and stops
    walls, free = curve.corner_s[fixed], curve.corner_s[~fixed]
    i = np.searchsorted(walls, free)
    available = np.minimum(free - walls[i - 1], walls[i] - free)
    half[~fixed] = np.minimum(wanted[~fixed] / (DEPTH * turn[~fixed]), available)
    return _shrunk(replace(curve, half_lengths=half), allowed)


def _shrunk(curve: BlendedPath, allowed: Array, n_rounds: int = 8) -> BlendedPath:
    """Reduce half-lengths until the sum of all bumps keeps the tolerance near every waypoint."""
    for _ in range(n_rounds):
        start, end, bound = _intervals(curve, allowed)
        excess = curve.deviation(start, end) / bound
        if excess.max(initial=0.0) <= 1.0:
            return curve
        s, h = curve.corner_s[:, None], curve.half_lengths[:, None]
        worst = np.max(np.where((start < s + h) & (end > s - h), excess, 0.0), axis=1)
        # The sum over a dense row of blends grows with h squared, a single bump with h.
        shrink = np.where(worst > 1.0, np.maximum(worst, 1.05) ** -0.6, 1.0)
        curve = replace(curve, half_lengths=curve.half_lengths * shrink)
    # Each bump shrinks at least as fast as its h: one common factor corrects the rest.
    start, end, bound = _intervals(curve, allowed)
    excess = curve.deviation(start, end) / bound
    return replace(curve, half_lengths=curve.half_lengths / max(float(excess.max(initial=0.0)), 1.0))


def _intervals(curve: BlendedPath, allowed: Array) -> tuple[Array, Array, Array]:
    """Return intervals on which the curve may leave the polyline: start, end and tolerance."""
    middles = (curve.waypoint_s[1:] + curve.waypoint_s[:-1]) / 2
    cuts = distinct(np.concatenate([curve.knots, curve.corner_s, middles]))
    start, end = cuts[:-1], cuts[1:]
    bent = ~curve.is_line(start, end)
    start, end = start[bent], end[bent]
    nearest = np.searchsorted(middles, (start + end) / 2)
    return start, end, np.maximum(allowed[nearest], POINT_TOLERANCE**2)
