"""One speed for all: the filter against least squares over all measurements, and its own errors."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.conveyor import Conveyor
from pickcli.perception.tracking.belt_filter import BeltFilter
from pickcli.seeds import derived_rng

RESOLUTION, MAX_SPEED, SIGMA = 1e-4, 0.5, 0.005


def figures(resolution: float = RESOLUTION) -> Conveyor:
    return Conveyor(3.0, 0.4, 0.33, MAX_SPEED, 0.5, (1.2, 2.85), resolution, 0.004)


@given(st.integers(0, 10_000), st.integers(1, 4))
@settings(max_examples=40, deadline=None)
def test_at_steady_speed_it_is_least_squares_over_all_measurements(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    speed, starts = rng.uniform(0.05, 0.5), rng.uniform(0.0, 1.0, n)
    belt = BeltFilter(0.0, 0.0, figures(), 0.0)
    # rows of (speed, travel at 0, places at 0), each over the deviation of its measurement
    rows = [np.eye(2 + n)[0] / MAX_SPEED, np.eye(2 + n)[1] * np.sqrt(12.0) / RESOLUTION]
    values = [0.0, 0.0]
    for k, start in enumerate(starts):
        belt.add(start, 0.02)
        rows.append(np.eye(2 + n)[2 + k] / 0.02)
        values.append(start / 0.02)
    for t in np.cumsum(rng.uniform(0.01, 0.3, 12)).tolist():
        which = int(rng.integers(-1, n))
        row = np.eye(2 + n)[2 + which if which >= 0 else 1]
        row[0] = t
        deviation = SIGMA if which >= 0 else RESOLUTION / np.sqrt(12.0)
        true = speed * t + (starts[which] if which >= 0 else 0.0)
        if which >= 0:
            value = true + rng.normal(0.0, SIGMA)
            belt.advance(t)
            belt.see(which, value, SIGMA)
        else:
            value = true + rng.uniform(-0.5, 0.5) * RESOLUTION
            belt.read_encoder(t, value)
        rows.append(row / deviation)
        values.append(value / deviation)
    A = np.array(rows)
    best = np.linalg.lstsq(A, np.array(values), rcond=None)[0]
    spread = np.linalg.inv(A.T @ A)
    assert belt.speed == pytest.approx((best[0], np.sqrt(spread[0, 0])), rel=1e-6, abs=1e-9)
    for k in range(n):
        row = np.eye(2 + n)[2 + k]
        row[0] = belt.t
        assert belt.place(k) == pytest.approx((row @ best, np.sqrt(row @ spread @ row)), rel=1e-6, abs=1e-9)


def test_a_new_item_is_as_fast_as_those_before_it() -> None:
    belt = BeltFilter(0.0, 0.0, figures(0.1))  # an encoder that is too coarse to tell the speed
    belt.add(0.0, SIGMA)
    for t in np.arange(0.1, 3.0, 0.1).tolist():
        belt.advance(t)
        belt.see(0, 0.33 * t, SIGMA)
    belt.add(0.2, SIGMA)
    seen_at = belt.t
    belt.advance(seen_at + 1.0)
    place, deviation = belt.place(1)
    assert place == pytest.approx(0.2 + 0.33, abs=2e-3) and deviation < 1.3 * SIGMA


def test_its_deviations_are_those_of_its_errors_on_a_belt_that_changes_its_speed() -> None:
    density, dt, errors = 0.04, 0.1, []
    for seed in range(200):
        rng = derived_rng("belt", seed)
        speed, travel, start = rng.uniform(0.1, 0.4), 0.0, rng.uniform(0.0, 0.5)
        belt = BeltFilter(0.0, 0.0, figures(), density)
        belt.add(start + rng.normal(0.0, SIGMA), SIGMA)
        for k in range(1, 15):
            # exact integrals of white acceleration over the step
            gain = np.linalg.cholesky(density * np.array([[dt, dt**2 / 2], [dt**2 / 2, dt**3 / 3]]))
            more = gain @ rng.standard_normal(2)
            travel, speed = travel + speed * dt + more[1], speed + more[0]
            belt.read_encoder(k * dt, np.round(travel / RESOLUTION) * RESOLUTION)
            belt.see(0, start + travel + rng.normal(0.0, SIGMA), SIGMA)
        place, deviation = belt.place(0)
        estimate, off = belt.speed
        errors.append([(place - start - travel) / deviation, (estimate - speed) / off])
    # chi-square of 200 squares: 99.9 % lie in 0.71 to 1.36
    assert ((np.mean(np.square(errors), axis=0) > 0.71) & (np.mean(np.square(errors), axis=0) < 1.36)).all()


def test_an_item_that_is_removed_leaves_the_others_as_they_are() -> None:
    belt = BeltFilter(0.0, 0.0, figures())
    for place in (0.1, 0.4, 0.9):
        belt.add(place, SIGMA)
    belt.advance(0.5)
    belt.see(1, 0.5, SIGMA)
    before, copied = [belt.place(0), belt.place(2)], belt.copy()
    belt.remove(1)
    assert [belt.place(0), belt.place(1)] == before
    assert copied.place(2) == before[1]  # a copy is not changed


@pytest.mark.parametrize("acceleration", [-0.5, -0.2, 0.1, 0.5])
def test_a_belt_that_changes_its_speed_is_followed_and_one_that_does_not_is_known_well(
    acceleration: float,
) -> None:
    belt, speed, travel, dt = BeltFilter(0.0, 0.0, figures(1e-5)), 0.25, 0.0, 0.1
    belt.add(0.5, 1e-4)
    for k in range(1, 60):
        change = acceleration if 20 < k <= 24 else 0.0
        travel, speed = travel + speed * dt + change * dt**2 / 2, speed + change * dt
        belt.read_encoder(k * dt, np.round(travel / 1e-5) * 1e-5)
        place, deviation = belt.place(0)
        assert abs(place - 0.5 - travel) <= 4.0 * deviation
        estimate, off = belt.speed
        assert abs(estimate - speed) <= 4.0 * off
    assert off < 4e-4 and deviation < 2e-4
