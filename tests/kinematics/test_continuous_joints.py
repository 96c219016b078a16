"""Joints that turn without limits: whole turns change nothing, and the short way is the way."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.continuous_joints import unwound_towards, ways_round
from pickcli.motion.plan import Plan
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.path_planning.state_space import JointSpace
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.start_check import StartError
from pickcli.simulation.world import World
from pickcli.verification.verify import verify
from support.other_robots import write_robot

TURN = 2 * np.pi
ONES = np.ones(3)
LIMITS = Limits(np.array([-np.inf, -2.0, -np.inf]), np.array([np.inf, 2.0, np.inf]), ONES, ONES, ONES)
BOUNDED = replace(LIMITS, lower=-3.0 * ONES, upper=3.0 * ONES)
configurations = arrays(float, 3, elements=st.floats(-30.0, 30.0))


@given(configurations, configurations)
def test_a_turned_configuration_is_the_same_and_near(q: Array, other: Array) -> None:
    near = unwound_towards(LIMITS, q, other)
    turns = (q - near) / TURN
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    assert near[1] == q[1]
    assert np.all(np.abs(near - other)[[0, 2]] <= np.pi + 1e-9)
    assert unwound_towards(BOUNDED, q, other) is q


@given(configurations, configurations)
def test_the_ways_round_begin_with_the_short_one(q: Array, other: Array) -> None:
    ways = ways_round(LIMITS, q, other)
    np.testing.assert_array_equal(ways[0], unwound_towards(LIMITS, q, other))
    for way in ways[1:]:
        changed = np.flatnonzero(np.abs(way - ways[0]) > 1.0)
        assert len(changed) == 1
        assert (way - other)[changed[0]] * (ways[0] - other)[changed[0]] < 0.0
    np.testing.assert_array_equal(ways_round(BOUNDED, q, other), q[None])


@pytest.fixture(scope="module")
def cell(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    """A robot whose first joint is continuous."""
    return load_cell(write_robot(tmp_path_factory.mktemp("branching")))


def scene_of(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise(0.0, 0.0))


def move(cell: Cell, start: tuple[float, ...], goal: tuple[float, ...]) -> Plan:
    context = PlanningContext(cell)
    begin = Start(np.array(start), cell.robot.tool.default_state)
    return plan_move(context, scene_of(cell), begin, MoveGoal(np.array(goal)), seed=1)


def test_a_continuous_joint_has_no_limits_and_is_drawn_from_one_turn(cell: Cell) -> None:
    assert (cell.robot.limits.lower[0], cell.robot.limits.upper[0]) == (-np.inf, np.inf)
    assert cell.robot.limits.is_continuous.tolist() == [True, False, False]
    drawn = Arm(cell.robot).random_seeds(np.random.default_rng(0), 200)
    assert np.all(np.abs(drawn[:, 0]) <= np.pi)


@pytest.mark.parametrize("turns", [-3, 0, 2])
def test_inverse_kinematics_stays_in_the_turn_that_it_begins_in(cell: Cell, turns: int) -> None:
    arm, state = Arm(cell.robot), cell.robot.tool.default_state
    for q in arm.random_seeds(np.random.default_rng(1), 20):
        T_world_tip, seed = arm.tip(q, state), q + np.array([turns * TURN, 0.0, 0.0])
        found = arm.solve(T_world_tip, state, np.stack([seed, q]))
        assert len(found)
        assert np.all(np.abs(found[:, 0] - seed[0]) <= np.pi + 1e-6)
        for each in found:
            np.testing.assert_allclose(arm.tip(each, state), T_world_tip, atol=1e-4)


@pytest.mark.parametrize(
    ("start", "goal", "way"),
    [(3.0, -3.0, TURN - 6.0), (-3.0, 3.0, 6.0 - TURN), (7.0, 0.5, TURN - 6.5), (-20.0, 0.0, 20.0 - 3 * TURN)],
)
def test_a_move_takes_the_short_way_from_where_the_robot_is(
    cell: Cell, start: float, goal: float, way: float
) -> None:
    plan = move(cell, (start, 0.3, 0.0), (goal, -0.4, 0.5))
    np.testing.assert_allclose(plan.trajectory.positions[0], (start, 0.3, 0.0), atol=1e-12)
    assert plan.trajectory.positions[-1][0] - start == pytest.approx(way)
    assert np.ptp(plan.trajectory.positions[:, 0]) < np.pi
    verdict = verify(plan, scene_of(cell))
    assert verdict.certificate is not None, verdict.reasons


def test_where_the_short_way_is_blocked_it_is_no_slower_than_the_other_way(
    cell: Cell, tmp_path: Path
) -> None:
    folder = write_robot(tmp_path)
    content = yaml.safe_load((folder / "cell.yaml").read_text())
    # A wall behind the robot, across the short way from 1.8 to -2.2.
    content["obstacles"].append({"name": "wall", "lower": [-2.3, 0.15, 0.5], "upper": [-1.5, 0.25, 3.0]})
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    blocked = load_cell(folder)
    plan = move(blocked, (1.8, 1.2, 0.0), (-2.2, 1.2, 0.0))
    free = move(cell, (1.8, 1.2, 0.0), (-2.2, 1.2, 0.0))
    other_way = estimated_duration(JointSpace.of(cell.robot), np.array([[1.8, 1.2, 0.0], [-2.2, 1.2, 0.0]]))
    assert free.trajectory.duration < plan.trajectory.duration < other_way
    assert np.cos(plan.trajectory.positions[-1][0] + 2.2) == pytest.approx(1.0)
    assert verify(plan, scene_of(blocked)).certificate is not None


def test_a_robot_that_has_turned_plays_a_plan_from_where_it_is(cell: Cell) -> None:
    plan = move(cell, (3.0, 0.3, 0.0), (-3.0, -0.4, 0.5))
    world = World(scene_of(cell), np.array([3.0 - 2 * TURN, 0.3, 0.0]))
    execution = execute(plan, world)
    assert (execution.stop, execution.collisions, execution.limit_violations) == (None, (), ())
    np.testing.assert_allclose(world.q, (TURN - 3.0 - 2 * TURN, -0.4, 0.5), atol=1e-4)


def test_a_robot_that_stands_elsewhere_is_refused_by_the_way_that_is_left(cell: Cell) -> None:
    plan = move(cell, (3.0, 0.3, 0.0), (-3.0, -0.4, 0.5))
    with pytest.raises(StartError) as refused:
        execute(plan, World(scene_of(cell), np.array([3.1 + TURN, 0.3, 0.0])))
    assert refused.value.joint == "turn"
    assert refused.value.offset == pytest.approx(0.1)


Change = Callable[[dict[str, Any]], object]


@pytest.mark.parametrize(
    ("change", "bounds"),
    [
        (lambda limits: limits.update(min_position=-4.0, max_position=5.0), (-4.0, 5.0)),
        (lambda limits: limits.update(max_position=3.0), (-np.pi, 3.0)),
    ],
)
def test_a_cell_may_narrow_a_continuous_joint(
    tmp_path: Path, change: Change, bounds: tuple[float, float]
) -> None:
    folder = write_robot(tmp_path)
    content = yaml.safe_load((folder / "cell.yaml").read_text())
    change(content["joint_limits"]["turn"])
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    limits = load_cell(folder).robot.limits
    assert (limits.lower[0], limits.upper[0]) == bounds
    assert not limits.is_continuous.any()


def test_degrees_are_told_of_a_continuous_joint_too(
    tmp_path: Path, refused: Callable[[Callable[[], object]], str]
) -> None:
    folder = write_robot(tmp_path)
    content = yaml.safe_load((folder / "cell.yaml").read_text())
    content["configurations"][1]["q"][0] = 90.0
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    message = refused(lambda: load_cell(folder))
    assert "expected turn in -12.6 to 12.6 rad, got 90; angles are in rad, not degrees" in message
