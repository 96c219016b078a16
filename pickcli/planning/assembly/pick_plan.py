"""The plan of a pick, of its timed segments with their events; and what a motion with a belt must keep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.errors import Failures, Reason
from pickcli.io_events.event_binding import BoundEvents
from pickcli.motion.plan import Grasp, LineTracking, Plan
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.assembly.tilt_bound import why_tilted
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.limit_check import LIMIT_TOLERANCE, measure_limits, peaks
from pickcli.timing.trajectory_sampling import states_at

RELEASE_SPEED = 0.095  # m/s from the release command on; the verifier allows 0.1
SPEED_STEP = 1e-3  # s over which a speed is measured
SAME_TIME = 1e-9  # s between times that count as one


def pick_plan(
    problem: PickProblem, scene: Scene, scheduled: BoundEvents, grasp: Grasp,
    tracking: LineTracking | None = None,
) -> Plan | Failures:  # fmt: skip
    """Make the plan of a pick.

    Args:
        problem: The pick.
        scene: The scene at its start.
        scheduled: Segments, trajectory and events with their times.
        grasp: The grasp, with the load on the tool.
        tracking: The conveyor that it follows; None for none.

    Returns:
        The plan, uncertified; or the fault that it lets the item go too fast, or tilts it too far.
    """
    segments, trajectory, events = scheduled
    cell = problem.context.cell
    plan = Plan(
        query=problem.label,
        cell_fingerprint=cell.fingerprint,
        scene_hash=scene_hash(scene),
        seed=problem.seed,
        segments=segments,
        trajectory=trajectory,
        events=events,
        grasp=grasp,
        speed_scale=problem.target.item.speed_scale,
        arm=cell.arm,
        others=cell.others,
        tracking=tracking,
        upright=problem.max_tilt,
    )
    fault = _why_thrown(problem.context, plan)
    if fault is None and plan.upright is not None:
        fault = why_tilted(problem.context.arm, plan, plan.upright)
    return plan if fault is None else Failures.of(fault)


def why_too_slow(
    problem: PickProblem, trajectory: Trajectory, segments: Sequence[Segment], grasp: Grasp
) -> Reason | None:
    """Explain which joint is too slow for a motion to which that of a belt was added.

    Args:
        problem: The pick.
        trajectory: The motion.
        segments: Its segments, at whose ends it has points.
        grasp: The grasp that it leads to.

    Returns:
        The reason with the worst ratio to a limit, or with the item to the share of the velocity limits at
        which that is carried; None if all limits are kept.
    """
    limits, scale = problem.context.arm.limits, problem.context.cell.speed_scale
    most = measure_limits(trajectory, limits, scale)
    if most.time_scale > 1.0 + LIMIT_TOLERANCE:
        worst = max(most.velocity, most.acceleration, most.jerk, key=lambda peak: peak.ratio)
        return Reason("joint too slow", str(grasp), str(worst))
    held = [segment for segment in segments if segment.held is not None]
    share = scale * problem.target.item.speed_scale
    if not held or share >= 1.0:
        return None
    t = trajectory.times
    carried = (t[1:] > held[0].t_start + SAME_TIME) & (t[:-1] < held[-1].t_end - SAME_TIME)
    ratios = peaks(trajectory)[0][carried].max(axis=0) / (share * limits.velocity)
    k = int(np.argmax(ratios))
    if ratios[k] <= 1.0 + LIMIT_TOLERANCE:
        return None
    name = problem.context.arm.names[k]
    return Reason(
        "joint too slow", str(grasp), f"{name} with the item: {ratios[k]:.3f} of the velocity allowed"
    )


def _why_thrown(context: PlanningContext, plan: Plan) -> Reason | None:
    """Return the fault that the tool is too fast when the release command is given, with its speed."""
    last = next((s for s in reversed(plan.segments) if s.held is not None), None)
    for event in plan.events:
        kind = context.cell.devices[event.device].kind
        if last is None or event.t_trigger is None or kind is not DeviceKind.VALVE or event.action != "off":
            continue
        times = np.arange(event.t_trigger, last.t_end + SPEED_STEP, SPEED_STEP)
        p = context.arm.tips(states_at(plan.trajectory, times, highest=0)[0], last.tool_state)[:, :3, 3]
        speed = float(np.linalg.norm(np.diff(p, axis=0), axis=1).max(initial=0.0)) / SPEED_STEP
        if speed > RELEASE_SPEED:
            detail = f"{speed:.3f} m/s where the command is given, at most {RELEASE_SPEED}"
            return Reason("released too fast", f"{last.kind}", detail)
    return None
