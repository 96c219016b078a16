"""Picks that undo a placement: one from each free place, in each orientation, in which an item may lie."""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import ACROSS, ToolState
from pickcli.errors import Failures
from pickcli.geometry import Array, least_turn, levelled, rotation_axis_angle
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_problem import PickProblem, once_per_problem
from pickcli.planning.stages.floor_placements import HOVER, floor_placements
from pickcli.planning.stages.stacked_placements import stacked_placements
from pickcli.planning.stages.stated_placement import pick_from_stated_place

SAME_TURN = 9  # decimals: orientations that differ only by rounding have the same placements
# Axes, in the entry frame, of a tool frame below a level lance that points into the place.
LANCE_INWARD = np.array([[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]])
TURNED = np.radians(6.0)  # rad, turn of an item in a box as the cup is pressed on from a side
FROM_ABOVE = np.cos(np.radians(20.0))  # of the cup's axis, which turns an item little as it is pressed on
MOST_HOVER = 0.012  # m; the verifier allows 20 mm
QUARTER_TURNS = (0.0, np.pi / 2, np.pi, -np.pi / 2)  # rad


def picks_back(
    problem: PickProblem, grasp: Grasp, tool_state: ToolState
) -> tuple[tuple[PickProblem, ...], Failures]:
    """Return the picks that would take the target back from where it may be set down.

    Args:
        problem: The pick.
        grasp: Grasp of the target.
        tool_state: State of the tool in which the target is set down.

    Returns:
        One pick for each free placement, the best first for each orientation, or from the one that the query
        states; and why there are none in other orientations.
    """
    if problem.at is not None:
        stated = pick_from_stated_place(problem, problem.at)
        return ((), stated) if isinstance(stated, Failures) else ((stated,), Failures())
    found: list[PickProblem] = []
    failures = Failures()
    for R_place_item in _orientations(problem, grasp, tool_state):
        orientation = tuple(levelled(R_place_item).round(SAME_TURN).ravel().tolist())
        there = _picks_from(problem, orientation, _hover(problem, grasp))
        if isinstance(there, Failures):
            failures += there
        else:
            found += there
    return tuple(found), failures


@once_per_problem
def _picks_from(
    problem: PickProblem, orientation: tuple[float, ...], hover: float
) -> tuple[PickProblem, ...] | Failures:
    """Return the picks from all placements with an orientation, given row by row, at m over the floor."""
    R_place_item = np.reshape(orientation, (3, 3))
    placed = floor_placements(
        problem.context, problem.scene, problem.target, R_place_item, problem.destination, hover=hover
    )
    if isinstance(placed, Failures) and _may_stack(problem):
        on_others = stacked_placements(
            problem.context, problem.scene, problem.target, R_place_item, problem.destination, hover=hover
        )
        placed = placed + on_others if isinstance(on_others, Failures) else on_others
    return placed if isinstance(placed, Failures) else tuple(map(problem.back_from, placed))


def _may_stack(problem: PickProblem) -> bool:
    """Whether the target may be set down on others: out of a box into a bin, as nothing is picked there."""
    return problem.place.is_open_box and not problem.destination.access.is_from_above


def _hover(problem: PickProblem, grasp: Grasp) -> float:
    """Return m over the floor at which the target is released.

    What the cup is pressed on from a side in a box turns with it: in simulation by 5.5 to 7.6 degrees. A
    corner that met the floor early would pull it off the cup.
    """
    axis = problem.target.T_world_item[:3, :3] @ grasp.T_item_tip[:3, 2]
    if not problem.place.access.is_from_above or abs(float(axis[2])) > FROM_ABOVE:
        return HOVER
    return min(HOVER + float(np.sin(TURNED)) * problem.target.item.shape.bounding_radius, MOST_HOVER)


def _orientations(problem: PickProblem, grasp: Grasp, tool_state: ToolState) -> list[Array]:
    """Return orientations (3, 3) for the target at its destination; by default its current one.

    An item taken from above is put into a bin with the grasped side to the front, turned about the way in by
    any quarter turn; or with that side up, if the lance is across the cup there. On a table that side is up.
    """
    if problem.destination.access.is_from_above:
        return _hanging(problem, grasp)
    R_entry_item = problem.T_entry_item[:3, :3]
    if not problem.place.access.is_from_above:
        return [R_entry_item]
    if problem.context.cell.robot.tool.has_lance(tool_state, ACROSS):
        return [LANCE_INWARD @ grasp.T_item_tip[:3, :3].T]
    inward = np.array([1.0, 0.0, 0.0])
    straight = least_turn(R_entry_item @ grasp.T_item_tip[:3, 2], inward) @ R_entry_item
    return [rotation_axis_angle(inward, turn) @ straight for turn in QUARTER_TURNS]


def _hanging(problem: PickProblem, grasp: Grasp) -> list[Array]:
    """Return orientations for a cup that points down: the least turn, and quarter turns from it."""
    R_place_world = problem.scene.T_world_place(problem.destination)[:3, :3].T
    R_place_item = R_place_world @ problem.target.T_world_item[:3, :3]
    down = np.array([0.0, 0.0, -1.0])
    upright = least_turn(R_place_item @ grasp.T_item_tip[:3, 2], down) @ R_place_item
    return [rotation_axis_angle(down, turn) @ upright for turn in QUARTER_TURNS]
