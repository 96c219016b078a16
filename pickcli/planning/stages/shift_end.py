"""End of a shift: the item is put down in its place, and the empty tool leaves it."""

from __future__ import annotations

import numpy as np

from pickcli.cartesian.corridor import Corridor, corridor_transforms
from pickcli.errors import Failures
from pickcli.geometry import Array, inverse
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem, once_per_problem
from pickcli.planning.stages.grasp_motion import plan_motion_down
from pickcli.planning.stages.set_down import set_down
from pickcli.planning.stages.tool_clearance import tool_lines


@once_per_problem
def shift_transforms(problem: PickProblem) -> Array:
    """Return the displacements of a shift, as they move the tool.

    Args:
        problem: The shift.

    Returns:
        (2, 4, 4) transforms as from ``corridor_transforms``: to the end of the lift, and to over the end.
    """
    assert problem.shift is not None
    way = Corridor(problem.shift.lifted, problem.shift.over, ())
    return corridor_transforms(way, problem.T_world_entry, problem.target.T_world_item[:3, 3])


def plan_end_of_shift(problem: PickProblem, taking: GraspMotion) -> PlaceMotion | Failures:
    """Plan how the item is put down and left, from the end of the motion with it.

    Args:
        problem: The shift.
        taking: Motion to the item and with it, up to over the end.

    Returns:
        The motion, or every reason for failure.
    """
    back, T_over = _back(problem), shift_transforms(problem)[-1]
    T_over_item = T_over @ problem.target.T_world_item
    up = T_over_item @ inverse(back.target.T_world_item)
    lines = tool_lines(back, taking.grasp, (np.stack([up, up]),))
    if isinstance(lines, Failures):
        return lines
    over = T_over_item @ inverse(taking.attached.T_tip_item)
    picked = plan_motion_down(back, lines, over, taking.end)
    return picked if isinstance(picked, Failures) else set_down(back, picked, 0.0)


@once_per_problem
def _back(problem: PickProblem) -> PickProblem:
    """Return the pick from the end of a shift."""
    assert problem.shift is not None
    return problem.back_from(problem.shift.placed)
