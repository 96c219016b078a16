"""The force that is felt, against a mass that is pushed by a known one."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.hand.force_observer import GAIN, ForceObserver

MASS, DT = 4.0, 2e-3  # kg, s


def felt(push: Array, commanded: Array, seconds: float) -> Array:
    """What a mass at rest feels after a time (s) under a push from outside and the motors' force (N)."""
    observer, velocity = ForceObserver(3), np.zeros(3)
    for _ in range(round(seconds / DT) + 1):
        observer.advance(MASS * velocity, commanded, DT)
        velocity = velocity + (push + commanded) / MASS * DT
    return observer.force


def test_a_push_is_felt_in_size_and_direction() -> None:
    push = np.array([1.0, -2.0, 0.5])
    assert felt(push, np.zeros(3), 0.2) == pytest.approx(push, rel=1e-3)


def test_the_estimate_follows_with_its_time_constant() -> None:
    push = np.array([1.0, 0.0, 0.0])
    assert felt(push, np.zeros(3), 1.0 / GAIN)[0] == pytest.approx(1.0 - np.exp(-1.0), abs=0.05)


def test_what_the_motors_do_is_not_felt() -> None:
    assert felt(np.zeros(3), np.array([3.0, 1.0, -2.0]), 0.3) == pytest.approx(np.zeros(3), abs=1e-9)
    push = np.array([0.0, 1.0, 0.0])
    assert felt(push, np.array([3.0, 1.0, -2.0]), 0.2) == pytest.approx(push, abs=1e-3)
