"""Placement of an item at its destination: dropped from above or set down, by the place's access."""

from __future__ import annotations

from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import plan_drops
from pickcli.planning.stages.set_down import plan_set_downs


def plan_placement(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Find proven motions that release the item at its destination.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.

    Returns:
        The motions, the best placement first; or every reason for failure.
    """
    if problem.destination.is_open_box:
        return plan_drops(problem, chosen)
    return plan_set_downs(problem, chosen)
