"""The motion with the item from the grasp to the release, timed in parts between which the arm rests.

It is one part; but the weight of an item that a cup holds by its side is taken up slowly in a part of its
own, and the arm rests where the tool changes its state with the item.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.device import device_of
from pickcli.cell.tool import MOVING
from pickcli.errors import Failures
from pickcli.grasping.holding import GripLoad
from pickcli.kinematics.tool_change import changing_tip
from pickcli.planning.assembly.proven_timing import carried_run, divided_lift
from pickcli.planning.pick_motion import PickMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.timing.plan_parts import PlanPart


@dataclass(frozen=True, eq=False)
class CarriedMotion:
    """The timed motion with the item.

    Attributes:
        parts: Its parts, from the grasp to the release.
        load: The worst load on the cup.
    """

    parts: tuple[PlanPart, ...]
    load: GripLoad


def carried_motion(problem: PickProblem, motion: PickMotion) -> CarriedMotion | Failures:
    """Time the motion with the item.

    Args:
        problem: The pick.
        motion: Its segments, not yet timed.

    Returns:
        The timed motion; or every reason, if the cup cannot hold at any speed or a proof fails.
    """
    context, item, taking = problem.context, problem.target.item, motion.taking
    hold = problem.hold(taking.grasp.face, taking.attached.T_tip_item)
    segments = [
        segment.scaled(context.cell.speed_scale).scaled(item.speed_scale)
        for segment in (*taking.outward, *motion.transfer.segments, *motion.placement.inward)
        if segment.has_length or segment.mode.tool_state == MOVING
    ]
    change = next((k for k, segment in enumerate(segments) if segment.mode.tool_state == MOVING), None)
    before, after = (segments, []) if change is None else (segments[:change], segments[change + 1 :])
    lift = divided_lift(context.arm, context.method, before[0], hold)
    divided = [before] if lift is None else [[lift[0]], [lift[1], *before[1:]]]
    parts: list[PlanPart] = []
    loads: list[GripLoad] = []
    for some in (*divided, after):
        if not some:
            continue
        pushes = any(segment.mode.contacts.pushed for segment in some)
        most = (problem.settings if pushes else context.settings).load_ratio
        timed = carried_run(context, problem.scene, some, taking.grasp, hold, most)
        if isinstance(timed, Failures):
            return timed
        parts.append(PlanPart(some, timed.run, continues=len(parts) + 1 < len(divided)))
        loads.append(timed.load)
    if change is not None:
        duration = device_of(context.cell.devices, context.cell.robot.tool.mover).lead
        states = before[-1].mode.tool_state, after[0].mode.tool_state
        loads.append(hold.in_motion(changing_tip(context.arm, after[0].start, *states, duration)))
        until_change = len(divided) - 1
        parts[until_change] = replace(parts[until_change], rest=duration, at_rest=segments[change])
    return CarriedMotion(tuple(parts), GripLoad.worst(loads))
