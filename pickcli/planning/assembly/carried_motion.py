"""The motion with the item from the grasp to the release, and away from there.

With the item it is one part; but the weight of an item that a cup holds by its side is taken up slowly in a
part of its own, and the arm rests where the tool changes its state with the item, and where it lets it go.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.device import DeviceKind, device_of
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_segment import scaled_segments
from pickcli.errors import Failures
from pickcli.grasping.holding import GripLoad
from pickcli.kinematics.tool_change import changing_tip
from pickcli.planning.assembly.proven_timing import carried_run, divided_lift, proven_run
from pickcli.planning.pick_motion import PickMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.timing.concatenation import RestingRun
from pickcli.timing.plan_parts import PlanPart

LET_GO = 0.05  # s at rest over a rim at the end of a plan, in which the item has left the tool


@dataclass(frozen=True, eq=False)
class CarriedMotion:
    """The timed motion with the item, and that of the empty tool after it.

    Attributes:
        parts: Its parts with the item, from the grasp to the release, where the arm rests in the end.
        away: The part after the release, a rest if the plan ends there; none of a motion without a release.
        load: The worst load on the cup.
    """

    parts: tuple[PlanPart, ...]
    away: tuple[PlanPart, ...]
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
    if not motion.placement.away:
        return CarriedMotion(tuple(parts), (), GripLoad.worst(loads))
    away = _away(context, motion.placement)
    if isinstance(away, Failures):
        return away
    parts[-1] = _at_rest_in_the_end(context, motion.placement, parts[-1])
    return CarriedMotion(tuple(parts), (away,), GripLoad.worst(loads))


def _at_rest_in_the_end(context: PlanningContext, placement: PlaceMotion, part: PlanPart) -> PlanPart:
    """Return the last part with the item, with the rest in which the item is let go.

    Off a coarse motion, which is as fast as the arm, the valve closes only once the arm rests, as the item
    would be thrown otherwise.
    """
    devices = context.cell.devices
    rest = context.method.rests(devices, context.settings.release_time).releasing
    if context.method.closes_at_rest:
        return replace(part, rest=rest, at_rest=placement.away[0])
    rest += device_of(devices, DeviceKind.VALVE).lead if placement.ends_at_release else 0.0
    return replace(part, rest=rest, at_rest=None)


def _away(context: PlanningContext, placement: PlaceMotion) -> PlanPart | Failures:
    """Time and prove the way of the empty tool from the release; from over a rim there is none."""
    if placement.ends_at_release:
        last = placement.away[-1]
        return PlanPart([last], RestingRun.of(context.arm.names, last.start, LET_GO))
    segments = scaled_segments(context.cell.speed_scale, placement.away)
    run = proven_run(context, placement.scene, segments)
    return run if isinstance(run, Failures) else PlanPart(segments, run)
