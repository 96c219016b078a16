"""Coarse motions of the empty tool in a cell without items, for the choice of its configurations."""

from __future__ import annotations

from functools import cached_property

from pickcli.cell.cell import Cell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Failures
from pickcli.geometry import Array
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.coarse_path import CoarsePath
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.roadmap.trajectory_database import PayloadClass


class CoarseMotions:
    """Searches coarse motions; models of the cell are made once.

    Args:
        cell: The cell.
    """

    def __init__(self, cell: Cell) -> None:
        self.cell = cell

    @cached_property
    def checker(self) -> SceneChecker:
        """Checker with the clearance that coarse motions keep, their ends included."""
        state = self.cell.robot.tool.default_state
        return checker(CollisionModel(self.cell), state, PayloadClass.EMPTY, COARSE_RESERVE)

    @cached_property
    def _context(self) -> PlanningContext:
        return PlanningContext(self.cell)

    def find(self, home: Array, goals: Array, seed: int) -> CoarsePath | Failures:
        """Find a motion from home to any of several goals.

        Args:
            home: (n,) configuration at the start.
            goals: (G, n) configurations.
            seed: Seed of the search.

        Returns:
            The motion, or why there is none.
        """
        extra = [0.0] * len(goals)
        return plan_coarse(self._context, self.checker, home, goals, extra, seed, "from home")
