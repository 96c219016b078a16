"""Sampling-based planning in joint space: the only file that imports OMPL.

Three rules make it repeatable. OMPL draws the seed of every new generator from one global generator of
seeds, so this is set before each query and every planner is built anew (the library's warning that
generators exist already concerns those of earlier planners, which are gone). Planners are limited by
iterations, never by seconds. And nothing here runs in a thread: one query at a time per process.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from ompl import base, geometric, util

from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.space import EdgeChecker, JointSpace

util.setLogLevel(util.LogLevel.LOG_NONE)

# How far an end of a returned path may be from what was asked for: a copy of doubles is exact.
_END_TOLERANCE = 1e-12


def plan(
    checker: EdgeChecker,
    space: JointSpace,
    q_start: Array,
    goals: Array,
    *,
    seed: int,
    planner: PlannerName | str = PlannerName.RRT_CONNECT,
    max_iterations: int = 5000,
) -> JointPath | None:
    """A proven polyline from q_start (n,) to one of the goals (G, n), or None.

    A straight edge to the nearest goal that has one comes first: no sampling can beat it. Otherwise the
    planner runs, at most ``max_iterations`` times round its loop (RRT* uses them all). The same arguments
    give the same bytes, in one process as in another.
    """
    q_start, goals = np.asarray(q_start, dtype=float), np.atleast_2d(np.asarray(goals, dtype=float))
    if not (space.holds(q_start) and checker.is_free(q_start)):
        return None
    reachable = [goal for goal in goals if space.holds(goal) and checker.is_free(goal)]
    reachable.sort(key=lambda goal: float(np.linalg.norm(goal - q_start)))
    for goal in reachable:
        if checker.edge_is_free(q_start, goal):
            return JointPath(space.joint_names, np.stack([q_start, goal]))
    if not reachable:
        return None
    waypoints = _solve(checker, space, q_start, reachable, PlannerName(planner), seed, max_iterations)
    if waypoints is None or not _is_answer(checker, q_start, reachable, waypoints):
        return None
    return JointPath(space.joint_names, waypoints)


def _solve(
    checker: EdgeChecker,
    space: JointSpace,
    q_start: Array,
    goals: list[Array],
    planner: PlannerName,
    seed: int,
    max_iterations: int,
) -> Array | None:
    """OMPL's own answer (N, n), unchecked."""
    util.RNG.setSeed(1 + seed % (2**31 - 1))  # 0 would mean "from the clock"
    ends = np.array([q_start, *goals])
    state_space = _bounded(
        np.minimum(space.lower, ends.min(axis=0)), np.maximum(space.upper, ends.max(axis=0))
    )
    information = base.SpaceInformation(state_space)
    # OMPL keeps no reference that Python could see: these two names must outlive solve().
    motions, states = _Motions(information, checker), _States(information, checker)
    information.setMotionValidator(motions)
    information.setStateValidityChecker(states)
    information.setup()
    problem = _problem(information, state_space, q_start, goals)
    algorithm = getattr(geometric, planner.value)(information)
    algorithm.setProblemDefinition(problem)
    algorithm.setup()
    algorithm.solve(base.PlannerTerminationCondition(_after(max_iterations)))
    path = problem.getSolutionPath()
    if path is None or not problem.hasExactSolution():
        return None
    return np.array([_read(state, space.n) for state in path.getStates()])


def _bounded(lower: Array, upper: Array) -> Any:
    state_space = base.RealVectorStateSpace(len(lower))
    bounds = base.RealVectorBounds(len(lower))
    for j, (low, high) in enumerate(zip(lower, upper, strict=True)):
        bounds.setLow(j, float(low))
        bounds.setHigh(j, float(high))
    state_space.setBounds(bounds)
    return state_space


def _problem(information: Any, state_space: Any, q_start: Array, goals: list[Array]) -> Any:
    problem = base.ProblemDefinition(information)
    goal_states = base.GoalStates(information)
    scratch = state_space.allocState()  # Python owns it; freeState would free it twice
    _write(scratch, q_start)
    problem.addStartState(scratch)
    for goal in goals:
        _write(scratch, goal)
        goal_states.addState(scratch)
    problem.setGoal(goal_states)
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    return problem


def _after(n: int) -> Any:
    """A condition that becomes true when it has been asked more than n times."""
    left = n

    def is_over() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    return is_over


def _is_answer(checker: EdgeChecker, q_start: Array, goals: list[Array], waypoints: Array) -> bool:
    """Whether a path starts and ends where it should and is proven: no planner is believed."""
    gap = min(float(np.abs(goal - waypoints[-1]).max()) for goal in goals)
    return bool(
        len(waypoints) >= 2
        and np.abs(waypoints[0] - q_start).max() <= _END_TOLERANCE
        and gap <= _END_TOLERANCE
        and checker.path_is_free(waypoints) == -1
    )


def _read(state: Any, n: int) -> Array:
    # By index: slices of OMPL's states are ten times slower.
    return np.array([state[j] for j in range(n)])


def _write(state: Any, q: Array) -> None:
    for j, value in enumerate(q):
        state[j] = float(value)


class _Motions(base.MotionValidator):  # type: ignore[misc]
    """OMPL's question "is this motion free", answered by proof."""

    def __init__(self, information: Any, checker: EdgeChecker) -> None:
        super().__init__(information)
        self._edge_is_free = checker.edge_is_free
        self._n = information.getStateDimension()

    def checkMotion(self, a: Any, b: Any, last_valid: Any = None) -> bool:
        """Whether the straight edge between two states is proven free."""
        return self._edge_is_free(_read(a, self._n), _read(b, self._n))


class _States(base.StateValidityChecker):  # type: ignore[misc]
    """OMPL's question "is this state free"."""

    def __init__(self, information: Any, checker: EdgeChecker) -> None:
        super().__init__(information)
        self._is_free = checker.is_free
        self._n = information.getStateDimension()

    def isValid(self, state: Any) -> bool:
        """Whether a state keeps the margin."""
        return self._is_free(_read(state, self._n))
