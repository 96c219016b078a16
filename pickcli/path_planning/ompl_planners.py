"""OMPL's planners in joint space; the only module that imports OMPL.

Three rules make results repeatable. OMPL seeds every new generator from one global generator of seeds, so its
seed is set before each query and every planner is built again (the library's warning about existing
generators concerns those of earlier planners, which are deleted). Planners are limited by iterations, never
by time. And there are no threads: one query at a time per process.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.errors import not_installed
from pickcli.geometry import Array
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.state_space import JointSpace

try:
    from ompl import base, geometric, util
except ImportError:
    raise not_installed("ompl", "plan-offline", "building of roadmaps, and the planners of OMPL,") from None

util.setLogLevel(util.LogLevel.LOG_NONE)

# OMPL's class names that differ from the planner's name here.
_CLASSES = {PlannerName.OMPL_RRT_CONNECT: "RRTConnect"}


def solve(
    checker: MotionValidator,
    space: JointSpace,
    q_start: Array,
    goals: Sequence[Array],
    seed: int,
    options: PlannerOptions,
) -> Array | None:
    """Run OMPL on a planning problem; the result is not checked.

    Args:
        checker: Proves edges and configurations.
        space: Its position limits bound the search.
        q_start: (n,) start.
        goals: Goal configurations, (n,) each.
        seed: Seed of its random numbers.
        options: Planner and its effort.

    Returns:
        Waypoints (N, n), or None if it found no path.
    """
    util.RNG.setSeed(1 + seed % (2**31 - 1))  # 0 would mean "from the clock"
    state_space = _bounded(space)
    information = base.SpaceInformation(state_space)
    # OMPL's references are not visible to Python: these two objects must outlive solve().
    motions, states = _Motions(information, checker), _States(information, checker)
    information.setMotionValidator(motions)
    information.setStateValidityChecker(states)
    information.setup()
    problem = _problem(information, state_space, q_start, goals)
    algorithm = getattr(geometric, _CLASSES.get(options.planner, options.planner.value))(information)
    algorithm.setProblemDefinition(problem)
    algorithm.setup()
    algorithm.solve(base.PlannerTerminationCondition(_after(options.max_iterations)))
    path = problem.getSolutionPath()
    if path is None or not problem.hasExactSolution():
        return None
    return np.array([_read(state, len(q_start)) for state in path.getStates()])


def _bounded(space: JointSpace) -> Any:
    state_space = base.RealVectorStateSpace(space.n)
    bounds = base.RealVectorBounds(space.n)
    for j, (low, high) in enumerate(zip(space.lower, space.upper, strict=True)):
        bounds.setLow(j, float(low))
        bounds.setHigh(j, float(high))
    state_space.setBounds(bounds)
    return state_space


def _problem(information: Any, state_space: Any, q_start: Array, goals: Sequence[Array]) -> Any:
    problem = base.ProblemDefinition(information)
    goal_states = base.GoalStates(information)
    scratch = state_space.allocState()  # owned by Python; freeState would free it twice
    _write(scratch, q_start)
    problem.addStartState(scratch)
    for goal in goals:
        _write(scratch, goal)
        goal_states.addState(scratch)
    problem.setGoal(goal_states)
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    return problem


def _after(n: int) -> Any:
    """Return a condition that becomes true after n evaluations."""
    left = n

    def is_over() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    return is_over


def _read(state: Any, n: int) -> Array:
    # By index: slices of OMPL's states are ten times slower.
    return np.array([state[j] for j in range(n)])


def _write(state: Any, q: Array) -> None:
    for j, value in enumerate(q):
        state[j] = float(value)


class _Motions(base.MotionValidator):  # type: ignore[misc]
    """Adapter of the checker to OMPL's motion validator."""

    def __init__(self, information: Any, checker: MotionValidator) -> None:
        super().__init__(information)
        self._is_valid_edge = checker.is_valid_edge
        self._n = information.getStateDimension()

    def checkMotion(self, a: Any, b: Any, last_valid: Any = None) -> bool:
        """Whether the straight edge between two states is proven free."""
        return self._is_valid_edge(_read(a, self._n), _read(b, self._n))


class _States(base.StateValidityChecker):  # type: ignore[misc]
    """Adapter of the checker to OMPL's state validity checker."""

    def __init__(self, information: Any, checker: MotionValidator) -> None:
        super().__init__(information)
        self._is_valid = checker.is_valid
        self._n = information.getStateDimension()

    def isValid(self, state: Any) -> bool:
        """Whether a state keeps the margin."""
        return self._is_valid(_read(state, self._n))
