"""Runs: strict limits everywhere, rest at the ends, near time-optimal, boundaries and caps where stated."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.path_parts import PathParts
from pickcli.timing.polyline_simplification import POINT_TOLERANCE
from pickcli.timing.timed_run import TimedRun, time_run
from pickcli.timing.toppra_closed_form import parametrize
from support.timing_paths import (
    dense_curve,
    distance_to_polyline,
    limits,
    names,
    polylines,
    random_walk,
    segment,
    timed,
)

MILLISECOND = 1e-3


def worst_at_every_ms(trajectory: Trajectory, n: int) -> list[float]:
    """Largest ratio of velocity, acceleration and jerk at every millisecond and at every point."""
    t = np.unique(np.concatenate([np.arange(0.0, trajectory.duration, MILLISECOND), trajectory.times]))
    bounds = (limits(n).velocity, limits(n).acceleration, limits(n).jerk)
    return [float((np.abs(trajectory.sample(t, d + 1)) / bound).max()) for d, bound in enumerate(bounds)]


def check_promises(run: TimedRun, waypoints: Array, tolerance: float) -> None:
    trajectory, n = run.trajectory, waypoints.shape[1]
    assert np.all(np.isfinite(trajectory.positions)) and trajectory.times[0] == 0.0
    assert np.all(np.diff(trajectory.times) > 0.0)
    assert np.array_equal(trajectory.positions[[0, -1]], waypoints[[0, -1]])
    assert not trajectory.velocities[[0, -1]].any() and not trajectory.accelerations[[0, -1]].any()
    assert max(worst_at_every_ms(trajectory, n)) <= 1.0 + 1e-6
    q = trajectory.sample(np.linspace(0.0, trajectory.duration, 1500))
    bound = tolerance + run.deviation * np.sqrt(n) + 2 * POINT_TOLERANCE
    assert distance_to_polyline(q, waypoints).max() <= bound
    assert run.deviation < 1e-4  # corners a hundredth of a millimetre apart; else far less, see below


@given(polylines(), st.floats(1e-3, 0.1))
@settings(max_examples=150, deadline=None)
def test_any_path_keeps_every_promise(waypoints: Array, tolerance: float) -> None:
    check_promises(timed(waypoints, tolerance), waypoints, tolerance)


@pytest.mark.parametrize("size", [1e-9, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3])
def test_tiny_moves(size: float) -> None:
    waypoints = random_walk(0, 3, size=size)
    check_promises(timed(waypoints), waypoints, 0.02)


def test_waypoints_that_end_in_one_point_are_passed() -> None:
    """Their arc length differs from the path's by rounding: there the last part's limits hold."""
    rng = np.random.default_rng(0)
    for _ in range(10):
        ends = -1.37426978 - 10.0 ** rng.uniform(-11.0, -7.0, 2)
        waypoints = np.array([0.12573022, -0.87426978, *[-1.37426978] * 3, *ends])[:, None]
        check_promises(timed(waypoints, 0.0625), waypoints, 0.0625)


def test_no_move_at_all_is_a_short_rest() -> None:
    run = timed(np.full((3, 8), 0.3))
    assert np.ptp(run.trajectory.positions, axis=0).max() == 0.0
    assert 0.0 < run.trajectory.duration < 0.02


@pytest.mark.parametrize("seed", range(20))
def test_dense_curves_keep_every_promise(seed: int) -> None:
    waypoints = dense_curve(seed, 60)
    run = timed(waypoints, 0.003)
    check_promises(run, waypoints, 0.003)
    assert run.deviation < 1e-5


@pytest.mark.parametrize(("distance", "slack"), [(1.0, 1.03), (0.3, 1.05), (0.05, 1.1), (0.01, 1.2)])
def test_straight_move_is_near_the_time_optimal_one(distance: float, slack: float) -> None:
    run = timed(np.array([[0.0, 0.0], [distance, 0.1 * distance]]))
    v, a, j = (float(limit[0]) for limit in (limits().velocity, limits().acceleration, limits().jerk))
    assert run.trajectory.duration <= slack * _seven_phases(distance, v, a, j)
    assert run.trajectory.duration >= _seven_phases(distance, v, a, j) * (1.0 - 1e-9)


def _seven_phases(distance: float, v: float, a: float, j: float) -> float:
    """Duration of the time-optimal move from rest to rest under velocity, acceleration and jerk."""
    if distance < 2 * a**3 / j**2:
        return float(4.0 * np.cbrt(distance / (2 * j)))
    peak = min(v, (-(a**2) / j + np.sqrt((a**2 / j) ** 2 + 4 * a * distance)) / 2)
    return float(distance / peak + peak / a + a / j)


@pytest.mark.parametrize("seed", range(6))
def test_coarse_motion_costs_little_more_than_without_jerk_limits(seed: int) -> None:
    from pickcli.timing.path_limits import path_bounds

    run = timed(random_walk(seed, 4), 0.05)
    whole = np.array([0.0, run.curve.length])
    bounds = path_bounds(run.curve, limits(), whole, np.ones(1), np.array([np.inf]), None)
    without_jerk = parametrize(bounds.grid(run.curve, 1.0, np.inf, 0.0)).duration
    # A start and a stop cost a ramp of 0.05 s together, every corner about as much.
    assert run.trajectory.duration <= 1.05 * without_jerk + 3 * 0.05


def test_same_input_same_bytes() -> None:
    a, b = (timed(random_walk(4, 6)).trajectory for _ in range(2))
    assert a.positions.tobytes() == b.positions.tobytes() and a.times.tobytes() == b.times.tobytes()


def parts_of(waypoints: Array, at: int, **second: float) -> list[PathSegment]:
    return [segment(waypoints[: at + 1], 0.05), segment(waypoints[at:], kind=SegmentKind.APPROACH, **second)]


def test_run_moves_through_part_boundaries_without_stopping() -> None:
    waypoints = random_walk(2, 6)
    parts = parts_of(waypoints, 3)
    run = time_run(names(), parts, limits())
    inner = run.trajectory.sample(np.linspace(0.05, run.trajectory.duration - 0.05, 500), 1)
    assert np.abs(inner).max(axis=1).min() > 0.01
    assert run.part_times[0] == 0.0 and run.part_times[-1] == run.trajectory.duration
    boundary = run.curve.evaluate(PathParts.of(parts).boundaries(run.curve)[1])[0]
    assert np.allclose(run.trajectory.sample(run.part_times[1])[0], boundary, atol=1e-5)


def test_a_narrower_part_ends_where_the_blend_begins() -> None:
    """What follows a straight line may round the corner between them; the line itself stays straight."""
    waypoints = random_walk(2, 6)
    run = time_run(names(), [segment(waypoints[:4], 0.001), segment(waypoints[3:], 0.05)], limits())
    t = np.linspace(0.0, run.part_times[1], 2000)
    assert distance_to_polyline(run.trajectory.sample(t), waypoints).max() <= 0.001
    t = np.linspace(run.part_times[1], run.trajectory.duration, 2000)
    assert 0.001 < distance_to_polyline(run.trajectory.sample(t), waypoints).max() <= 0.05


def test_scale_of_a_part_holds_in_that_part_only() -> None:
    waypoints = random_walk(2, 6)
    run = time_run(names(), parts_of(waypoints, 3, speed_scale=0.5), limits())
    ratios = []
    for start, end in zip(run.part_times[:-1], run.part_times[1:], strict=True):
        t = np.linspace(start, end, 2000)
        bounds = (limits().velocity, limits().acceleration, limits().jerk)
        ratios.append([(np.abs(run.trajectory.sample(t, d + 1)) / b).max() for d, b in enumerate(bounds)])
    assert max(ratios[1]) <= 0.5 + 1e-6
    assert max(ratios[0][1:]) > 0.7


def test_tool_speed_is_capped_where_stated() -> None:
    waypoints = random_walk(2, 6)

    def tool_speed(Q: Array, dQ: Array) -> Array:
        return np.asarray(np.linalg.norm(dQ[:, :3], axis=1))

    run = time_run(names(), parts_of(waypoints, 3, max_tool_speed=0.2), limits(), jacobian_speed=tool_speed)
    t = np.linspace(0.0, run.trajectory.duration, 4000)
    speed = np.linalg.norm(run.trajectory.sample(t, 1)[:, :3], axis=1)
    capped = t >= run.part_times[1]
    assert speed[capped].max() <= 0.2 * 1.001
    assert speed[capped].max() >= 0.2 * 0.95
    assert speed[~capped].max() > 0.4


@pytest.mark.parametrize("slow", [0.03, 0.01, 0.005])
def test_only_a_slow_part_is_slow(slow: float) -> None:
    """What comes before a part with a very low speed of the tool takes as long as before a stop there."""
    line = np.linspace([0.0, 0.0, 0.0, 0.0], [1.2, 0.3, 0.1, 0.2], 4)
    line[-1] = line[-2] + (line[-1] - line[-2]) / 20

    def tool_speed(Q: Array, dQ: Array) -> Array:
        return np.asarray(np.linalg.norm(dQ[:, :3], axis=1))

    parts = [segment(line[:3], 0.05), segment(line[2:], 0.002, SegmentKind.CONTACT, max_tool_speed=slow)]
    run = time_run(names(4), parts, limits(4), jacobian_speed=tool_speed)
    until_stop = timed(line[:3], 0.05)
    assert run.part_times[1] <= until_stop.trajectory.duration + 0.1
    t = np.linspace(run.part_times[1], run.trajectory.duration, 4000)
    assert np.linalg.norm(run.trajectory.sample(t, 1)[:, :3], axis=1).max() <= slow * 1.001


def test_cap_without_a_tool_is_refused() -> None:
    with pytest.raises(ValueError, match="jacobian_speed"):
        time_run(names(), parts_of(random_walk(2, 6), 3, max_tool_speed=0.2), limits())


def test_parts_that_do_not_join_are_refused() -> None:
    a, b = random_walk(0, 3), random_walk(1, 3) + 1.0
    with pytest.raises(ValueError, match="segment 1"):
        time_run(names(), [segment(a), segment(b, kind=SegmentKind.LIFT)], limits())


def test_corner_that_cannot_be_blended_is_a_stop_within_the_run() -> None:
    waypoints = np.array([[0.0, 0.0], [0.5, 0.0], [0.5, 0.5]])

    def only_the_polyline(part: int, chords: Array, slack: Array) -> int:
        off = distance_to_polyline(chords, waypoints) > 1e-9
        return -1 if not off.any() else max(int(np.argmax(off)) - 1, 0)

    run = time_run(names(2), [segment(waypoints)], limits(2), only_the_polyline)
    at_corner = int(np.linalg.norm(run.trajectory.positions - waypoints[1], axis=1).argmin())
    assert np.allclose(run.trajectory.positions[at_corner], waypoints[1], atol=1e-9)
    assert not run.trajectory.velocities[at_corner].any()
    check_promises(run, waypoints, 0.0)


def test_a_start_measured_on_its_limit_is_no_violation() -> None:
    """Encoders are no doubles: what lies a tenth of a microradian beyond a limit can still move."""
    waypoints = np.array([[1.0 + 1e-7, 0.0], [0.5, 0.4], [0.2, 0.1]])
    run = time_run(names(2), [segment(waypoints)], limits(2, reach=1.0))
    assert np.array_equal(run.trajectory.positions[0], waypoints[0])
    with pytest.raises(NoPlanError, match="joint limit"):
        time_run(names(2), [segment(waypoints + 1e-5)], limits(2, reach=1.0))
