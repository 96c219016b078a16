"""The release of an item and what follows it: the way from there, or rest where the plan ends over a rim."""

from __future__ import annotations

from pickcli.cell.device import DeviceKind, device_of
from pickcli.collision.motion_segment import scaled_segments
from pickcli.errors import Failures
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.pick_motion import PlaceMotion
from pickcli.planning.planning_context import PlanningContext
from pickcli.timing.concatenation import RestingRun
from pickcli.timing.plan_parts import PlanPart

LET_GO = 0.05  # s at rest over a rim at the end of a plan, in which the item has left the cup


def time_at_release(context: PlanningContext, placement: PlaceMotion) -> float:
    """Return how long the arm rests where it lets an item go.

    Args:
        context: The cell with its devices.
        placement: Motion of the placement.

    Returns:
        s. Off a coarse motion, which is as fast as the arm, the valve closes only once the arm rests, as the
        item would be thrown otherwise.
    """
    devices = context.cell.devices
    rest = context.method.rests(devices, context.settings.release_time).releasing
    return rest + (device_of(devices, DeviceKind.VALVE).lead if placement.ends_at_release else 0.0)


def motion_after_release(context: PlanningContext, placement: PlaceMotion) -> PlanPart | Failures:
    """Time and prove the way of the empty tool from where the item was released.

    Args:
        context: The cell with the models that time and prove it.
        placement: Motion of the placement.

    Returns:
        The way; a rest if the plan ends there; every reason if it cannot be timed or proven.
    """
    away = scaled_segments(context.cell.speed_scale, placement.away)
    if placement.ends_at_release:
        return PlanPart(placement.away, RestingRun.of(context.arm.names, placement.away[0].start, LET_GO))
    run = proven_run(context, placement.scene, away)
    return run if isinstance(run, Failures) else PlanPart(away, run)
