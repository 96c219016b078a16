"""Drops from over the rim of a walled place: the arm stops there, lets the item go, and can leave at once.

The straight way down between the walls and up again is a fifth of a cycle, and a belt does not wait. An item
that is wholly over the rim may be dropped from there if its fall to the floor is within what every drop may
have; fingers need the room to open there. Whatever lies between the walls is below the empty tool, so the
next motion begins where this one ends.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.collision.motion_segment import Mode, at_rest
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import step_costs
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.drop_placements import DROP_COST, DropPlacement, drop_placements
from pickcli.seeds import derived_rng

N_PLACEMENTS = 12  # of which all arm configurations are compared
N_MOTIONS = 8  # motions from which the best is chosen
N_RANDOM = 4  # random seeds of inverse kinematics, beside the named configurations


def plan_rim_drops(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Find configurations over the rim of the destination in which the item may be released.

    Those are taken from which the arm is soon back where it took the item, as the next one comes there.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.

    Returns:
        The motions, each at rest over its placement, the quickest way back first; or every reason for
        failure.
    """
    state, empty, destination = chosen.holding_state, chosen.grasp.tool_state, problem.destination
    without = problem.scene.without(problem.target.id)
    placements = drop_placements(without, destination, chosen.attached, state, N_PLACEMENTS, over_rim=True)
    if isinstance(placements, Failures):
        return placements
    contacts = problem.contacts.while_transferring()
    carrying = Mode(state, chosen.attached, contacts)
    opening = [Mode(MOVING, None, contacts)] if problem.context.method.closes_at_rest else []
    leaving = [*opening, Mode(empty, None, contacts)]
    Q, costs = _configurations(problem, chosen, placements, [carrying, *leaving])
    if not len(Q):
        return Failures.of(
            Reason(f"no place over the {destination.name}", "place", f"{len(placements)} tried")
        )
    costs = costs + step_costs(problem.context.space, chosen.start - Q)
    return tuple(
        PlaceMotion(
            problem.scene,
            (at_rest(SegmentKind.PLACE, Q[k], carrying),),
            tuple(at_rest(SegmentKind.DEPART, Q[k], mode) for mode in leaving),
            float(costs[k]),
        )
        for k in np.argsort(costs, kind="stable")[:N_MOTIONS].tolist()
    )


def _configurations(
    problem: PickProblem, chosen: GraspMotion, placements: Sequence[DropPlacement], modes: Sequence[Mode]
) -> tuple[Array, Array]:
    """Return the configurations (M, n) at placements that are valid in all modes, and their costs (M,), s.

    modes: the first holds the item
    """
    context = problem.context
    rng = derived_rng(problem.seed, "drop over the rim", problem.target.id)
    named = context.configurations_at(problem.destination)
    seeds = np.vstack([chosen.end, *named, context.arm.random_seeds(rng, N_RANDOM)])
    solved = [context.arm.solve(each.release, modes[0].tool_state, seeds) for each in placements]
    costs = np.repeat([DROP_COST * each.cost for each in placements], [len(Q) for Q in solved])
    Q = np.vstack(solved)
    for mode in modes:
        if len(Q):
            are_valid = context.checker_for(problem.scene, mode).are_valid(Q)
            Q, costs = Q[are_valid], costs[are_valid]
    return Q, costs
