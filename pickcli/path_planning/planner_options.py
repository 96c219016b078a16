"""Which sampling-based planner searches, and for how long. Importing this file does not import OMPL."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.path_planning.planner_names import PlannerName


@dataclass(frozen=True)
class PlannerOptions:
    """How a planner searches. Everything is counted, nothing is timed.

    Attributes:
        planner: Which planner.
        max_iterations: Rounds of the planner's loop, at most (RRT* uses them all).
        step: Longest edge of RRT-Connect's trees, as a share of the diagonal of the joint space. Of 0.03 to
            0.4 this finds first paths soonest among shelves, boxes and tables; longer edges fail more often
            and lead farther around. Long searches begin again with shorter ones.
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    max_iterations: int = 50000
    step: float = 0.07


DEFAULT_OPTIONS = PlannerOptions()
