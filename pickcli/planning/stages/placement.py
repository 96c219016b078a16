"""Placement of an item at its destination: dropped from above or set down, by the place's access."""

from __future__ import annotations

from pickcli.cell.tool import ACROSS, ToolState
from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import plan_drops
from pickcli.planning.stages.set_down import plan_set_downs


def placing_states(problem: PickProblem, chosen: GraspMotion) -> tuple[ToolState, ...]:
    """Return the states of the tool in which the item may be placed, the preferred one first.

    Usually the tool keeps its state. But an item taken from above is laid down flat in a bin, with the
    grasped side up, if the cup can turn to a right angle to the lance.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.

    Returns:
        One state, or two.
    """
    state = chosen.grasp.tool_state
    if problem.destination.access.is_from_above or not problem.place.access.is_from_above:
        return (state,)
    across = problem.context.cell.robot.tool.state_with_lance(ACROSS)
    return (state,) if across in (None, state) else (across, state)


def plan_placement(
    problem: PickProblem, chosen: GraspMotion, tool_state: ToolState
) -> tuple[PlaceMotion, ...] | Failures:
    """Find proven motions that release the item at its destination.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.
        tool_state: State of the tool in which the item is placed, one of ``placing_states``.

    Returns:
        The motions, the best placement first; or every reason for failure.
    """
    if problem.destination.is_open_box:
        return plan_drops(problem, chosen)
    return plan_set_downs(problem, chosen, tool_state)
