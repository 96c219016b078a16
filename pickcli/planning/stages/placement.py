"""Placements of an item at its destination: dropped from above or set down, by the place's access."""

from __future__ import annotations

from collections.abc import Iterator

from pickcli.cell.tool import ACROSS, ToolState
from pickcli.errors import Failures
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import plan_drops
from pickcli.planning.stages.rim_drops import plan_rim_drops
from pickcli.planning.stages.set_down import plan_set_downs


def plan_placements(
    problem: PickProblem, chosen: GraspMotion
) -> Iterator[tuple[PlaceMotion, ...] | Failures]:
    """Find proven motions that release the item at its destination, first in the preferred tool state.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.

    Yields:
        For each state of the tool in which the item may be placed: the motions, the best placement first; or
        every reason for failure.
    """
    if problem.destination.is_open_box:
        if problem.over_rim:
            yield plan_rim_drops(problem, chosen)
        yield plan_drops(problem, chosen)
        return
    for tool_state in _placing_states(problem, chosen):
        yield plan_set_downs(problem, chosen, tool_state)


def _placing_states(problem: PickProblem, chosen: GraspMotion) -> tuple[ToolState, ...]:
    """Return the states of the tool in which the item may be set down, the preferred one first.

    Usually the tool keeps its state. But an item taken from above is laid down flat in a bin, with the
    grasped side up, if the cup can turn to a right angle to the lance.
    """
    state = chosen.grasp.tool_state
    if problem.destination.access.is_from_above or not problem.place.access.is_from_above:
        return (state,)
    across = problem.context.cell.robot.tool.state_with_lance(ACROSS)
    return (state,) if across in (None, state) else (across, state)
