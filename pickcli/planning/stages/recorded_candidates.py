"""Grasp candidates that were recorded: those of the target's kind, if they lie in one of its envelopes.

They are candidates like any others: what they bear is computed, and every line to them and out is proven.
"""

from __future__ import annotations

from collections.abc import Sequence

from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import NO_CONTACTS
from pickcli.errors import Reason
from pickcli.grasping.grasp_target import CandidateSet
from pickcli.grasping.recorded_grasp import RecordedGrasp
from pickcli.planning.pick_problem import PickProblem

NO_RECORDED = "no recorded grasp"
IN_ENVELOPE = 1e-3  # m, or difference of cosines, by which a recorded pose may be outside of an envelope


def recorded_candidates(problem: PickProblem, recorded: Sequence[RecordedGrasp]) -> CandidateSet:
    """Make candidates of recorded grasps.

    Args:
        problem: The pick.
        recorded: Grasps of any items.

    Returns:
        Candidates, and why others were dropped.
    """
    item, target = problem.target.item, problem.target.id
    mine = [grasp for grasp in recorded if (grasp.item, grasp.year) == (item.name, item.year)]
    if not mine:
        reason = Reason(NO_RECORDED, target, f"none of {len(recorded)} is of {item.name} of {item.year}")
        return CandidateSet((), (reason,))
    states = {state.name: state for state in problem.context.cell.robot.tool.states}
    found = [_candidates(problem, grasp, states[grasp.tool_state]) for grasp in mine]
    batches = (batch for each in found for batch in each.batches)
    return CandidateSet(tuple(batches), tuple(reason for each in found for reason in each.rejected))


def _candidates(problem: PickProblem, grasp: RecordedGrasp, state: ToolState) -> CandidateSet:
    context, T, most = problem.context, grasp.T_item_grasp[None], problem.settings.load_ratio
    axes = problem.T_world_entry[:3, :3]
    depth = context.checkers.tool(problem.scene, state, axes, NO_CONTACTS).depth
    for envelope in context.method.envelopes(problem.target.item, depth):
        if envelope.contains(T, IN_ENVELOPE)[0]:
            found = context.method.grasps_in(problem.grasp_target, envelope, state, T, most)
            if found.batches or found.rejected:
                return found
    detail = f"{grasp.source or 'it'}: where the tool is, it cannot hold the item by any of its faces"
    return CandidateSet((), (Reason("recorded grasp off the item", problem.target.id, detail),))
