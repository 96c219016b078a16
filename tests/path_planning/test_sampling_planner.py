"""Planning: straight first, proven, repeatable, and it ends."""

from __future__ import annotations

import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from support.box_world import BoxWorld, space, wall

START, GOAL = np.array([-0.8, 0.0]), np.array([0.8, 0.0])


def test_straight_edge_comes_first() -> None:
    world = BoxWorld()
    path = plan(world, space(), START, GOAL[None], seed=1)
    assert path is not None
    np.testing.assert_array_equal(path.waypoints, [START, GOAL])
    assert world.n_edges == 1


@pytest.mark.parametrize("planner", list(PlannerName))
def test_every_planner_finds_the_gap_and_proves_its_path(planner: PlannerName) -> None:
    path = plan(wall(), space(), START, GOAL[None], seed=3, options=PlannerOptions(planner, 1500))
    assert path is not None
    np.testing.assert_array_equal(path.start, START)
    np.testing.assert_array_equal(path.end, GOAL)
    assert wall().is_valid_path(path.waypoints)
    assert path.waypoints[:, 1].max() > 0.8  # nowhere else is a way through


@pytest.mark.parametrize("planner", list(PlannerName))
def test_same_seed_same_bytes_in_one_process(planner: PlannerName) -> None:
    def once(seed: int) -> bytes:
        path = plan(wall(3), space(3), *_ends(3), seed=seed, options=PlannerOptions(planner, 300))
        return b"" if path is None else path.waypoints.tobytes()

    first = once(5)
    once(6)  # another query in between changes nothing
    assert once(5) == first
    assert len({once(seed) for seed in range(1, 5)}) > 1


@pytest.mark.parametrize("planner", [PlannerName.RRT_CONNECT, PlannerName.AO_RRT_CONNECT])
def test_same_seed_same_bytes_in_another_process(planner: PlannerName) -> None:
    options = PlannerOptions(planner, 2000)
    code = (
        "import numpy as np, hashlib; from support.box_world import space, wall;"
        "from pickcli.path_planning.planner_names import PlannerName;"
        "from pickcli.path_planning.planner_options import PlannerOptions;"
        "from pickcli.path_planning.sampling_planner import plan;"
        "start = np.array([-.8, 0, 0]);"
        f"options = PlannerOptions(PlannerName('{planner}'), {options.max_iterations});"
        "p = plan(wall(3), space(3), start, -start[None], seed=5, options=options);"
        "print(hashlib.sha256(p.waypoints.tobytes()).hexdigest())"
    )
    path = plan(wall(3), space(3), *_ends(3), seed=5, options=options)
    assert path is not None
    other = subprocess.run(
        [sys.executable, "-c", code],
        cwd=Path(__file__).parents[1],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert other.strip() == hashlib.sha256(path.waypoints.tobytes()).hexdigest()


def test_goal_sets_reach_a_free_goal_and_ignore_the_rest() -> None:
    goals = np.array([[0.0, 0.0], [3.0, 0.0], [np.nan, 0.0], GOAL])  # in the wall, out of limits, no number
    path = plan(wall(), space(), START, goals, seed=2)
    assert path is not None
    np.testing.assert_array_equal(path.end, GOAL)


@pytest.mark.parametrize("planner", list(PlannerName))
def test_unsolvable_problems_end_without_a_path(planner: PlannerName) -> None:
    assert (
        plan(wall(gap=-0.1), space(), START, GOAL[None], seed=1, options=PlannerOptions(planner, 300)) is None
    )


def test_ends_that_are_not_free_give_no_path() -> None:
    inside = np.zeros(2)
    assert plan(wall(), space(), inside, GOAL[None], seed=1) is None
    assert plan(wall(), space(), START, inside[None], seed=1) is None


def test_an_end_a_hair_outside_its_limit_is_accepted() -> None:
    start = np.array([-1.0 - 1e-8, 0.0])
    path = plan(wall(), space(), start, GOAL[None], seed=1)
    assert path is not None
    np.testing.assert_array_equal(path.start, start)
    assert plan(wall(), space(), start - 1e-3, GOAL[None], seed=1) is None


def test_an_error_in_the_checker_is_not_swallowed() -> None:
    class Broken(BoxWorld):
        def is_valid_edge(self, q0: np.ndarray, q1: np.ndarray) -> bool:
            if self.n_edges > 3:
                raise RuntimeError("broken")
            return super().is_valid_edge(q0, q1)

    with pytest.raises(RuntimeError, match="broken"):
        plan(
            Broken(wall().boxes),
            space(),
            START,
            GOAL[None],
            seed=1,
            options=PlannerOptions(PlannerName.RRT_STAR),
        )


def _ends(n: int) -> tuple[np.ndarray, np.ndarray]:
    start = np.zeros(n)
    start[0] = -0.8
    return start, -start[None]
