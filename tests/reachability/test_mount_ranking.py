"""Base poses: which are tried, what is reached from them, where the base would stand in something."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, pose, rotation_rpy, to_rpy
from pickcli.kinematics.arm import Arm
from pickcli.reachability.mount_ranking import MountGrid, MountRanking, MountSettings, mounted
from pickcli.reachability.tool_pose_sampling import poses_by_place
from pickcli.reachability.tool_reachability import reach_ball
from support.command_line import apc
from support.new_robots import write_two_arms

DOWN = rotation_rpy(np.pi, 0.0, 0.0)
OVER_CRATES = {f"y {y}": pose((0.45, y, 0.95), R=DOWN)[None] for y in (-0.2, 0.2)}
AXES = ("x", "y", "z", "yaw")


@pytest.fixture(scope="module")
def ur5e() -> Cell:
    return load_cell("ur5e_crates")


def ranking(cell: Cell, targets: dict[str, Array]) -> MountRanking:
    return MountRanking(cell, targets, cell.robot.tool.default_state, MountSettings())


def grid(steps: tuple[int, int, int, int] = (1, 1, 1, 1), **bounds: tuple[float, float]) -> MountGrid:
    """Around the mount of the UR5e; what is not stated stays as it is."""
    now = {"x": (0.0, 0.0), "y": (0.0, 0.0), "z": (0.75, 0.75), "yaw": (np.pi, np.pi)}
    return MountGrid({**now, **bounds}, dict(zip(AXES, steps, strict=True)))


def test_a_grid_holds_every_combination_and_keeps_roll_and_pitch() -> None:
    T = pose((1.0, 2.0, 3.0), R=rotation_rpy(0.4, 0.2, 0.1))
    poses = list(grid((3, 2, 1, 1), x=(-1.0, 1.0), y=(0.0, 1.0), z=(0.0, 2.0), yaw=(0.5, 0.5)).poses(T))
    assert sorted(each[:3, 3].tolist() for each in poses) == [
        [x, y, 1.0] for x in (-1.0, 0.0, 1.0) for y in (0.0, 1.0)
    ]
    assert np.allclose([to_rpy(each[:3, :3]) for each in poses], [0.4, 0.2, 0.5])


def test_the_tip_never_leaves_the_ball() -> None:
    rng = np.random.default_rng(5)
    for name in ("ur5e_crates", "panda_table", "apc2016_delft"):
        robot = load_cell(name).robot
        center, radius = reach_ball(robot)
        arm = Arm(robot)
        tips = arm.tips(arm.random_seeds(rng, 500), robot.tool.default_state)[:, :3, 3]
        farthest = np.linalg.norm(tips - center, axis=1).max()
        assert farthest <= radius < 2.5 * farthest, name


def test_what_is_near_is_reached_and_what_is_far_is_not(ur5e: Cell) -> None:
    near = ranking(ur5e, OVER_CRATES).judged(ur5e.robot.T_world_base, 1)
    assert near.shares == {"y -0.2": 1.0, "y 0.2": 1.0}
    aside = ranking(ur5e, OVER_CRATES).judged(pose((0.3, 0.85, 0.75), R=ur5e.robot.T_world_base[:3, :3]), 1)
    assert aside.shares == {"y -0.2": 0.0, "y 0.2": 1.0} and aside.share == 0.5


def test_what_a_turn_does_not_help_is_reached_by_other_seeds(ur5e: Cell) -> None:
    """The last joint of a UR turns the cup alone: all else is left to the starting points."""
    targets = {f"{y:.2f}": pose((0.45, y, 0.95), R=DOWN)[None] for y in np.linspace(-0.3, 0.3, 25)}
    assert ranking(ur5e, targets).judged(ur5e.robot.T_world_base, 1).share == 1.0


def test_a_pose_inside_something_is_not_reached(ur5e: Cell) -> None:
    in_table = {"table": pose((0.45, 0.0, 0.70), R=DOWN)[None]}
    assert ranking(ur5e, in_table).judged(ur5e.robot.T_world_base, 1).share == 0.0


def test_the_best_come_first_and_again_the_same(ur5e: Cell) -> None:
    tried = grid((1, 5, 1, 1), y=(-1.2, 1.2))
    first, again = (ranking(ur5e, OVER_CRATES).suggest(tried, 5) for _ in range(2))
    assert [each.T_world_base.tolist() for each in first] == [each.T_world_base.tolist() for each in again]
    assert first[0].share == 1.0 and first[0].T_world_base[1, 3] in (-0.6, 0.0, 0.6)
    assert [each.worth for each in first] == sorted((each.worth for each in first), reverse=True)


def test_no_base_stands_in_the_shelf(ur5e: Cell) -> None:
    with pytest.raises(NoPlanError, match="stands in shelf_stand"):
        ranking(ur5e, OVER_CRATES).suggest(grid(x=(0.9, 0.9), y=(0.25, 0.25)), 1)
    sunk = mounted(ur5e, pose((0.0, 0.0, 0.70), R=ur5e.robot.T_world_base[:3, :3]))
    lower = grid(x=(0.05, 0.05), z=(0.72, 0.72))  # in the table, as it is now: on purpose
    assert ranking(sunk, OVER_CRATES).suggest(lower, 1)[0].share > 0.0


def test_nothing_to_reach_is_refused(ur5e: Cell) -> None:
    with pytest.raises(InputError, match="nothing to reach"):
        ranking(ur5e, {})


def test_tool_poses_lie_in_their_places() -> None:
    cell = load_cell("apc2016_delft")
    state = cell.robot.tool.default_state
    drawn = poses_by_place(cell, state, 20, 0)
    assert list(drawn) == list(cell.places)
    for name, poses in drawn.items():
        place = cell.places[name]
        points = (np.linalg.inv(cell.T_world_place(place)) @ poses)[:, :3, 3]
        assert (points >= place.room.low).all() and (points <= place.room.high).all(), name
        into = cell.T_world_place(place)[:3, :3] @ place.access.direction
        assert (poses[:, :3, 2] @ into > np.cos(np.radians(43.0))).all(), name  # 30 degrees about either axis
    again = poses_by_place(cell, state, 20, 0)
    assert all((again[name] == poses).all() for name, poses in drawn.items())


def test_the_ball_that_the_tip_never_leaves_is_that_of_its_own_arm(tmp_path: Path) -> None:
    words = ("--tip", "left_tool0", "--max-acceleration", "5", "--max-jerk", "50")
    assert apc("init", tmp_path / "left", "--urdf", write_two_arms(tmp_path), *words).code == 0
    robot = load_cell(tmp_path / "left").robot
    center, radius = reach_ball(robot)
    np.testing.assert_allclose(center, (0.0, 0.3, 0.3))
    arm = Arm(robot)
    Q = arm.random_seeds(np.random.default_rng(0), 200)
    away = [np.linalg.norm(arm.tip(q, robot.tool.default_state)[:3, 3] - center) for q in Q]
    assert 0.9 * radius < max(away) <= radius + 1e-9
