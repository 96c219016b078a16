"""Choice and effort of the sampling-based planner. Importing this file does not import OMPL."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.path_planning.planner_names import PlannerName


@dataclass(frozen=True)
class PlannerOptions:
    """Options of a planner. All limits are counts, not times.

    Attributes:
        planner: Name of the planner.
        max_iterations: Most iterations of the planner's loop (RRT* uses them all).
        step: Longest edge of RRT-Connect's trees, as a share of the diagonal of the joint space. Of 0.03 to
            0.4 this finds first paths soonest among shelves, boxes and tables; longer edges fail more often
            and lead to longer paths. Long searches restart with shorter ones.
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    max_iterations: int = 50000
    step: float = 0.07


DEFAULT_OPTIONS = PlannerOptions()
