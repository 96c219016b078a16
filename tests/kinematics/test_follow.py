"""Straight lines: whole with every promise kept, or broken with the cause."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.geometry import Array, pose, rotation_angle, rotation_vector
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.chain import build_chain
from pickcli.kinematics.follow import Deviation
from support.tool_states import STRAIGHT

FRONTAL = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # tool z along the world's x, tool x down


def line(T_a: Array, T_b: Array, n: int) -> Array:
    """Poses (n, 4, 4), straight and turning evenly."""
    s = np.linspace(0, 1, n)[:, None]
    poses = np.tile(np.eye(4), (n, 1, 1))
    poses[:, :3, 3] = (1 - s) * T_a[:3, 3] + s * T_b[:3, 3]
    turn = rotation_vector(T_a[:3, :3].T @ T_b[:3, :3])
    poses[:, :3, :3] = T_a[:3, :3] @ Rotation.from_rotvec(s * turn).as_matrix()
    return poses


def insertion(y: float, z: float, depth: float = 0.45, step: float = 0.01) -> Array:
    """Tool poses from 5 cm in front of the shelf straight in."""
    return line(pose((-0.05, y, z), R=FRONTAL), pose((depth - 0.05, y, z), R=FRONTAL), int(depth / step) + 1)


def test_whole_line_keeps_every_promise(arm: Arm, rng: np.random.Generator) -> None:
    poses = insertion(0.0, 1.2)
    q0 = arm.solve_spread(poses[0], STRAIGHT, rng)[0]
    result = arm.follow(poses, STRAIGHT, q0)
    assert result.is_complete and result.reason is None and len(result.configurations) == len(poses)
    np.testing.assert_allclose(arm.tips(result.configurations, STRAIGHT), poses, atol=2e-4)
    assert np.all(np.abs(np.diff(result.configurations, axis=0)) <= arm.max_step)
    for s in (0.25, 0.5, 0.75):
        between = (1 - s) * result.configurations[:-1] + s * result.configurations[1:]
        expected = (1 - s) * poses[:-1] + s * poses[1:]
        assert (
            np.linalg.norm(arm.tips(between, STRAIGHT)[:, :3, 3] - expected[:, :3, 3], axis=1).max() < 1.1e-3
        )


@pytest.mark.parametrize("name", [f"bin_{letter}" for letter in "ABCDEFGHIJKL"])
def test_insertions_from_random_solutions(cell: Cell, arm: Arm, name: str) -> None:
    """Nearly every line has a continuous path, and most random solutions at its start serve."""
    rng = np.random.default_rng(7)
    cell_bin = cell.pod.bins[name]
    y, z = cell_bin.T_carrier_place[1, 3], cell_bin.T_carrier_place[2, 3] + cell_bin.access.height / 2
    poses = insertion(float(y), float(z))
    starts = arm.solve_spread(poses[0], STRAIGHT, rng, 16)
    complete = [arm.follow(poses, STRAIGHT, q).is_complete for q in starts]
    assert len(complete) >= 4
    assert np.mean(complete) >= 0.5


def test_the_rail_does_the_insertion(arm: Arm, rng: np.random.Generator) -> None:
    poses = insertion(0.1, 1.3)
    results = [arm.follow(poses, STRAIGHT, q) for q in arm.solve_spread(poses[0], STRAIGHT, rng)]
    rails = [r.configurations[-1, 0] - r.configurations[0, 0] for r in results if r.is_complete]
    assert np.median(rails) > 0.2


def test_out_of_reach_says_where(arm: Arm, rng: np.random.Generator) -> None:
    poses = line(pose((0.0, 0, 1.2), R=FRONTAL), pose((2.5, 0, 1.2), R=FRONTAL), 101)
    result = arm.follow(poses, STRAIGHT, arm.solve_spread(poses[0], STRAIGHT, rng)[0])
    assert not result.is_complete and result.reason is not None
    assert result.reason.what in {"joint limit", "no convergence", "branch jump"}
    n = len(result.configurations)
    assert 0 < n < 101
    assert f"{n} % of the line" in result.reason.detail
    np.testing.assert_allclose(
        arm.tips(result.configurations, STRAIGHT)[:, :3, 3], poses[:n, :3, 3], atol=1e-4
    )


def test_joint_limit_is_named(cell: Cell, arm: Arm, rng: np.random.Generator) -> None:
    limits = cell.robot.limits
    upper = limits.upper.copy()
    poses = insertion(0.0, 1.2)
    q0 = arm.solve_spread(poses[0], STRAIGHT, rng)[0]
    free = arm.follow(poses, STRAIGHT, q0)
    assert free.is_complete
    # All joints but the rail are held where the free line starts: only the rail can go in, and it may not.
    lower = limits.lower.copy()
    lower[1:], upper[1:], upper[0] = q0[1:] - 0.02, q0[1:] + 0.02, q0[0] + 0.1
    tight = Arm(replace(cell.robot, limits=replace(limits, lower=lower, upper=upper)))
    result = tight.follow(poses, STRAIGHT, q0)
    assert not result.is_complete and result.reason is not None
    assert result.reason.what == "joint limit"
    assert "% of the line" in result.reason.detail


def test_a_far_start_is_a_jump_not_a_path(arm: Arm, rng: np.random.Generator) -> None:
    poses = insertion(0.0, 1.2)
    q0 = arm.solve_spread(poses[0], STRAIGHT, rng)[0] + np.array([0, 0.3, 0, 0, 0, 0, 0, 0])
    result = arm.follow(poses, STRAIGHT, q0)
    assert not result.is_complete and len(result.configurations) == 0
    assert result.reason is not None and result.reason.what == "branch jump"
    assert "at 0 % of the line" in result.reason.detail


def test_leaving_the_line_between_poses_is_seen(arm: Arm, rng: np.random.Generator) -> None:
    """With a tighter bound than the spacing of the poses allows, the check between them bites."""
    poses = insertion(0.1, 1.2, step=0.04)
    results = [
        arm.follow(poses, STRAIGHT, q, Deviation(1e-7, 1e-7))
        for q in arm.solve_spread(poses[0], STRAIGHT, rng)
    ]
    broken = [r for r in results if r.reason is not None and r.reason.what == "leaves the line"]
    assert broken
    assert all("mm" in r.reason.detail and "%" in r.reason.detail for r in broken if r.reason)


def test_deviation_measures_offset_and_angle() -> None:
    ends = np.array([np.eye(4), pose((0.02, 0, 0), rpy=(0.2, 0, 0))])
    good = line(ends[0], ends[1], 3)[1]
    assert Deviation().first_broken(ends, good[None]) is None
    shifted, turned = good.copy(), good @ pose(rpy=(0, 0, 0.02))
    shifted[2, 3] += 0.0011
    assert Deviation().first_broken(ends, shifted[None]) is not None
    assert Deviation().first_broken(ends, turned[None]) is not None
    # The estimate of the angle is exact: just below and above the bound.
    for angle, is_broken in ((0.0199, False), (0.0201, True)):
        middle = good @ pose(rpy=(angle, 0, 0))
        assert rotation_angle(good[:3, :3].T @ middle[:3, :3]) == pytest.approx(angle)
        assert (Deviation(1.0, 0.02).first_broken(ends, middle[None]) is not None) is is_broken


def test_chains_that_are_none_are_refused(cell: Cell) -> None:
    robot = cell.robot
    with pytest.raises(InputError, match="one chain"):
        build_chain(replace(robot, joints=robot.joints[:3] + robot.joints[4:]), STRAIGHT)
    with pytest.raises(InputError, match="joint_t"):
        build_chain(replace(robot, joint_names=robot.joint_names[:-1]), STRAIGHT)
