"""Region queries: answers are in an envelope and free, near to the start, and paths to them are proven."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.geometry import Array, inverse
from pickcli.kinematics.arm import Arm, ToolGoal
from pickcli.path_planning.state_space import JointSpace
from pickcli.planning.region_query import RegionChecks, RegionProblem, plan_to_region, region_query
from support.cans import CanScene, can


@pytest.fixture(scope="module")
def table() -> Cell:
    return load_cell("panda_table")


@pytest.fixture(scope="module")
def arm(table: Cell) -> Arm:
    return Arm(table.robot)


def problem_of(table: Cell, scene: CanScene) -> RegionProblem:
    home = table.configurations["home"].q
    return RegionProblem(scene.envelopes, scene.target.T_world_item, scene.state, home)


@pytest.fixture(scope="module")
def scene(table: Cell) -> CanScene:
    return CanScene(table, (can(table, "n", 0.46, 0.25), can(table, "m", 0.68, -0.1)))


def test_goals_are_in_their_envelopes_free_and_sorted(table: Cell, arm: Arm, scene: CanScene) -> None:
    problem = problem_of(table, scene)
    found = region_query(
        arm, problem, RegionChecks(scene.tool.are_valid_at, scene.arm), np.random.default_rng(0)
    )
    assert len(found.Q) > 5
    tips = inverse(scene.target.T_world_item) @ arm.tips(found.Q, scene.state)
    for T, k in zip(tips, found.envelope.tolist(), strict=True):
        assert (
            problem.envelopes[k].contains(T[None], tolerance=2e-5).all()
        )  # of inverse kinematics, for seeds
    assert scene.arm.are_valid(found.Q).all()
    off = np.linalg.norm((found.Q - problem.start) * np.sqrt(arm.weights), axis=1)
    assert (np.diff(off) >= 0.0).all()


def test_a_projection_is_as_near_as_an_optimizer_of_others_finds(
    table: Cell, arm: Arm, scene: CanScene
) -> None:
    problem = problem_of(table, scene)
    envelope = scene.envelopes[0]
    goal = ToolGoal(envelope.constraints, problem.T_world_object, envelope.T_tip_palm)
    rng = np.random.default_rng(4)
    T = problem.T_world_object @ envelope.sample(rng, 12)
    seeds = np.concatenate([arm.solve(each, scene.state, arm.random_seeds(rng, 2)) for each in T])[:8]
    start = problem.start

    def terms(q: Array) -> Array:
        tip = inverse(problem.T_world_object) @ arm.tip(q, scene.state)
        return np.asarray(-envelope.terms(tip[None])[0])

    for seed in seeds:
        Q, distances = arm.nearest(goal, scene.state, seed[None], start)
        assert len(Q) == 1 and terms(Q[0]).min() >= 0.0
        bounds = list(zip(arm.limits.lower, arm.limits.upper, strict=True))
        theirs = minimize(
            lambda q: float(((q - start) ** 2 * arm.weights).sum()), seed, method="SLSQP", bounds=bounds,
            constraints={"type": "ineq", "fun": terms}, options={"maxiter": 300, "ftol": 1e-10},
        )  # fmt: skip
        # Both are local: theirs may end in another valley, mostly a farther one.
        if theirs.success and np.abs(theirs.x - Q[0]).max() < 0.3:
            assert distances[0] <= 1.01 * np.sqrt(theirs.fun)


def test_limits_hold_and_nothing_is_returned_for_what_is_out_of_reach(
    table: Cell, arm: Arm, scene: CanScene
) -> None:
    envelope = scene.envelopes[0]
    far = scene.target.T_world_item.copy()
    far[0, 3] += 2.0
    goal = ToolGoal(envelope.constraints, far, envelope.T_tip_palm)
    Q, _ = arm.nearest(
        goal, scene.state, arm.random_seeds(np.random.default_rng(0), 5), table.configurations["home"].q
    )
    assert len(Q) == 0
    problem = RegionProblem(scene.envelopes, far, scene.state, table.configurations["home"].q)
    found = region_query(
        arm, problem, RegionChecks(scene.tool.are_valid_at, scene.arm), np.random.default_rng(0)
    )
    assert len(found.Q) == 0


def test_a_path_into_the_region_is_proven_and_the_same_again(table: Cell, arm: Arm, scene: CanScene) -> None:
    space = JointSpace.of(table.robot, table.speed_scale)
    problem, checks = problem_of(table, scene), RegionChecks(scene.tool.are_valid_at, scene.arm)
    first = plan_to_region(arm, space, problem, checks, seed=3)
    assert first is not None
    assert scene.arm.first_blocked_edge(first.waypoints) == -1
    tip = inverse(scene.target.T_world_item) @ arm.tip(first.waypoints[-1], scene.state)
    assert any(each.contains(tip[None], tolerance=2e-5).all() for each in problem.envelopes)
    again = plan_to_region(arm, space, problem, checks, seed=3)
    assert again is not None and np.array_equal(first.waypoints, again.waypoints)
