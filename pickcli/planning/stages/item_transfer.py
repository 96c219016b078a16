"""Ways with the item to its placement: in one state of the tool, or with a change of state on the way.

An item that is taken from above with the lance in line with the cup is laid down flat in a bin with the lance
across it, as Delft's gripper did. The tool changes its state where the volume that cup and item sweep is
free, and where the cup holds the item in every position between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.device import device_of
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_segment import Mode, at_rest
from pickcli.collision.motion_validator import explain_each
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.kinematics.tool_change import changing_tip
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.seeds import derived_seed


def plan_direct_transfer(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Transfer | Failures:
    """Find a transfer to the placement with the fastest complete motion, in one state of the tool.

    Args:
        problem: The pick.
        taking: The motion that takes the item.
        placements: Placements in the state of the tool in which it is taken.

    Returns:
        The transfer, or the reasons for failure.
    """
    mode = Mode(taking.holding_state, taking.attached, problem.contacts.while_transferring(), COARSE_RESERVE)
    goals = np.stack([placement.start for placement in placements])
    extra = [placement.cost for placement in placements]
    seed = derived_seed(problem.seed, "transfer", problem.target.id)
    checker = problem.context.checker_for(problem.scene, mode)
    coarse = plan_coarse(problem.context, checker, taking.end, goals, extra, seed, "transfer")
    if isinstance(coarse, Failures):
        return coarse
    segment = coarse.segment(SegmentKind.TRANSFER, replace(mode, reserve=0.0))
    return Transfer((segment,), placements[coarse.goal], coarse.experience)


def plan_transfer_with_tool_change(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Transfer | Failures:
    """Find a transfer to one of several placements that hold the item in another state of the tool.

    Args:
        problem: The pick.
        taking: The motion that takes the item.
        placements: Placements, all in one state of the tool, which is not that of ``taking``.

    Returns:
        The transfer: to where the tool changes its state, the change, and on to the placement; or the reasons
        for failure.
    """
    context, target = problem.context, problem.target
    if target.item.hollow_at(taking.grasp.face) is not None:
        why = "the lance is proven to stay in the hollow, or over it, in one state of the tool"
        return Failures.of(Reason("tool cannot turn", f"{target.id}, face {taking.grasp.face}", why))
    before, after = taking.holding_state, placements[0].holding_state
    contacts = problem.contacts.while_transferring()
    starts = np.stack([placement.start for placement in placements])
    costs = [placement.cost for placement in placements]
    places = _places_to_change(problem, taking, placements)
    if isinstance(places, Failures):
        return places
    onward = [min(p.cost + _straight(problem, q, p.start) for p in placements) for q in places]
    modes = [Mode(state, taking.attached, contacts, COARSE_RESERVE) for state in (before, after)]
    seeds = [derived_seed(problem.seed, "transfer", target.id, state) for state in (before, after)]
    checkers = [context.checker_for(problem.scene, mode) for mode in modes]
    to_change = plan_coarse(context, checkers[0], taking.end, places, onward, seeds[0], "transfer")
    if isinstance(to_change, Failures):
        return to_change
    q = places[to_change.goal]
    to_place = plan_coarse(context, checkers[1], q, starts, costs, seeds[1], "transfer with the changed tool")
    if isinstance(to_place, Failures):
        return to_place
    segments = (
        to_change.segment(SegmentKind.TRANSFER, replace(modes[0], reserve=0.0)),
        at_rest(SegmentKind.TRANSFER, q, Mode(MOVING, taking.attached, contacts)),
        to_place.segment(SegmentKind.TRANSFER, replace(modes[1], reserve=0.0)),
    )
    experience = (*to_change.experience, *to_place.experience)
    return Transfer(segments, placements[to_place.goal], experience)


def _places_to_change(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Array | Failures:
    """Return (K, n) configurations in which the tool can change its state with the item.

    Tried are the end of the retreat, the starts of the placements, and the cell's named configurations.
    """
    context = problem.context
    changing = Mode(MOVING, taking.attached, problem.contacts.while_transferring())
    named = [each.q for each in context.cell.configurations.values()]
    Q = np.stack([taking.end, *(placement.start for placement in placements), *named])
    checker = context.checker_for(problem.scene, changing)
    are_free = checker.are_valid(Q)
    free, no_room = Q[are_free], "no room to change the tool's state"
    blocked = explain_each(checker, Q[~are_free], no_room, "transfer")
    if not len(free):
        return blocked
    hold = problem.hold(taking.grasp.face, taking.attached.T_tip_item)
    states = taking.holding_state, placements[0].holding_state
    duration = device_of(context.cell.devices, context.cell.robot.tool.mover).lead
    loads = [hold.in_motion(changing_tip(context.arm, q, *states, duration)).ratio for q in free]
    most = context.settings.load_ratio
    held = [q for q, load in zip(free, loads, strict=True) if load <= most]
    if not held:
        least = f"{min(loads):.2f} of what the cup bears, {most:g} allowed"
        return blocked + Reason("does not hold", "change of the tool's state", least)
    return np.stack(held)


def _straight(problem: PickProblem, q: Array, q_goal: Array) -> float:
    return estimated_duration(problem.context.space, np.stack([q, q_goal]))
