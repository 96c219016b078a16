"""OMPL's RRTConnect with a state validity checker in Python: what its two peers share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base, geometric, util

STEP = 0.05  # rad and m, Euclidean: between the states that are tested along a motion

util.setLogLevel(util.LogLevel.LOG_NONE)


class OmplPeer:
    """Subclasses set ``self.is_free`` in ``prepare``."""

    is_free: Callable[[np.ndarray], bool]

    def __init__(self, problem: dict[str, Any]) -> None:
        self.problem, self._number = problem, 0
        n = len(problem["lower"])
        bounds = base.RealVectorBounds(n)
        for j in range(n):
            bounds.setLow(j, problem["lower"][j])
            bounds.setHigh(j, problem["upper"][j])
        self._space = base.RealVectorStateSpace(n)
        self._space.setBounds(bounds)

    def plan(self, start: np.ndarray, goal: np.ndarray) -> OmplPath | None:
        """The first path that RRTConnect finds within the time limit."""
        information = base.SpaceInformation(self._space)
        validity = _Validity(information, self.is_free)
        information.setStateValidityChecker(validity)
        information.setStateValidityCheckingResolution(STEP / self._space.getMaximumExtent())
        information.setup()
        ends = []
        for q in (start, goal):
            state = self._space.allocState()
            for j, value in enumerate(q):
                state[j] = float(value)
            ends.append(state)
        definition = base.ProblemDefinition(information)
        definition.setStartAndGoalStates(*ends)
        planner = geometric.RRTConnect(information)
        planner.setProblemDefinition(definition)
        planner.setup()
        planner.solve(float(self.problem["time_limit"]))
        if not definition.hasExactSolution():
            return None
        return OmplPath(information, validity, definition, len(start))

    def shortened(self, path: OmplPath) -> np.ndarray:
        """The same path after PathSimplifier.simplifyMax."""
        geometric.PathSimplifier(path.information).simplifyMax(path.solution)
        return path.waypoints()


class OmplPath:
    """A path, with what must outlive it: OMPL keeps no reference that Python could see."""

    def __init__(self, information: Any, validity: Any, definition: Any, n: int) -> None:
        self.information, self._validity, self._definition, self._n = information, validity, definition, n
        self.solution = definition.getSolutionPath()

    def waypoints(self) -> np.ndarray:
        """(N, n)."""
        return np.array([[state[j] for j in range(self._n)] for state in self.solution.getStates()])


class _Validity(base.StateValidityChecker):  # type: ignore[misc]
    def __init__(self, information: Any, is_free: Callable[[np.ndarray], bool]) -> None:
        super().__init__(information)
        self._is_free, self._n = is_free, information.getStateDimension()

    def isValid(self, state: Any) -> bool:
        return self._is_free(np.array([state[j] for j in range(self._n)]))
