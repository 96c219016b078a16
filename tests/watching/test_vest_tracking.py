"""Tracks of people whose ways are known, and of what is seen once."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.watching.vest_detection import Vest
from pickcli.watching.vest_tracking import CONFIRMED, VestTrack, VestTracker
from support.watched import watch

PAIR = watch().pair
REST = np.zeros(3)


def vest(x: float, y: float, sigma: float = 0.05) -> Vest:
    return Vest(np.array([x, y, 1.1]), sigma**2 * np.eye(2), (0.3, 0.4), 0.8, 0.95)


def tracked(n: int, velocity: tuple[float, float], pose: np.ndarray = REST, seed: int = 0) -> VestTracker:
    """Follow someone from (6, -1) on, as a truck in a pose sees it, for n sets of pictures."""
    tracker, rng = VestTracker(PAIR), np.random.default_rng(seed)
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for k in range(n):
        time = k * PAIR.period
        x, y = np.array([6.0, -1.0]) + time * np.array(velocity) + 0.05 * rng.standard_normal(2) - pose[:2]
        tracker.take(time, pose, [vest(c * x + s * y, c * y - s * x)])
    return tracker


@pytest.mark.parametrize("pose", [REST, np.array([-1.0, 0.5, 0.3])], ids=["at the origin", "turned"])
def test_a_walk_is_followed_with_its_velocity(pose: np.ndarray) -> None:
    (track,) = tracked(40, (-0.5, 1.4), pose).tracks
    end = np.array([6.0, -1.0]) + 39 * PAIR.period * np.array([-0.5, 1.4])
    np.testing.assert_allclose(track.mean[:2], end, atol=0.12)
    np.testing.assert_allclose(track.mean[2:], [-0.5, 1.4], atol=0.35)
    assert track.n_found == 40 and track.is_confirmed


def test_estimates_are_as_uncertain_as_they_say() -> None:
    """Squared statistical distances of 60 tracks have the mean of two degrees of freedom, or less."""
    end, distances = np.array([6.0, -1.0]) + 1.45 * np.array([0.8, 0.6]), []
    for seed in range(60):
        (track,) = tracked(30, (0.8, 0.6), seed=seed).tracks
        off = track.mean[:2] - end
        distances.append(off @ np.linalg.solve(track.covariance[:2, :2], off))
    assert 1.0 < np.mean(distances) < 2.7


def test_a_track_is_confirmed_by_the_second_set_of_pictures() -> None:
    once, twice = tracked(1, (0.0, 0.0)), tracked(2, (0.0, 0.0))
    assert once.tracks[0].probability < CONFIRMED and once.tracks[0].confirmed_time is None
    assert twice.tracks[0].confirmed_time == PAIR.period


def test_what_is_not_seen_again_is_dropped_and_what_is_out_of_sight_is_kept_longer() -> None:
    seen, n = tracked(1, (0.0, 0.0)), 0
    while seen.tracks:
        n += 1
        seen.take(n * PAIR.period, REST, [])
    away = tracked(10, (0.0, 0.0))
    behind = np.array([12.0, 0.0, 0.0])  # the place is behind the cameras now
    for k in range(n):
        away.take((10 + k) * PAIR.period, behind, [])
    assert 0 < n <= 4 and len(away.tracks) == 1


def test_detections_go_to_the_nearest_tracks() -> None:
    tracker = VestTracker(PAIR)
    for k in range(6):
        tracker.take(k * PAIR.period, REST, [vest(6.0, -1.0), vest(6.0, 1.0)][:: (-1) ** k])
    assert tracker.n_tracks == 2
    assert sorted(round(float(track.mean[1])) for track in tracker.tracks) == [-1, 1]


def test_predicted_grows_as_random_accelerations_do() -> None:
    track = VestTrack(1, 0.0, np.array([1.0, 2.0, 0.5, -0.5]), np.zeros((4, 4)))
    mean, covariance = track.predicted(2.0)
    np.testing.assert_allclose(mean, [2.0, 1.0, 0.5, -0.5])
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), [3.0, 3.0, 3.0, 3.0])
