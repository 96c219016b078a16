"""Entry of the benchmark: ARA* on the workspace lattice, with the one pass of shortcuts of the PR2 system."""

from __future__ import annotations

import time
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from pickcli.errors import NoPlanError, Reason
from pickcli.kinematics.arm import Arm
from pickcli.path_planning.ara_star import DEFLATION, AraStarSettings
from pickcli.path_planning.lattice_planner import LatticePlannerSettings, plan_on_lattice, shortcut_once
from pickcli.path_planning.workspace_lattice import HandGoals
from pickcli.planner_benchmark.benchmark_entries import BenchmarkQuery, PlannerRun, timed_duration

MOST_EXPANSIONS = 300  # of one query: about 2 s


@dataclass(frozen=True)
class LatticeEntry:
    """ARA* on the workspace lattice. The straight edge is not tried: the search has a cost of its own.

    Attributes:
        max_expansions: Most expansions of the search.
        is_first_only: Whether it ends with its first path, which only the first epsilon bounds.
    """

    max_expansions: int = MOST_EXPANSIONS
    is_first_only: bool = False
    FULL_NAME: ClassVar[str] = "ARA*"
    FIRST_NAME: ClassVar[str] = "ARA*-first"

    @property
    def name(self) -> str:
        """Name of the planner in the table."""
        return self.FIRST_NAME if self.is_first_only else self.FULL_NAME

    @cached_property
    def settings(self) -> LatticePlannerSettings:
        """Effort of the search."""
        deflation = DEFLATION[:1] if self.is_first_only else DEFLATION
        return LatticePlannerSettings(AraStarSettings(deflation, self.max_expansions))

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        """Plan one query; the same for every seed, except for the wall clock.

        Args:
            query: Start and goals.
            seed: Not used: nothing is random.

        Returns:
            The result, or None.
        """
        began = time.perf_counter()
        arm = Arm(query.cell.robot)
        goals = HandGoals(arm.tips(query.goals, query.planning.tool_state), query.goals)
        found = plan_on_lattice(arm, query.planning, query.start, goals, self.settings)
        planned = time.perf_counter()
        if isinstance(found, Reason):
            return None
        path = shortcut_once(query.planning, query.space, found.path)
        try:
            duration = timed_duration(query, path)
        except NoPlanError:  # a blend at a corner that could not be proven
            return None
        whole = time.perf_counter() - began
        return PlannerRun(planned - began, whole, found.path.length, path.length, duration, found.cost_bound)
