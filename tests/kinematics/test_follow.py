"""Straight lines: whole with every promise kept, or broken with the cause."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

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
    assert result.reason is None and len(result.configurations) == len(poses)
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
    complete = [arm.follow(poses, STRAIGHT, q).reason is None for q in starts]
    assert len(complete) >= 4
    assert np.mean(complete) >= 0.5


def test_the_rail_does_the_insertion(arm: Arm, rng: np.random.Generator) -> None:
    poses = insertion(0.1, 1.3)
    results = [arm.follow(poses, STRAIGHT, q) for q in arm.solve_spread(poses[0], STRAIGHT, rng)]
    rails = [r.configurations[-1, 0] - r.configurations[0, 0] for r in results if r.reason is None]
    assert np.median(rails) > 0.2


def test_out_of_reach_says_where(arm: Arm, rng: np.random.Generator) -> None:
    poses = line(pose((0.0, 0, 1.2), R=FRONTAL), pose((2.5, 0, 1.2), R=FRONTAL), 101)
    result = arm.follow(poses, STRAIGHT, arm.solve_spread(poses[0], STRAIGHT, rng)[0])
    assert result.reason is not None
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
    assert free.reason is None
    # All joints but the rail are held where the free line starts: only the rail can go in, and it may not.
    lower = limits.lower.copy()
    lower[1:], upper[1:], upper[0] = q0[1:] - 0.02, q0[1:] + 0.02, q0[0] + 0.1
    tight = Arm(replace(cell.robot, limits=replace(limits, lower=lower, upper=upper)))
    result = tight.follow(poses, STRAIGHT, q0)
    assert result.reason is not None and result.reason.what == "joint limit"
    assert "% of the line" in result.reason.detail


def test_a_far_start_is_a_jump_not_a_path(arm: Arm, rng: np.random.Generator) -> None:
    poses = insertion(0.0, 1.2)
    q0 = arm.solve_spread(poses[0], STRAIGHT, rng)[0] + np.array([0, 0.3, 0, 0, 0, 0, 0, 0])
    result = arm.follow(poses, STRAIGHT, q0)
    assert len(result.configurations) == 0
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


def off_middle(a: Array, middle: Array, b: Array) -> tuple[float, float]:
    """How far a pose is off half-way between two others, in m and rad: the oracle of the kernel."""
    before, after = a[:3, :3].T @ middle[:3, :3], middle[:3, :3].T @ b[:3, :3]
    offset = middle[:3, 3] - (a[:3, 3] + b[:3, 3]) / 2
    return float(np.linalg.norm(offset)), rotation_angle(before.T @ after) / 2


def test_a_line_ends_before_the_first_step_on_which_the_tool_is_too_far_off(
    arm: Arm, rng: np.random.Generator
) -> None:
    turned = pose((0.25, 0.05, 1.25), rpy=(0.1, 0.2, -0.1)) @ pose(R=FRONTAL)
    poses = line(pose((-0.05, 0.0, 1.2), R=FRONTAL), turned, 12)
    loose = Deviation(1.0, 1.0)
    starts = arm.solve_spread(poses[0], STRAIGHT, rng)
    q0 = next(q for q in starts if arm.follow(poses[1:], STRAIGHT, q, loose).reason is None)
    Q = np.vstack([q0, arm.follow(poses[1:], STRAIGHT, q0, loose).configurations])
    tips, middles = arm.tips(Q, STRAIGHT), arm.tips((Q[:-1] + Q[1:]) / 2, STRAIGHT)
    offsets = np.array([off_middle(*step) for step in zip(tips[:-1], middles, tips[1:], strict=True)])
    for column in (0, 1):
        bounds = np.ones((4, 2))
        bounds[:, column] = np.quantile(offsets[:, column], [0.3, 0.6, 0.9, 1.0]) * 1.0001
        for most in bounds[:3]:
            first = int(np.argmax(offsets[:, column] > most[column]))
            result = arm.follow(poses[1:], STRAIGHT, q0, Deviation(*most))
            assert len(result.configurations) == first
            assert result.reason is not None and result.reason.what == "leaves the line"
            assert f"{offsets[first, 0] * 1e3:.1f} mm" in result.reason.detail
        assert arm.follow(poses[1:], STRAIGHT, q0, Deviation(*bounds[3])).reason is None


LEVEL = pose((-0.05, 0.0, 1.2), R=FRONTAL)
TURNED = pose((0.25, 0.05, 1.25), rpy=(0.1, 0.2, -0.1)) @ pose(R=FRONTAL)
IK_TOLERANCE = 3e-5  # m and rad


@pytest.mark.parametrize("end", [TURNED, pose((-0.03, 0.01, 1.23), rpy=(1.1, 0.1, 0.0)) @ pose(R=FRONTAL)])
@pytest.mark.parametrize("most", [Deviation(5e-4, 3e-3), Deviation(5e-5, 1.0), Deviation(1.0, 1e-3)])
def test_chords_between_kept_waypoints_stay_near_the_line(
    arm: Arm, rng: np.random.Generator, most: Deviation, end: Array
) -> None:
    """On the second line, the tool turns by 1.1 rad within 37 mm: small progress matters to its angle."""
    poses = line(LEVEL, end, 60)
    starts = arm.solve_spread(poses[0], STRAIGHT, rng)
    results = [arm.follow(poses, STRAIGHT, q) for q in starts]
    Q = next(result.configurations for result in results if result.reason is None)
    kept = arm.longest_chords(Q, poses, STRAIGHT, most).tolist()
    assert kept[0] == 0 and kept[-1] == 59 and kept == sorted(set(kept)) and len(kept) < 60
    along = poses[-1, :3, 3] - poses[0, :3, 3]
    turn = Rotation.from_matrix(poses[0, :3, :3].T @ poses[-1, :3, :3]).as_rotvec()
    for i, j in pairwise(kept):
        share = (np.arange(i, j + 1)[:, None] - i) / (j - i)
        tips = arm.tips((1 - share) * Q[i] + share * Q[j], STRAIGHT)
        off = tips[:, :3, 3] - poses[0, :3, 3]
        s = off @ along / (along @ along)
        assert np.linalg.norm(off - np.outer(s, along), axis=1).max() <= most.position + IK_TOLERANCE
        there = poses[0, :3, :3] @ Rotation.from_rotvec(np.outer(s, turn)).as_matrix()
        angles = [rotation_angle(R.T @ T[:3, :3]) for R, T in zip(there, tips, strict=True)]
        per_metre = np.linalg.norm(turn) / np.linalg.norm(along)
        assert max(angles) <= most.angle + IK_TOLERANCE * (1.0 + per_metre)
    everywhere = arm.longest_chords(Q, poses, STRAIGHT, Deviation(1.0, 2.0))
    assert everywhere.tolist() == [0, 59]


def test_chains_that_are_none_are_refused(cell: Cell) -> None:
    robot = cell.robot
    with pytest.raises(InputError, match="one chain"):
        build_chain(replace(robot, joints=robot.joints[:3] + robot.joints[4:]), STRAIGHT)
    with pytest.raises(InputError, match="joint_t"):
        build_chain(replace(robot, joint_names=robot.joint_names[:-1]), STRAIGHT)
