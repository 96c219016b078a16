"""Bounds of where a wrist can be, against forward kinematics of random configurations."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.wrist_reach import VOXEL, WristCentre, WristReach
from support.pr2_picks import context

# A part of the belt of pr2_belt that the left arm reaches partly: in its frame, m.
LOWER, UPPER = np.array([1.2, -0.2, 0.15]), np.array([1.7, 0.2, 0.45])


def wrists(arm: Arm, wrist: WristCentre, T_world_frame: Array, Q: Array) -> Array:
    """Centres (N, 3) of the wrist in a frame, by forward kinematics of the whole arm."""
    tips = arm.tips(Q, arm.robot.tool.default_state)
    world = tips[:, :3, :3] @ wrist.in_tip + tips[:, :3, 3]
    return np.asarray((world - T_world_frame[:3, 3]) @ T_world_frame[:3, :3])


@pytest.fixture(scope="module")
def reach() -> WristReach:
    arm, state = context().arm, context().cell.robot.tool.default_state
    wrist = WristCentre.of(arm, state)
    assert wrist is not None
    return WristReach.within(arm, state, wrist, belt(), LOWER, UPPER)


def belt() -> Array:
    return next(
        each.T_world_carrier for each in context().cell.carriers.values() if each.conveyor is not None
    )


def test_the_wrist_does_not_depend_on_the_joints_behind_it() -> None:
    arm, rng = context().arm, np.random.default_rng(3)
    wrist = WristCentre.of(arm, context().cell.robot.tool.default_state)
    assert wrist is not None and wrist.n_before == 4
    Q = rng.uniform(*arm.window, (20, 7))
    Q[:, :4] = Q[0, :4]
    assert np.ptp(wrists(arm, wrist, np.eye(4), Q), axis=0).max() < 1e-9
    assert np.linalg.norm(wrist.in_tip) == pytest.approx(0.18)  # as the cell's T_hand_tip has it


def test_no_configuration_has_its_wrist_elsewhere(reach: WristReach) -> None:
    arm = context().arm
    wrist = WristCentre.of(arm, context().cell.robot.tool.default_state)
    assert wrist is not None
    Q = np.random.default_rng(4).uniform(*arm.window, (150_000, 7))
    at = wrists(arm, wrist, belt(), Q)
    at = at[((at > LOWER) & (at < UPPER)).all(axis=1)]
    assert len(at) > 3000 and reach.may_be_in(at, at).all()


def test_most_of_what_is_said_to_be_reached_is(reach: WristReach) -> None:
    """Or else a table that says so of everything would pass."""
    arm = context().arm
    wrist = WristCentre.of(arm, context().cell.robot.tool.default_state)
    assert wrist is not None
    Q = np.random.default_rng(5).uniform(*arm.window, (400_000, 7))
    k = np.floor((wrists(arm, wrist, belt(), Q) - LOWER) / VOXEL).astype(int)
    k = k[((k >= 0) & (k < reach.occupied.shape)).all(axis=1)]
    n_reached = len(np.unique(k, axis=0))
    assert n_reached > 0.6 * reach.occupied.sum() and reach.occupied.mean() < 0.7


def test_boxes_are_counted_as_by_a_loop(reach: WristReach) -> None:
    rng = np.random.default_rng(6)
    low = rng.uniform(LOWER - 0.1, UPPER, (200, 3))
    high = low + rng.uniform(0.0, 0.1, (200, 3))
    middles = LOWER + VOXEL * (np.argwhere(reach.occupied) + 0.5)
    for a, b, told in zip(low, high, reach.may_be_in(low, high), strict=True):
        meets = (np.abs(middles - (a + b) / 2) <= (b - a) / 2 + VOXEL / 2).all(axis=1)
        assert told == meets.any()


def test_an_arm_with_more_joints_before_its_wrist_has_none() -> None:
    cell = load_cell("apc2016_delft")
    assert WristCentre.of(Arm(cell.robot), cell.robot.tool.default_state) is None


def test_a_region_out_of_reach_is_empty() -> None:
    arm, state = context().arm, context().cell.robot.tool.default_state
    wrist = WristCentre.of(arm, state)
    assert wrist is not None
    far = WristReach.within(arm, state, wrist, pose((5.0, 0.0, 0.0)), -np.full(3, 0.1), np.full(3, 0.1))
    assert not far.occupied.any()
