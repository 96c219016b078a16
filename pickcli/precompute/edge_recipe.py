"""The tasks of a roadmap: one edge each."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.collision.model import CollisionModel
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.precompute.empty_scene import RESERVE, checker
from pickcli.precompute.recipe import Key, inputs_digest
from pickcli.precompute.record import Record
from pickcli.roadmap.database import PayloadClass
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.sampling import plan
from pickcli.roadmap.shorten import shorten
from pickcli.roadmap.space import EdgeChecker, JointSpace
from pickcli.seeds import derived_seed


@dataclass(frozen=True)
class RoadmapSettings:
    """How a roadmap is built; all of it is stored with the result.

    n_neighbours: k, edges are tried from each node to its k nearest
    planner: of the edges; where it gives up, RRT-Connect tries
    max_iterations: of a planner for one edge; RRT* uses them all unless the straight edge is free
    """

    planner: PlannerName = PlannerName.RRT_STAR
    n_neighbours: int = 6
    max_iterations: int = 3000
    n_shortcuts: int = 200
    seed: int = 0


@dataclass(frozen=True, eq=False)
class EdgeRecipe:
    """Edges between named configurations of one cell; the key of a task is the two names, sorted.

    Edges are proven for the pivoting cup (MOVING), so that they hold in each pivot state. An edge's seed
    follows from the names of its ends.
    """

    cell: Cell
    settings: RoadmapSettings

    @cached_property
    def inputs(self) -> str:
        """See Recipe."""
        return inputs_digest(self.cell, "roadmap edge", self.settings)

    def make(self, key: Key) -> Record:
        """See Recipe. The record holds the edge's ``waypoints`` (N, n), ends included."""
        q_start, q_goal = (self.cell.configurations[name].q for name in key)
        settings, seed = self.settings, derived_seed(self.settings.seed, "edge", *key)
        # What RRT* needs too long for, RRT-Connect often finds at once.
        planners = list(dict.fromkeys((settings.planner, PlannerName.RRT_CONNECT)))
        found = next(filter(None, (self._planned(q_start, q_goal, seed, each) for each in planners)), None)
        if found is None:
            what = f"{' and '.join(planners)} gave up after {settings.max_iterations} iterations"
            return Record(reason=Reason("no path", detail=what))
        path = shorten(self.checker, self.space, found, seed=seed, iterations=settings.n_shortcuts)
        unproven = self.checker.path_is_free(path.waypoints)
        if unproven != -1:
            what = f"edge {unproven} of the shortened path is not proven whole"
            return Record(reason=Reason("no proof", detail=what))
        return Record(arrays={"waypoints": path.waypoints})

    def _planned(self, q_start: Array, q_goal: Array, seed: int, planner: PlannerName) -> JointPath | None:
        return plan(
            self.checker, self.space, q_start, q_goal[None],
            seed=seed, planner=planner, max_iterations=self.settings.max_iterations,
        )  # fmt: skip

    def __reduce__(self) -> tuple[Any, ...]:
        # Without what was made for the work: that belongs to this process.
        return EdgeRecipe, (self.cell, self.settings)

    @cached_property
    def space(self) -> JointSpace:
        """The joints."""
        return JointSpace.of(self.cell.robot)

    @cached_property
    def checker(self) -> EdgeChecker:
        """Proves configurations and edges."""
        return checker(CollisionModel(self.cell), PivotState.MOVING, PayloadClass.EMPTY, RESERVE)
