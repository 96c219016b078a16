"""Letting an item go at its destination, by the way that leads into that."""

from __future__ import annotations

from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import plan_drops
from pickcli.planning.stages.floor_placements import plan_set_downs


def plan_placement(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Find motions that let the item go at its destination, all proven.

    Args:
        problem: The pick.
        chosen: How the item is held.

    Returns:
        The motions, the best placement first; or every reason why there is none.
    """
    if problem.destination.is_open_box:
        return plan_drops(problem, chosen)
    return plan_set_downs(problem, chosen)
