"""ARA* on the workspace lattice of the PR2's arms: proven paths, a bound that an exact search confirms."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from heapq import heappop, heappush
from unittest import mock

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.path_planning import workspace_lattice
from pickcli.path_planning.ara_star import AraStarSettings
from pickcli.path_planning.lattice_cost import LatticeResolution
from pickcli.path_planning.lattice_planner import (
    LatticePlan,
    LatticePlannerSettings,
    plan_on_lattice,
    shortcut_once,
)
from pickcli.path_planning.state_space import JointSpace
from pickcli.path_planning.workspace_lattice import HandGoals, WorkspaceLattice, redundant_joints
from pickcli.scene.belt_sweep import swept_along_belt
from support.edge_costs import edge_costs
from support.pr2_picks import context, home, stream

COARSE = LatticeResolution(
    position=0.12, turns=12, redundant=0.5, rotation_cost=0.4, redundant_cost=0.2, near=1.5
)


@cache
def checker(is_busy: bool = True) -> SceneChecker:
    """The left arm over the belt, with boxes along it that the items may come to."""
    scene = stream().scene_at(stream().items[2].stamp)
    scene = swept_along_belt(scene, stream().conveyor) if is_busy else scene
    return context().checker_for(scene, Mode(home().tool_state))


def goals(*names: str, by_pose: bool = False) -> HandGoals:
    Q = np.array([context().cell.configurations[name].q for name in names])
    return HandGoals(context().arm.tips(Q, home().tool_state), None if by_pose else Q)


def planned(
    to: HandGoals, most: int = 400, resolution: LatticeResolution | None = None
) -> LatticePlan | None:
    settings = LatticePlannerSettings(AraStarSettings(max_expansions=most), resolution or LatticeResolution())
    found = plan_on_lattice(context().arm, checker(), home().q, to, settings)
    return None if isinstance(found, Reason) else found


def near_goal(reach: float) -> HandGoals:
    """A pose beside and below that of the start, turned: reach m away."""
    T = context().arm.tip(home().q, home().tool_state).copy()
    T[:3, 3] += reach * np.array([0.6, -0.75, 0.28])
    turn = np.eye(4)
    turn[:2, :2] = [[np.cos(0.6), -np.sin(0.6)], [np.sin(0.6), np.cos(0.6)]]
    return HandGoals((T @ turn)[None])


def least_cost(lattice: WorkspaceLattice) -> float:
    """What Dijkstra's search, which no heuristic guides, finds on a lattice."""
    costs, queue = {lattice.start: 0.0}, [(0.0, lattice.start)]
    while queue:
        cost, node = heappop(queue)
        if node == lattice.goal:
            return cost
        for after, more in lattice.successors(node) if cost == costs[node] else ():
            if cost + more < costs.get(after, np.inf):
                costs[after] = cost + more
                heappush(queue, (cost + more, after))
    return np.inf


@pytest.mark.parametrize("reach", [0.25, 0.3, 0.35])
def test_bounds_hold_and_the_last_cost_is_the_least_by_an_exact_search(reach: float) -> None:
    to = near_goal(reach)
    least = least_cost(WorkspaceLattice(context().arm, checker(), home().q, to, COARSE))
    plan = planned(to, 4000, COARSE)
    assert plan is not None and 0.0 < least < np.inf
    assert plan.cost == pytest.approx(least) and plan.cost_bound == pytest.approx(1.0)
    for path in plan.found:
        assert path.cost <= path.epsilon * least + 1e-9
        assert path.lower_bound <= least + 1e-9


def test_the_heuristic_is_consistent() -> None:
    for to in (goals("belt", "bin_left"), goals("belt", by_pose=True)):
        lattice = WorkspaceLattice(context().arm, checker(), home().q, to, LatticeResolution())
        assert lattice.heuristic(lattice.goal) == 0.0
        frontier, n_edges = [lattice.start], 0
        for node in frontier[:1] + [after for after, _ in lattice.successors(lattice.start)][:40]:
            for after, cost in lattice.successors(node):
                assert lattice.heuristic(node) <= cost + lattice.heuristic(after) + 1e-9
                n_edges += 1
        assert n_edges > 300


def test_a_path_is_proven_and_ends_in_its_goal_exactly() -> None:
    to = goals("belt", "bin_left")
    plan = planned(to)
    assert plan is not None and to.configurations is not None
    Q = plan.path.waypoints
    assert np.array_equal(Q[0], home().q) and checker().is_valid_path(Q) and len(Q) > 2
    off = (Q[-1] - to.configurations[plan.goal]) / (2 * np.pi)
    assert np.allclose(off, np.round(off), atol=1e-12)
    assert not np.round(off)[~context().cell.robot.limits.is_continuous].any()


def test_a_goal_that_is_a_pose_is_reached_in_any_posture() -> None:
    to = goals("bin_left", by_pose=True)
    plan = planned(to)
    assert plan is not None and checker().is_valid_path(plan.path.waypoints)
    assert np.allclose(
        context().arm.tip(plan.path.waypoints[-1], home().tool_state), to.T_world_tip[0], atol=1e-7
    )


def test_bounds_hold_and_the_turn_is_kept_where_it_has_to_be() -> None:
    q = context().arm.solve_near(near_goal(0.3).T_world_tip[0], home().tool_state, home().q)
    assert q is not None
    to = HandGoals(near_goal(0.3).T_world_tip, q[None], in_any_turn=False)
    least = least_cost(WorkspaceLattice(context().arm, checker(), home().q, to, COARSE))
    plan = planned(to, 4000, COARSE)
    assert plan is not None and np.array_equal(plan.path.waypoints[-1], q)
    assert least <= plan.cost <= plan.cost_bound * least + 1e-9
    turned = q + 2 * np.pi * context().cell.robot.limits.is_continuous
    away = HandGoals(to.T_world_tip, turned[None], in_any_turn=False)
    assert planned(away, 200, COARSE) is None
    assert planned(replace(away, in_any_turn=True), 4000, COARSE) is not None


def test_more_goals_cost_no_more() -> None:
    costs = []
    for names in (("belt",), ("bin_left",), ("belt", "bin_left")):
        plan = planned(goals(*names), 3000)
        assert plan is not None and plan.cost_bound == pytest.approx(1.0)
        costs.append(plan.cost)
    assert costs[2] == pytest.approx(min(costs[:2]))


def test_one_pass_of_shortcuts_is_proven_and_costs_no_more() -> None:
    plan, space = planned(goals("belt"), 100), JointSpace.of(context().cell.robot)
    assert plan is not None
    short = shortcut_once(checker(), space, plan.path)
    assert checker().is_valid_path(short.waypoints) and len(short.waypoints) < len(plan.path.waypoints)
    assert edge_costs(space, short.waypoints).sum() <= edge_costs(space, plan.path.waypoints).sum() + 1e-12


def test_the_same_question_gives_the_same_bytes() -> None:
    first, again = (planned(near_goal(0.3), 200) for _ in range(2))
    assert first is not None and again is not None
    assert first.path.waypoints.tobytes() == again.path.waypoints.tobytes() and first.found == again.found


def test_where_no_path_is_found_the_reason_says_whether_more_expansions_may_help() -> None:
    def why(to: HandGoals, most: int) -> str:
        settings = LatticePlannerSettings(AraStarSettings(max_expansions=most))
        found = plan_on_lattice(context().arm, checker(), home().q, to, settings)
        assert isinstance(found, Reason) and found.what == "no path"
        return found.detail

    assert why(goals("belt"), 1).endswith("in the 1 expansions that it may take")
    with mock.patch.object(workspace_lattice, "LARGEST_STEP", 0.0):  # no state but the start
        told = "after 1 expansions no state is left that may lead to a goal, so more of them do not help"
        assert why(goals("belt"), 50).endswith(told)


def test_a_start_that_is_not_free_has_no_path() -> None:
    found = plan_on_lattice(context().arm, checker(), _in_the_belt(), goals("belt"))
    assert isinstance(found, Reason) and str(found).startswith("start: no path: it is not free")


def test_with_expansions_left_the_path_is_proven_the_best() -> None:
    """Ways of one length differ by the rounding of their sums, which leaves no bound above 1."""
    plan = planned(near_goal(0.3), 5000)
    assert plan is not None and plan.n_expanded < 5000
    assert plan.cost_bound == 1.0


def test_where_the_hands_sphere_is_not_free_no_posture_is_valid() -> None:
    sphere = checker().hand_sphere()
    assert sphere is not None
    arm, state = context().arm, home().tool_state
    Q = arm.random_seeds(np.random.default_rng(3), 4000)
    frames = np.array([arm.chain(state).fk(q)[sphere.sphere.frame] for q in Q])
    is_free = sphere.are_free(frames[:, :3, 3] + frames[:, :3, :3] @ sphere.sphere.center)
    is_valid = checker().are_valid(Q)
    assert (~is_free).sum() > 50 and is_valid.sum() > 50
    assert not (is_valid & ~is_free).any()


def test_the_redundant_joint_of_seven_is_the_roll_of_the_upper_arm() -> None:
    robot = context().cell.robot
    assert [robot.joint_names[j] for j in redundant_joints(robot.limits)] == ["l_upper_arm_roll_joint"]


def test_joints_beyond_seven_are_those_of_the_rail_and_six_leave_none() -> None:
    on_a_rail, six = load_cell("apc2016_delft").robot, load_cell("ur5e_crates").robot
    assert redundant_joints(on_a_rail.limits) == (0, 3)
    assert redundant_joints(six.limits) == ()


def test_an_arm_with_fewer_joints_than_a_pose_needs_is_refused() -> None:
    with mock.patch.object(Arm, "n", 5), pytest.raises(InputError, match="6 joints at least, not 5"):
        planned(goals("belt"))


def test_a_goal_must_be_given() -> None:
    with pytest.raises(InputError, match="no goal is given"):
        planned(HandGoals(np.zeros((0, 4, 4))))


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ({"position": 0.0}, "over 0"),
        ({"rotation_cost": float("nan")}, "over 0"),
        ({"near": 0.5}, "1 step at least"),
        ({"turns": 10}, "a multiple of 4"),
    ],
)
def test_a_lattice_without_sense_is_refused(fault: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        LatticeResolution(**fault)  # type: ignore[arg-type]


def _in_the_belt() -> Array:
    """A configuration with the hand in the belt."""
    arm: Arm = context().arm
    T = arm.tip(context().cell.configurations["belt"].q, home().tool_state).copy()
    T[2, 3] = 0.6
    q = arm.solve_near(T, home().tool_state, context().cell.configurations["belt"].q)
    assert q is not None
    return q
