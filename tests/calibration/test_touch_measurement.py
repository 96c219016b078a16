"""Where a contact began, by recorded joints and forces: known contacts, noise, lag, and wrong stiffness."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_measurement import STIFFNESS_ERROR, EncoderNoise, TouchReading
from pickcli.calibration.touch_points import TouchPoint, touch_points
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.simulation.guarded_move import GuardedMove

STRAIGHT = ToolState("straight")
STEP, SPEED, STIFFNESS = 1e-3, 0.02, 1000.0
EXACT = EncoderNoise(0.0, 0.0)
CONTACT = 0.014  # m along the line


@cache
def cell() -> Cell:
    return load_cell("apc2016_delft")


@cache
def arm() -> Arm:
    return Arm(cell().robot)


@cache
def line() -> Array:
    """Joints (K, n) of 18 mm along the tool's axis, a step of time apart; the tote's configuration first."""
    q = np.asarray(cell().configurations["tote"].q)
    tip = arm().tip(q, STRAIGHT)
    ways = np.arange(0.0, 0.018, SPEED * STEP)
    poses = np.repeat(tip[None], len(ways), axis=0)
    poses[:, :3, 3] += ways[:, None] * tip[:3, 2]
    found = arm().follow(poses, STRAIGHT, q)
    assert found.reason is None
    return np.asarray(found.configurations)


def record(lag: float = 0.0, noise: float = 0.0, stiffness: float = STIFFNESS, seed: int = 0) -> GuardedMove:
    ways = np.arange(len(line())) * SPEED * STEP
    forces = stiffness * np.maximum(ways - CONTACT - lag * SPEED, 0.0)
    forces += np.random.default_rng(seed).normal(0.0, noise, len(forces)) if noise else 0.0
    return GuardedMove(None, line(), forces, noise, lag, 0.0, 0.0)


def aim() -> TouchPoint:
    return touch_points(tote_shape(cell()), 6, 0.015)[-1]


def off(move: GuardedMove, encoders: EncoderNoise = EXACT, seed: int = 0) -> tuple[float, float, float]:
    """Way in m by which the contact is measured too late, with its deviation and bias."""
    reading = TouchReading(arm(), STIFFNESS, STEP, encoders)
    found = reading.touched_point(aim(), move, STRAIGHT, np.random.default_rng(seed))
    first = arm().tip(line()[0], STRAIGHT)
    return float((found.point - first[:3, 3]) @ first[:3, 2]) - CONTACT, found.deviation, found.bias


def test_a_contact_without_noise_is_found_where_it_was() -> None:
    assert off(record())[0] == pytest.approx(0.0, abs=3e-6)


@pytest.mark.parametrize("lag", [0.004, 0.012, 0.03])
def test_the_age_of_the_forces_is_allowed_for(lag: float) -> None:
    assert off(record(lag))[0] == pytest.approx(0.0, abs=3e-6)
    assert off(record(lag))[0] < 0.1 * lag * SPEED


def test_bellows_of_another_stiffness_are_within_the_bias() -> None:
    for stiffness in (STIFFNESS * (1 - STIFFNESS_ERROR), STIFFNESS * (1 + STIFFNESS_ERROR)):
        error, _, bias = off(record(stiffness=stiffness))
        assert 0.3 * bias < abs(error) <= bias


@pytest.mark.parametrize("noise", [0.2, 1.0])
def test_the_stated_deviation_bounds_that_of_many_records(noise: float) -> None:
    """White noise here: the deviation is stated for forces that are alike over the time of their filter."""
    errors = [off(record(noise=noise, seed=k)) for k in range(60)]
    spread = float(np.std([error for error, *_ in errors]))
    assert 0.1 * errors[0][1] < spread < errors[0][1]


def test_errors_of_the_joints_are_in_the_deviation() -> None:
    encoders = EncoderNoise()
    errors = [off(record(), encoders, seed) for seed in range(200)]
    assert float(np.std([error for error, *_ in errors])) == pytest.approx(errors[0][1], rel=0.2)
    assert errors[0][1] > 2 * off(record())[1]


def test_rails_and_turning_joints_have_their_own_errors() -> None:
    most = EncoderNoise(turning=1e-3, sliding=2e-4).of(arm())
    assert most[arm().names.index("rail")] == 2e-4 and (most[1:] == 1e-3).all()
