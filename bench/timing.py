"""How long timing takes, and how much slower than without jerk limits its motions are.

    python bench/timing.py

Paths: coarse (5 random configurations), insert (60 dense ones along a curve, as inverse kinematics gives
them) and pick (coarse, then dense: 62 waypoints). Printed per kind, over several seeds: median milliseconds
of a run, seconds of motion, the ratio to the time-optimal motion along the same curve without jerk limits,
and the last scaling of time. Then the tracker's microseconds per update and a protective stop's milliseconds.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.io_events.tracker import EventTracker
from pickcli.motion.segment import PathSegment, SegmentKind, SegmentLimits
from pickcli.timing.path_limits import path_bounds
from pickcli.timing.stopping_trajectory import stop
from pickcli.timing.timed_run import TimedRun, time_run
from pickcli.timing.toppra_closed_form import parametrize

ACCELERATION = np.array([2.0, 5.0, 5.0, 6.0, 6.0, 7.0, 7.0, 10.0])
LIMITS = Limits(
    np.full(8, -50.0),
    np.full(8, 50.0),
    np.array([1.0, 2.2, 2.2, 2.9, 2.9, 3.4, 3.4, 6.8]),
    ACCELERATION,
    ACCELERATION / 0.05,
)
NAMES = ("rail", "s", "l", "e", "u", "r", "b", "t")
N_SEEDS = 12


def coarse(rng: np.random.Generator) -> list[PathSegment]:
    waypoints = np.cumsum(rng.normal(size=(5, 8)) * 0.4, axis=0)
    return [PathSegment(SegmentKind.TRANSIT, waypoints, SegmentLimits(blend_tolerance=0.05))]


def curve(rng: np.random.Generator) -> Array:
    t = np.linspace(0.0, 1.0, 60)[:, None]
    return np.asarray(0.2 * np.sin(rng.uniform(0.9, 4.5, 8) * t + rng.uniform(0.0, 6.0, 8)))


def insert(rng: np.random.Generator) -> list[PathSegment]:
    return [PathSegment(SegmentKind.PREAPPROACH, curve(rng), SegmentLimits(blend_tolerance=0.002))]


def pick(rng: np.random.Generator) -> list[PathSegment]:
    dense = curve(rng)
    way = np.concatenate([dense[:1], dense[0] + np.cumsum(rng.normal(size=(3, 8)) * 0.4, axis=0)])[::-1]
    return [
        PathSegment(SegmentKind.TRANSIT, way, SegmentLimits(blend_tolerance=0.05)),
        PathSegment(SegmentKind.PREAPPROACH, dense, SegmentLimits(blend_tolerance=0.002)),
    ]


def measure(make: Callable[[np.random.Generator], list[PathSegment]]) -> tuple[Array, list[TimedRun]]:
    rows, runs = [], []
    for seed in range(N_SEEDS):
        parts = make(np.random.default_rng(seed))
        time_run(NAMES, parts, LIMITS)
        start = time.perf_counter()
        run = time_run(NAMES, parts, LIMITS)
        took = time.perf_counter() - start
        whole = np.array([0.0, run.curve.length])
        bounds = path_bounds(run.curve, LIMITS, whole, np.ones(1), np.array([np.inf]), None)
        fastest = parametrize(bounds.grid(run.curve, 1.0, np.inf, 0.0)).duration
        rows.append((took * 1e3, run.trajectory.duration, run.trajectory.duration / fastest, run.time_scale))
        runs.append(run)
    return np.median(rows, axis=0), runs


def main() -> None:
    print(f"{'kind':8} {'ms':>7} {'motion s':>9} {'/ no jerk':>9} {'scale':>8}")
    for make in (coarse, insert, pick):
        (took, lasts, ratio, scale), runs = measure(make)
        print(f"{make.__name__:8} {took:7.1f} {lasts:9.2f} {ratio:9.3f} {scale:8.4f}")
    trajectory = runs[0].trajectory
    tracker = EventTracker(trajectory, (), ())
    states = trajectory.sample(np.arange(0.0, trajectory.duration, 1e-3))
    start = time.perf_counter()
    for q in states:
        tracker.update(q, 1e-3)
    print(f"tracker: {(time.perf_counter() - start) / len(states) * 1e6:.1f} us per update")
    took = []
    for at in np.linspace(0.1, 0.9, 9) * trajectory.duration:
        start = time.perf_counter()
        stop(trajectory, float(at), LIMITS)
        took.append(time.perf_counter() - start)
    print(f"stop: median {np.median(took) * 1e3:.0f} ms, largest {max(took) * 1e3:.0f} ms")


if __name__ == "__main__":
    main()
