"""Plans end at the goal, keep their margin and every limit; drives with noise end as near as is asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.driving import STRAIGHT, random_area
from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.drive_smoothing import smooth_path
from pickcli.driving.drive_tracking import PERIOD, RATE, TrackingController, tangents
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.free_space_proof import clearances, first_encounter
from pickcli.driving.simulated_drives import DriveNoise, SimulatedDrives, simulate_drives
from pickcli.driving.speed_profile import speed_profile
from pickcli.driving.state_lattice import StateLattice
from pickcli.driving.steering_path import SteeringPath, posed, seen_from, wrapped
from pickcli.driving.tricycle import PLANNED_SHARE, Tricycle
from pickcli.errors import NoPlanError
from pickcli.geometry import Array

SILENT = DriveNoise(0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module", params=[(108, 0.0), (103, STRAIGHT), (105, STRAIGHT)], ids=str)
def plan(request: pytest.FixtureRequest) -> DrivePlan:
    return plan_drive(random_area(*request.param))


def empty_hall(goal: Array, straight: float = 0.0) -> DrivingArea:
    return DrivingArea((0.0, 0.0), (12.0, 12.0), (), np.array([3.0, 3.0, 0.2]), goal, straight)


def test_a_plan_leads_to_the_goal_and_is_free(plan: DrivePlan) -> None:
    area, path = plan.area, plan.path
    np.testing.assert_array_equal(path.start, area.start)
    error = seen_from(area.goal, path.end)
    error[2] = wrapped(error[2])
    np.testing.assert_allclose(error, 0.0, atol=1e-7)
    assert first_encounter(area, path, area.margin) is None
    travel = np.linspace(0, path.length, int(path.length / 0.001))
    assert clearances(area, path.poses_at(travel)).min() > area.margin
    assert path.steering[0] == path.steering[-1] == 0
    assert np.abs(path.steering).max() <= area.truck.planned_steering
    if area.straight:
        assert path.steps[-1] == area.straight
        assert (path.steering[-2:] == 0).all()


def test_smoothing_saves_time_and_actions(plan: DrivePlan) -> None:
    lattice = plan.lattice.path
    rest = abs(plan.area.straight)
    assert plan.path.length < lattice.length + rest
    assert plan.profile.duration < speed_profile(lattice).duration + rest / (0.3 * plan.area.truck.speed)
    assert len(plan.path.steps) <= 4 * (len(plan.path.cusps) + 1) + plan.path.length / 0.5 + 1


def test_every_limit_is_kept_at_every_millisecond(plan: DrivePlan) -> None:
    truck, path, profile = plan.area.truck, plan.path, plan.profile
    times = np.arange(0.0, profile.duration, 1e-3)
    travel, speeds = profile.travel_at(times), np.interp(times, profile.times, profile.speeds)
    steering = path.steering_at(travel)
    assert (np.diff(travel) >= 0).all() and travel[-1] == pytest.approx(path.length, abs=1e-5)
    np.testing.assert_allclose(np.diff(travel), 1e-3 * (speeds[1:] + speeds[:-1]) / 2, atol=2e-6)
    assert speeds.max() <= PLANNED_SHARE * truck.speed + 1e-9
    assert np.abs(np.diff(speeds)).max() <= 1e-3 * PLANNED_SHARE * truck.acceleration + 1e-9
    assert np.abs(np.diff(steering)).max() <= 1e-3 * PLANNED_SHARE * truck.steering_rate + 1e-9
    centripetal = speeds**2 * np.abs(np.sin(steering)) / truck.wheel_base
    assert centripetal.max() <= PLANNED_SHARE * truck.centripetal + 1e-9
    for cusp in path.knots[path.cusps].tolist():
        assert speeds[np.abs(travel - cusp).argmin()] < 2e-3


def test_no_part_of_a_profile_could_be_quicker(plan: DrivePlan) -> None:
    """Everywhere the acceleration is at its limit, or the speed at one end at a limit of a part beside it."""
    truck, path, profile = plan.area.truck, plan.path, plan.profile
    gains = np.abs(np.diff(profile.speeds**2)) / (2 * np.diff(profile.travel))
    is_quickest = gains >= PLANNED_SHARE * truck.acceleration - 1e-6
    steering = path.steering_at(profile.travel)
    sine = np.maximum(np.abs(np.sin(steering[1:])), np.abs(np.sin(steering[:-1])))
    slope = np.abs(np.diff(steering)) / np.diff(profile.travel)
    turning = np.sqrt(PLANNED_SHARE * truck.centripetal * truck.wheel_base / np.maximum(sine, 1e-9))
    limit = np.minimum(PLANNED_SHARE * truck.speed, turning)
    limit = np.minimum(limit, PLANNED_SHARE * truck.steering_rate / np.maximum(slope, 1e-9))
    least = np.minimum(limit, np.minimum(np.append(limit[1:], np.inf), np.append(np.inf, limit[:-1])))
    is_quickest |= np.maximum(profile.speeds[1:], profile.speeds[:-1]) >= least - 1e-6
    # Between speeding up and braking there is one part that holds the largest speed.
    is_quickest[1:-1] |= is_quickest[2:] & is_quickest[:-2]
    assert is_quickest.all() and len(is_quickest) > 100


@pytest.mark.parametrize("goal", [(9.0, 3.9, 0.2), (3.5, 8.0, 2.9), (3.0, 4.0, 0.2)], ids=str)
def test_goals_in_an_empty_hall(goal: tuple[float, float, float]) -> None:
    plan = plan_drive(empty_hall(np.array(goal)))
    np.testing.assert_allclose(plan.path.end[:2], goal[:2], atol=1e-7)
    assert plan.path.length < 14.0


def test_a_long_path_between_posts_is_smoothed() -> None:
    """Few actions that are read off a long path lead elsewhere: they are fitted to it first."""
    rng, n = np.random.default_rng(5), 22
    start = np.array([3.0, 3.0, 0.5])
    turns = np.column_stack([np.zeros((n, 1)), rng.uniform(-0.9, 0.9, (n, 2))]).ravel()
    path = SteeringPath(Tricycle(), start, rng.uniform(0.2, 0.4, 3 * n), np.append(turns, 0.0))
    low = path.knot_poses[:, :2].min(axis=0) - 3.0
    high = path.knot_poses[:, :2].max(axis=0) + 3.0
    posts = [
        FloorBox(f"post {k}", (x, y), (0.1, 0.1)) for k, (x, y) in enumerate(rng.uniform(low, high, (900, 2)))
    ]
    area = DrivingArea((low[0], low[1]), (high[0], high[1]), tuple(posts), start, path.end)
    distances = clearances(area, path.poses_at(np.linspace(0, path.length, 400)))[:, 1:].min(axis=0)
    near = tuple(post for post, distance in zip(posts, distances, strict=True) if 0.2 < distance < 0.5)
    area = replace(area, boxes=near)
    smooth = smooth_path(StateLattice(area, path.end), path)
    assert len(near) > 20 and smooth is not None
    assert len(smooth.steps) < len(path.steps) and smooth.length < path.length
    assert first_encounter(area, smooth, area.margin) is None
    np.testing.assert_allclose(smooth.end[:2], path.end[:2], atol=1e-7)


def test_a_blocked_straight_end_and_a_walled_goal_have_reasons() -> None:
    goal = np.array([8.0, 8.0, 0.0])
    area = empty_hall(goal, -0.8)
    post = FloorBox("post", (10.0, 8.0), (0.2, 0.2))
    with pytest.raises(NoPlanError, match=r"the straight end: not free: .* m from post"):
        plan_drive(replace(area, boxes=(post,)))
    fence = (FloorBox("left", (5.0, 6.0), (0.1, 12.0)),)
    with pytest.raises(NoPlanError, match="walls and boxes part start and goal"):
        plan_drive(replace(area, boxes=fence))


def test_plans_do_not_depend_on_earlier_ones() -> None:
    first, again = (plan_drive(random_area(102)) for _ in range(2))
    np.testing.assert_array_equal(first.path.steps, again.path.steps)
    np.testing.assert_array_equal(first.path.steering, again.path.steering)


def check_limits(drives: SimulatedDrives, truck: Tricycle) -> None:
    assert drives.speeds.max() <= truck.speed
    assert drives.accelerations.max() <= truck.acceleration + 1e-9
    assert drives.steering.max() <= truck.steering
    assert drives.steering_rates.max() <= truck.steering_rate + 1e-9
    assert drives.centripetal.max() <= truck.centripetal + 1e-9


def test_without_noise_drives_end_at_the_goal(plan: DrivePlan) -> None:
    drives = simulate_drives(plan, 1, 0, SILENT)
    check_limits(drives, plan.area.truck)
    assert drives.position_errors.max() < 0.002
    assert drives.yaw_errors.max() < 0.004
    assert drives.durations.max() < 1.1 * plan.profile.duration + 1.0


def test_with_noise_drives_end_within_what_is_asked_and_keep_limits(plan: DrivePlan) -> None:
    drives = simulate_drives(plan, 40, 7)
    check_limits(drives, plan.area.truck)
    assert drives.are_within.all()
    assert drives.position_errors.min() > 0
    assert drives.clearances.min() > 0
    np.testing.assert_array_equal(drives.position_errors, simulate_drives(plan, 40, 7).position_errors)
    assert (drives.position_errors != simulate_drives(plan, 40, 8).position_errors).all()


def test_drives_with_far_more_noise_do_not_count_as_within(plan: DrivePlan) -> None:
    drives = simulate_drives(plan, 20, 7, replace(DriveNoise(), position=0.2, yaw=0.1))
    assert not drives.are_within.all()
    check_limits(drives, plan.area.truck)


@pytest.mark.parametrize("phi", [-1.4, -0.5, 0.0, 0.9])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_small_errors_decay_at_the_same_rate_at_every_steering_angle(phi: float, sign: float) -> None:
    """Along a constant steering angle what is off across decays as (1 + s rate) exp(-s rate) of travel s."""
    truck = Tricycle()
    start = np.array([3.0, 3.0, 0.2])
    area = replace(empty_hall(start), truck=truck)
    path = SteeringPath(truck, start, np.array([sign * 4.0]), np.array([phi, phi]))
    plan = DrivePlan(area, None, path, speed_profile(path))  # type: ignore[arg-type]
    controller = TrackingController(plan, 1)
    controller.steering = np.array([phi])
    _, across, _ = (axis[0] for axis in tangents(start[2:], np.array([phi])))
    first = 1e-3
    pose = start + np.array([first * across[0], first * across[1], 0.0])
    for _ in range(20000):
        controller.control(pose[None])
        step = np.array([controller.signs[0] * controller.speed[0] * PERIOD])
        moved = truck.displacement(pose[2:], controller.steering, controller.steering, step)[0]
        turned = truck.yaw_change(controller.steering, controller.steering, step)[0]
        pose = pose + np.array([moved[0], moved[1], turned])
        controller.advance()
        if controller.travel[0] >= 2.0:
            break
    travel = controller.travel
    reference = path.poses_at(travel)[0]
    off = pose - reference
    off[2] *= truck.wheel_base
    left = [float(off @ axis[0]) for axis in tangents(reference[2:], np.array([phi]))[1:]]
    expected = first * (1 + RATE * travel[0]) * np.exp(-RATE * travel[0])
    assert left[0] == pytest.approx(expected, abs=0.05 * first)
    assert abs(left[1]) < 0.3 * first


def test_axes_of_errors_are_orthonormal_and_the_first_is_the_way_of_the_truck() -> None:
    rng, truck, tiny = np.random.default_rng(3), Tricycle(), 1e-6
    yaw, phi = rng.uniform(-3, 3, 50), rng.uniform(-1.5, 1.5, 50)
    axes = np.stack(tangents(yaw, phi), 1)
    products = axes @ np.swapaxes(axes, 1, 2)
    np.testing.assert_allclose(products, np.broadcast_to(np.eye(3), products.shape), atol=1e-12)
    step = np.full(50, tiny)
    moved = np.column_stack(
        [truck.displacement(yaw, phi, phi, step), truck.wheel_base * truck.yaw_change(phi, phi, step)]
    )
    np.testing.assert_allclose(moved / tiny, axes[:, 0], atol=1e-5)


def test_posed_and_seen_from_are_inverses() -> None:
    rng = np.random.default_rng(0)
    frame, local = rng.uniform(-3, 3, 3), rng.uniform(-3, 3, (20, 3))
    np.testing.assert_allclose(seen_from(frame, posed(frame, local)), local, atol=1e-12)
