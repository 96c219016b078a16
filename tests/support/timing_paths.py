"""Limits and paths that the timing tests share."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from hypothesis import strategies as st

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment, SegmentKind, SegmentLimits
from pickcli.timing.timed_run import TimedRun, time_run

VELOCITY = np.array([1.0, 2.2, 2.2, 2.9, 2.9, 3.4, 3.4, 6.8])
ACCELERATION = np.array([2.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0, 10.0])
SEEDS = st.integers(0, 10**6)


def limits(n: int = 8, reach: float = 50.0) -> Limits:
    """Velocities and accelerations of the default cell's joints, jerk that builds them up in 0.05 s."""
    a = ACCELERATION[:n]
    return Limits(np.full(n, -reach), np.full(n, reach), VELOCITY[:n], a, a / 0.05)


def names(n: int = 8) -> tuple[str, ...]:
    return tuple(f"joint_{i}" for i in range(n))


def random_walk(seed: int, n_points: int, n: int = 8, size: float = 0.5) -> Array:
    """A coarse path: straight edges in random directions."""
    rng = np.random.default_rng(seed)
    return np.cumsum(rng.normal(size=(n_points, n)) * size, axis=0)


def dense_curve(seed: int, n_points: int, n: int = 8, size: float = 0.2) -> Array:
    """A smooth motion densely sampled, as inverse kinematics along a straight line gives it."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, n_points)[:, None]
    return np.asarray(size * np.sin(rng.uniform(0.9, 4.5, n) * t + rng.uniform(0.0, 6.0, n)))


def segment(
    waypoints: Array, tolerance: float = 0.02, kind: SegmentKind = SegmentKind.TRANSIT, **limited: float
) -> PathSegment:
    """A segment along waypoints (N, n); limited: other fields of its limits."""
    return PathSegment(kind, waypoints, SegmentLimits(blend_tolerance=tolerance, **limited))


def timed(waypoints: Array, tolerance: float = 0.02, **limited: float) -> TimedRun:
    """One segment, timed."""
    n = waypoints.shape[1]
    return time_run(names(n), [segment(waypoints, tolerance, SegmentKind.TRANSIT, **limited)], limits(n))


@st.composite
def polylines(draw: st.DrawFn) -> Array:
    """Paths with everything that breaks: repeats, near-repeats, collinear points, reversals, tiny steps."""
    n = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(SEEDS))
    points = [rng.normal(size=n)]
    for kind in draw(
        st.lists(st.sampled_from(["step", "repeat", "near", "back", "on", "tiny"]), max_size=12)
    ):
        last, before = points[-1], points[-2] if len(points) > 1 else points[-1] - 1.0
        points.append(
            {
                "step": last + rng.normal(size=n) * 0.4,
                "repeat": last,
                "near": last + rng.normal(size=n) * 1e-8,
                "back": before,
                "on": last + (last - before) * 0.5,
                "tiny": last + rng.normal(size=n) * 1e-5,
            }[kind]
        )
    return np.array(points)


def distance_to_polyline(q: Array, waypoints: Array) -> Array:
    """(M,) Euclidean distance of points to a polyline, by brute force."""
    best = np.linalg.norm(q[:, None] - waypoints, axis=2).min(axis=1)
    for a, b in pairwise(waypoints):
        length2 = float((b - a) @ (b - a))
        if length2 > 0.0:
            u = np.clip((q - a) @ (b - a) / length2, 0.0, 1.0)
            best = np.minimum(best, np.linalg.norm(q - a - u[:, None] * (b - a), axis=1))
    return np.asarray(best)
