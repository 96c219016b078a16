"""Grasp candidates of a region query, found from the arm instead of from a list of poses.

Solutions of inverse kinematics for poses at which the tool has room are projected onto what of an envelope is
nearest in joint space to where the arm waits in front of the place (Krug et al., RA-L 2016, section III-A).
They are candidates like any others: every line to them and out is proven afterwards.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.motion_segment import Mode
from pickcli.geometry import Array, inverse
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.grasp_target import CandidateSet
from pickcli.planning.item_envelopes import without_envelopes
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.region_query import RegionChecks, RegionProblem, RegionSearch, region_query
from pickcli.planning.stages.tool_clearance import room_for_tool

# Of an envelope without any room, poses that are sampled, and of these the clearest, which are tried all the
# same, to tell what is in the way.
N_LOOKED_AT, N_TOLD = 40, 4


def region_candidates(
    problem: PickProblem, search: RegionSearch, ways_out: Sequence[Array], rng: np.random.Generator,
    *, explains: bool = True,
) -> CandidateSet:  # fmt: skip
    """Find grasp candidates in the envelopes of the target, in every state of the tool.

    Args:
        problem: The pick.
        search: How much is tried in each envelope.
        ways_out: Displacements (K, 4, 4) of each way out for the target as a free flyer, at least one.
        rng: Source of the sampled poses and seeds.
        explains: Whether an envelope without any room yields its clearest poses, which fail later with what
            is in the way.

    Returns:
        Candidates, and why others were dropped.
    """
    found = [
        _candidates_in(problem, envelope, state, search, ways_out, rng, explains)
        for state in problem.context.cell.robot.tool.states
        for envelope in _envelopes(problem, state)
    ]
    if not found:
        return CandidateSet((), (without_envelopes(problem.target),))
    batches = (batch for each in found for batch in each.batches)
    return CandidateSet(tuple(batches), tuple(reason for each in found for reason in each.rejected))


def _envelopes(problem: PickProblem, state: ToolState) -> tuple[Envelope, ...]:
    """Return the envelopes of the target in one state of the tool."""
    return problem.context.method.envelopes(problem.target.item, problem.tool_checker(Mode(state)).depth)


def _candidates_in(
    problem: PickProblem, envelope: Envelope, state: ToolState, search: RegionSearch,
    ways_out: Sequence[Array], rng: np.random.Generator, explains: bool,
) -> CandidateSet:  # fmt: skip
    """Return the candidates in one envelope, or its clearest poses if the arm reaches none with room."""
    context, T_world_item = problem.context, problem.target.T_world_item
    mode = context.method.at_target(problem.contacts, envelope.face, state)[0]
    has_room = room_for_tool(problem, envelope.face, state, ways_out)
    asked = RegionProblem((envelope,), T_world_item, state, _waiting(problem))
    checks = RegionChecks(has_room, context.checker_for(problem.scene, mode))
    found = region_query(context.arm, asked, checks, rng, search)
    T_item_tip = inverse(T_world_item) @ context.arm.tips(found.Q, state)
    if len(found.Q) == 0:
        if not explains:
            return CandidateSet(())
        T_item_tip = _clearest(problem, mode, envelope.sample(rng, N_LOOKED_AT))
    most = problem.settings.load_ratio
    return context.method.grasps_in(problem.grasp_target, envelope, state, T_item_tip, most)


def _waiting(problem: PickProblem) -> Array:
    """Return the configuration (n,) near which candidates are sought: in front of the place, if named."""
    context = problem.context
    named = context.configurations_at(problem.place)
    return named[0] if named else np.mean(context.arm.limits.window, axis=0)


def _clearest(problem: PickProblem, mode: Mode, T_item_tip: Array) -> Array:
    """Return the poses (N_TOLD, 4, 4) of some (N, 4, 4) at which the tool is farthest from everything."""
    tool = problem.tool_checker(mode)
    chosen, _ = tool.clearest(tool.displacements(problem.target.T_world_item @ T_item_tip), N_TOLD)
    return np.asarray(T_item_tip[chosen])
