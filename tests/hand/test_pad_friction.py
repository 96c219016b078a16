"""Friction of belts: elastic below the limit, the limit beyond it, in all three directions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.hand.pad_friction import LEAST_RADIUS, BeltDrive, PadFriction
from support.belt_hands import HAND

BELTS, DT = HAND.belts, 2e-3


def dragged(friction: PadFriction, rates: Array, normal_force: float, radius: float, steps: int) -> Array:
    """The load after some steps at constant rates."""
    load = np.zeros(3)
    for _ in range(steps):
        load = friction.load(rates, normal_force, radius, DT)
    return load


def test_it_is_a_spring_until_it_slips_at_the_friction_limit() -> None:
    friction, limit = PadFriction(BELTS, 0.5), 0.5 * 8.0
    speed = 1e-3
    onset = limit / BELTS.stiffness / speed  # s until the spring bears the limit
    before = dragged(friction, np.array([speed, 0.0, 0.0]), 8.0, 0.0, round(0.9 * onset / DT))
    assert not friction.is_sliding
    assert before[0] == pytest.approx(-(0.9 * limit + BELTS.damping * speed), rel=2e-3)
    after = dragged(friction, np.array([speed, 0.0, 0.0]), 8.0, 0.0, round(0.2 * onset / DT))
    assert friction.is_sliding
    assert after == pytest.approx([-limit, 0.0, 0.0])


def test_at_rest_it_goes_on_bearing_its_load_without_creep() -> None:
    friction = PadFriction(BELTS, 0.5)
    dragged(friction, np.array([0.0, 1e-3, 0.0]), 8.0, 0.0, 200)
    held = dragged(friction, np.zeros(3), 8.0, 0.0, 1)
    assert dragged(friction, np.zeros(3), 8.0, 0.0, 5000) == pytest.approx(held)
    assert held[1] == pytest.approx(-4e-4 * BELTS.stiffness)


@given(
    rates=st.tuples(*[st.floats(-0.5, 0.5)] * 2, st.floats(-20.0, 20.0)),
    normal_force=st.floats(0.0, 100.0),
    radius=st.floats(0.0, 0.03),
)
def test_no_load_is_outside_of_the_limit_surface(
    rates: tuple[float, float, float], normal_force: float, radius: float
) -> None:
    load = dragged(PadFriction(BELTS, 0.7), np.array(rates), normal_force, radius, 20)
    scaled = load / [1.0, 1.0, max(radius, LEAST_RADIUS)]
    assert np.linalg.norm(scaled) <= 0.7 * normal_force * (1 + 1e-9)
    assert float(load @ np.array(rates)) <= 1e-12  # it never drives


def test_a_belt_runs_at_its_speed_and_blocks_at_its_force() -> None:
    drive = BeltDrive(BELTS, wanted=BELTS.speed)
    for _ in range(100):
        drive.advance(0.8 * BELTS.force, DT)
    assert drive.speed == pytest.approx(BELTS.speed)
    assert drive.force == pytest.approx(0.8 * BELTS.force)
    for _ in range(10):
        drive.advance(1.2 * BELTS.force, DT)
    assert drive.force == BELTS.force
    assert drive.speed == pytest.approx(BELTS.speed - 0.2 * BELTS.force / BELTS.mass * 10 * DT)
