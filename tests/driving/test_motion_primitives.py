"""Primitives obey the kinematics, by an integrator of their own, and end exactly on the lattice."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from pickcli.driving.motion_primitives import (
    CELL,
    N_HEADINGS,
    STEEPEST,
    TURNS,
    HeadingPrimitives,
    heading_angle,
    motion_primitives,
)
from pickcli.driving.steering_path import SteeringPath
from pickcli.driving.tricycle import Tricycle
from pickcli.errors import InputError
from pickcli.geometry import Array

TRUCK = Tricycle()


@pytest.fixture(scope="module")
def primitives() -> tuple[HeadingPrimitives, ...]:
    return motion_primitives(TRUCK)


def integrated(path: SteeringPath, travel: float) -> Array:
    """(3,) pose by Runge and Kutta's method, on the equations of a tricycle as textbooks have them."""

    def slope(s: float, pose: Array) -> Array:
        phi = float(np.interp(s, path.knots, path.steering))
        k = min(int(np.searchsorted(path.knots, s, side="right")) - 1, len(path.steps) - 1)
        axle = np.cos(phi) * np.sign(path.steps[k])
        curvature = np.tan(phi) / path.truck.wheel_base
        return np.array([axle * np.cos(pose[2]), axle * np.sin(pose[2]), axle * curvature])

    pose = path.start
    knots = [*path.knots[path.knots < travel].tolist(), travel]
    for begin, end in pairwise(knots):
        pose = solve_ivp(slope, (begin + 1e-12, end - 1e-12), pose, rtol=1e-10, atol=1e-11).y[:, -1]
    return pose


def test_every_heading_has_primitives_of_each_turn(primitives: tuple[HeadingPrimitives, ...]) -> None:
    assert len(primitives) == N_HEADINGS
    for of in primitives:
        assert set(of.turns.tolist()) == set(TURNS)


def test_a_truck_that_hardly_turns_is_refused() -> None:
    with pytest.raises(InputError, match=r"too wide curves .* 1.19 m and 0.3 rad"):
        motion_primitives(Tricycle(steering=0.3))
    assert len(motion_primitives(Tricycle(steering=0.6))) == N_HEADINGS


@pytest.mark.parametrize("heading", range(0, N_HEADINGS, 3))
def test_primitives_end_on_the_lattice(primitives: tuple[HeadingPrimitives, ...], heading: int) -> None:
    of = primitives[heading]
    start = np.array([0.0, 0.0, heading_angle(heading)])
    for k in range(len(of.turns)):
        travel, steering = of.drives.travel[k], of.drives.steering[k]
        path = SteeringPath(TRUCK, start, np.full(3, travel / 3), steering)
        end = np.array([*(CELL * of.cells[k]), heading_angle(heading + of.turns[k])])
        np.testing.assert_allclose(path.end, end, atol=1e-9)
        np.testing.assert_allclose(integrated(path, float(travel)), end, atol=1e-7)
        assert np.abs(steering).max() <= TRUCK.planned_steering
        assert np.abs(np.diff(steering)).max() <= STEEPEST * travel / 3 + 1e-12


def test_a_path_obeys_the_kinematics_between_its_knots_and_backwards() -> None:
    rng = np.random.default_rng(4)
    steps = np.array([0.4, 0.7, -0.5, -0.9, 0.3])
    path = SteeringPath(TRUCK, np.array([1.0, -2.0, 0.4]), steps, rng.uniform(-1.4, 1.4, 6))
    travel = np.linspace(0.05, path.length, 9)
    expected = np.array([integrated(path, float(s)) for s in travel])
    np.testing.assert_allclose(path.poses_at(travel), expected, atol=1e-7)
    assert path.cusps.tolist() == [2, 4]


def test_no_point_of_the_truck_moves_farther_than_its_sweep() -> None:
    rng = np.random.default_rng(1)
    points = rng.uniform([-TRUCK.back, -TRUCK.width / 2], [TRUCK.front, TRUCK.width / 2], (4000, 2))
    points = np.concatenate([points, TRUCK.corners])
    phi, tiny = np.linspace(-np.pi / 2, np.pi / 2, 181)[:, None], 1e-7
    turn = tiny * np.sin(phi) / TRUCK.wheel_base
    moved_x = tiny * np.cos(phi) + points[:, 0] * (np.cos(turn) - 1) - points[:, 1] * np.sin(turn)
    moved_y = points[:, 0] * np.sin(turn) + points[:, 1] * (np.cos(turn) - 1)
    rates = np.hypot(moved_x, moved_y) / tiny
    assert (rates.max(axis=0) <= TRUCK.sweeps(points) + 1e-5).all()
    assert rates.max() == pytest.approx(TRUCK.sweep, rel=1e-3)  # and no smaller bound would do
