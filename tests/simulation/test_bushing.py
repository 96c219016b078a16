"""The law by which a weight that a compliant cup takes up is overshot (docs/simulation.md)."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.geometry import GRAVITY, pose
from pickcli.simulation.bushing import Bushing, Stiffness

MASS, STEP = 0.5, 5e-5  # kg, s
SAG = MASS * GRAVITY / Stiffness().axial
RATE = float(np.sqrt(Stiffness().axial / MASS))  # rad/s


def peak(speed: float, relaxation: float) -> float:
    """Largest force over the weight when the cup goes up at a speed; until the item is free, it stands."""
    bushing = Bushing(Stiffness(relaxation=relaxation), MASS, 1e-3 * np.eye(3), np.zeros(3), STEP)
    height, v, most = 0.0, 0.0, 0.0
    for t in np.arange(0.0, SAG / speed + 10.0 / RATE, STEP):
        velocity = np.array([0.0, 0.0, v - speed, 0.0, 0.0, 0.0])
        gravity = np.array([0.0, 0.0, -GRAVITY if height > 0.0 else 0.0])
        force = bushing.wrench(pose([0.0, 0.0, height]), pose([0.0, 0.0, speed * t]), velocity, gravity)[2]
        v += STEP * (force / MASS - GRAVITY)
        v = v if height > 0.0 or v > 0.0 else 0.0
        height += STEP * v
        most = max(most, force)
    return most / (MASS * GRAVITY)


@pytest.mark.parametrize("speed", [0.004, 0.01, 0.03])
@pytest.mark.parametrize("relaxation", [2e-4, 3e-3])
def test_a_weight_that_is_taken_up_in_a_time_is_overshot_as_by_a_ramp(
    speed: float, relaxation: float
) -> None:
    damping = RATE * relaxation / 2.0
    undamped = speed / (RATE * SAG)  # 1 / (rate * duration)
    damped = undamped * np.exp(-damping / np.sqrt(1 - damping**2) * np.arccos(damping))
    assert peak(speed, relaxation) - 1.0 == pytest.approx(damped, rel=0.08)
    assert peak(speed, relaxation) - 1.0 < undamped


def test_a_cup_of_another_size_is_as_strained_by_loads_that_its_vacuum_bears_alike() -> None:
    """Twice as large, it bears 4 times the force and 8 times the moment, at the same angle and strain."""
    known, twice = Stiffness(), Stiffness.of_cup(0.03)
    assert Stiffness.of_cup(0.015) == known
    assert 4.0 / twice.axial == pytest.approx(2.0 / known.axial)  # displacement over size
    assert 4.0 / twice.lateral == pytest.approx(2.0 / known.lateral)
    assert 8.0 / twice.tilt == pytest.approx(1.0 / known.tilt)
    assert 8.0 / twice.twist == pytest.approx(1.0 / known.twist)
    assert twice.relaxation == known.relaxation
