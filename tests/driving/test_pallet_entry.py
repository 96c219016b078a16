"""Drives into a pallet: where they end, what they keep away from, and how they change on the way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_tracking import TrackingController
from pickcli.driving.driving_area import DrivingArea, FloorBox, StatedPallet
from pickcli.driving.forks import Forks
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import (
    entered_pose,
    entry_depth,
    pallet_gap,
    plan_entry,
    plan_exit,
    plan_in_area,
    renewed_entry,
)
from pickcli.driving.simulated_drives import DriveNoise, NoisyTruck
from pickcli.driving.simulated_entries import _Entry, entry_figures, simulate_entries
from pickcli.driving.steering_path import SteeringPath, posed, seen_from
from pickcli.driving.truck_camera import TruckCamera
from pickcli.errors import InputError, NoPlanError
from pickcli.perception.pallets.pallet_shape import EUR_FULL

CAMERA = TruckCamera(read_sensor(sensor_file("carmine")))
PALLET = StatedPallet(EUR_FULL, np.array([2.0, 3.5, 0.1]), 0.5, np.array([0.06, 0.06, 0.06]))
AREA = DrivingArea(
    (0.0, 0.0), (9.0, 7.0), (), np.array([6.8, 2.4, 0.3]), np.zeros(3), camera=CAMERA,
    pallet=PALLET, enters=True,
)  # fmt: skip


@pytest.fixture(scope="module")
def plan() -> DrivePlan:
    return plan_in_area(AREA)


def test_a_drive_ends_straight_with_the_forks_in_the_pockets(plan: DrivePlan) -> None:
    np.testing.assert_allclose(seen_from(entered_pose(AREA, PALLET), plan.path.end), 0.0, atol=1e-6)
    n = np.linspace(plan.path.length - 1.0, plan.path.length, 20)
    last = seen_from(PALLET.pose, plan.path.poses_at(n))
    np.testing.assert_allclose(last[:, 1:], 0.0, atol=1e-6)
    tips = last[-1, 0] - AREA.truck.back
    assert -EUR_FULL.length / 2 < tips < -EUR_FULL.length / 2 + 0.15
    heels = last[-1, 0] + AREA.forks.length - AREA.truck.back
    assert heels >= EUR_FULL.length / 2 + AREA.margin


def test_forks_that_do_not_fit_and_a_way_that_is_blocked_have_reasons() -> None:
    with pytest.raises(InputError, match=r"do not fit the pockets of a full pallet"):
        plan_entry(replace(AREA, forks=Forks(aside=0.25)), PALLET)
    with pytest.raises(InputError, match="high, do not fit"):
        plan_entry(replace(AREA, forks=Forks(height=0.12)), PALLET)
    post = FloorBox("post", (3.0, 3.6), (0.2, 0.2))
    with pytest.raises(NoPlanError, match="post"):
        plan_entry(replace(AREA, boxes=(post,)), PALLET)


def test_a_drive_to_a_goal_keeps_away_from_the_pallet() -> None:
    past = replace(AREA, goal=np.array([2.0, 5.8, 0.0]), enters=False)
    plan = plan_in_area(past)
    poses = plan.path.poses_at(np.linspace(0.0, plan.path.length, 200))
    assert PALLET.footprint.distance(poses[:, :2]).min() > AREA.truck.inner_radius


def test_a_changed_drive_goes_on_from_where_it_is_to_where_the_pallet_is_seen(plan: DrivePlan) -> None:
    seen = replace(PALLET, pose=posed(PALLET.pose, np.array([0.02, -0.04, 0.05])))
    changed = renewed_entry(plan, 1.0, seen)
    assert changed is not None
    before = np.linspace(0.0, 1.0, 30)
    np.testing.assert_allclose(changed.path.poses_at(before), plan.path.poses_at(before), atol=1e-9)
    np.testing.assert_allclose(changed.path.steering_at(before), plan.path.steering_at(before), atol=1e-9)
    np.testing.assert_allclose(seen_from(entered_pose(AREA, seen), changed.path.end), 0.0, atol=1e-6)
    assert renewed_entry(plan, plan.path.length - abs(plan.area.straight) - 0.1, seen) is None


def test_a_path_is_divided_anywhere(plan: DrivePlan) -> None:
    travel = np.linspace(0.0, plan.path.length, 50)
    for at in (0.3, float(plan.path.knots[2]), plan.path.length - 0.2):
        before, after = plan.path.divided(at)
        assert before.length == pytest.approx(at) and after.length == pytest.approx(plan.path.length - at)
        whole: SteeringPath = before.then(after)
        np.testing.assert_allclose(whole.poses_at(travel), plan.path.poses_at(travel), atol=1e-7)


@pytest.mark.slow
def test_drives_end_in_the_true_pallet_and_alike_each_time(plan: DrivePlan) -> None:
    one, again = (simulate_entries(AREA, plan, 2, 5) for _ in range(2))
    assert [each.off.tobytes() for each in one] == [each.off.tobytes() for each in again]
    assert all(each.is_within and each.n_seen for each in one)
    assert entry_figures(one)["within"] == 2


def test_a_truck_that_sees_no_pallet_stays_before_it(plan: DrivePlan) -> None:
    gone = replace(PALLET, is_there=False, off=np.array([0.01, 0.0, 0.0]))
    (entry,) = simulate_entries(replace(AREA, pallet=gone), plan, 1, 3)
    assert entry.has_given_up and not entry.is_within and entry.n_seen == 0
    assert entry_figures([entry])["given_up"] == 1


def test_a_drive_out_of_a_pallet_goes_straight_until_the_forks_are_out() -> None:
    inside = replace(AREA, start=entered_pose(AREA, PALLET), goal=np.array([7.0, 5.0, 0.5]), pallet=None)
    out = plan_exit(inside, PALLET)
    np.testing.assert_allclose(out.path.end, inside.goal, atol=1e-4)
    first = seen_from(PALLET.pose, out.path.poses_at(np.linspace(0.0, 1.4, 15)))
    np.testing.assert_allclose(first[:, 1:], 0.0, atol=1e-9)
    assert pallet_gap(inside, PALLET, out.path.poses_at(np.linspace(0.0, out.path.length, 200))) > 0.02
    past = replace(inside, boxes=(PALLET.footprint,))
    later = out.path.poses_at(np.linspace(1.5, out.path.length, 200))
    assert clearances(past, later).min() >= AREA.margin - 1e-3


def test_where_a_lattice_has_no_way_on_from_a_place_one_a_little_farther_is_tried(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A booth, and a pose in a pallet, straight out of which the lattice reaches 24 states only."""
    load = FloorBox("load", (3.05, 2.62), (0.6, 0.4))
    start, goal = np.array([0.663, 1.8972, 0.0022]), np.array([3.2, 1.0, 0.0])
    booth = DrivingArea((0.0, 0.0), (5.0, 3.0), (load,), start, goal, margin=0.05)
    pallet = StatedPallet(EUR_FULL, posed(start, np.array([0.19, 0.0, 0.0])), 0.0, np.zeros(3))
    assert plan_exit(booth, pallet).path.length > 2.0
    monkeypatch.setattr("pickcli.driving.pallet_entry.FARTHER", (0.0,))
    with pytest.raises(NoPlanError, match="24 states reached"):
        plan_exit(booth, pallet)


@pytest.mark.parametrize(("aside", "before", "astray"), [
    (0.0, 0.1, False), (0.02, 0.07, False), (0.09, 0.07, True), (-0.09, 0.07, True),
    (0.09, 0.5, False),  # it may come onto its path until then
    (0.09, -0.05, False),  # too late to brake
])  # fmt: skip
def test_a_truck_whose_forks_would_miss_the_pockets_brakes_right_before_them(
    plan: DrivePlan, aside: float, before: float, astray: bool
) -> None:
    truck = NoisyTruck(AREA.truck, AREA.start, DriveNoise(), 1, np.random.default_rng(0))
    entry = _Entry(AREA, CAMERA, plan, PALLET, truck)
    left = before + entry_depth(AREA, PALLET)
    at = posed(entered_pose(AREA, PALLET), np.array([left, aside, 0.0]))
    truck.believed[0] = at
    controller = TrackingController(plan, 1)
    controller.speed[0], controller.travel[0] = 0.2, plan.path.length - left
    assert not entry._goes_astray(controller, truck)  # nothing was seen yet
    entry.seen = PALLET
    assert entry._goes_astray(controller, truck) is astray


def test_a_drive_out_that_is_blocked_has_a_reason() -> None:
    wall = FloorBox("rack", tuple(posed(PALLET.pose, np.array([2.6, 0.0, 0.0]))[:2].tolist()), (0.2, 1.0))
    inside = replace(
        AREA, start=entered_pose(AREA, PALLET), goal=np.array([7.0, 5.0, 0.5]), pallet=None, boxes=(wall,)
    )
    with pytest.raises(NoPlanError, match="a drive out of the pallet"):
        plan_exit(inside, PALLET)


@pytest.mark.parametrize(
    ("aside", "gap"), [(0.0, 0.0825), (0.05, 0.0325), (-0.05, 0.0325), (0.0825, 0.0), (0.1, -0.0175)]
)
def test_the_gap_of_forks_in_pockets_is_that_of_their_widths(aside: float, gap: float) -> None:
    """Pockets are 72.5 to 300 mm from the middle, forks 155 to 255: 82.5 mm inside of them, 45 outside."""
    at = posed(entered_pose(AREA, PALLET), np.array([0.0, aside, 0.0]))
    inner, outer = 0.155 - 0.0725 - abs(aside), 0.3 - 0.255 - abs(aside)
    assert pallet_gap(AREA, PALLET, at[None]) == pytest.approx(
        min(inner, outer, AREA.margin + 0.01), abs=1e-6
    )
    assert inner == pytest.approx(gap)


def test_a_body_that_meets_the_pallet_has_no_gap() -> None:
    at = posed(entered_pose(AREA, PALLET), np.array([-0.08, 0.0, 0.0]))
    assert pallet_gap(AREA, PALLET, at[None]) <= 0.0
    away = posed(entered_pose(AREA, PALLET), np.array([2.0, 0.0, 0.0]))
    assert pallet_gap(AREA, PALLET, away[None]) > 1.0
