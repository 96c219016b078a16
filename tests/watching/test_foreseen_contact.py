"""Whether a stop would do, for people at known places and speeds."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.driving.tricycle import Tricycle
from pickcli.watching.foreseen_contact import nearest_while_stopping, outline_distance, stopping_poses
from pickcli.watching.stopping_distance import stopping_distance

TRUCK, REST = Tricycle(), np.zeros(2)


def nearest(speed: float, place: tuple[float, float], velocity: np.ndarray = REST) -> float:
    stopping = stopping_poses(TRUCK, np.zeros(3), (speed, 0.0), 0.2)
    return nearest_while_stopping(TRUCK, stopping, np.array(place), velocity)


def test_outline_distance_of_known_places() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, np.pi / 2], [0.0, 0.0, 0.0]])
    places = np.array([[2.6, 0.0], [0.5, 1.4], [1.0, 3.6], [1.0, 0.1]])
    np.testing.assert_allclose(outline_distance(TRUCK, poses, places), [1.0, 1.0, 1.0, 0.0], atol=1e-12)


def test_someone_who_stands_ahead_is_as_near_as_the_stopping_distance_leaves() -> None:
    stopping = stopping_distance(1.0, 0.2, TRUCK.acceleration)
    assert nearest(1.0, (TRUCK.front + 1.5, 0.0)) == pytest.approx(1.5 - stopping)
    assert nearest(0.0, (TRUCK.front + 1.5, 0.0)) == pytest.approx(1.5)


def test_someone_who_walks_by_ahead_meets_the_truck_or_not() -> None:
    """From 2 m beside: with 0.5 m/s the truck rests first, with 2 m/s the person is before it by then."""
    beside = (TRUCK.front + 0.3, -2.0)
    assert nearest(1.0, beside, np.array([0.0, 0.5])) > 0.5
    assert nearest(1.0, beside, np.array([0.0, 2.0])) == 0.0
    assert nearest(1.0, beside, np.array([0.0, -2.0])) > 1.5


def test_stopping_poses_turn_with_the_steering_and_end_at_rest() -> None:
    times, poses = stopping_poses(TRUCK, np.array([1.0, 2.0, 0.5]), (0.8, 0.6), 0.1)
    assert times[-1] == pytest.approx(0.1 + 0.8 / TRUCK.acceleration)
    turn = stopping_distance(0.8, 0.1, TRUCK.acceleration) * np.sin(0.6) / TRUCK.wheel_base
    assert poses[-1, 2] - poses[0, 2] == pytest.approx(turn)
    np.testing.assert_allclose(poses[0], [1.0, 2.0, 0.5])


def test_backwards_a_truck_rests_behind_where_it_was() -> None:
    _, forwards = stopping_poses(TRUCK, np.zeros(3), (0.8, 0.6), 0.1)
    _, backwards = stopping_poses(TRUCK, np.zeros(3), (-0.8, 0.6), 0.1)
    np.testing.assert_allclose(backwards[:, 0], -forwards[:, 0], atol=1e-9)
    np.testing.assert_allclose(backwards[:, 2], -forwards[:, 2], atol=1e-9)
