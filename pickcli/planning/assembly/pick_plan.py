"""The plan of a pick, of its timed segments with their events; and what a motion with a belt must keep."""

from __future__ import annotations

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.errors import Failures, Reason
from pickcli.io_events.event_binding import BoundEvents
from pickcli.motion.plan import Grasp, LineTracking, Plan
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.limit_check import LIMIT_TOLERANCE, measure_limits
from pickcli.timing.trajectory_sampling import states_at

RELEASE_SPEED = 0.095  # m/s from the release command on; the verifier allows 0.1
SPEED_STEP = 1e-3  # s over which a speed is measured


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
        The plan, uncertified; or the fault that it lets the item go too fast.
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
    )
    too_fast = _why_thrown(problem.context, plan)
    return plan if too_fast is None else Failures.of(too_fast)


def why_too_slow(context: PlanningContext, trajectory: Trajectory, grasp: Grasp) -> Reason | None:
    """Explain which joint is too slow for a motion to which that of a belt was added.

    Args:
        context: The cell with the arm.
        trajectory: The motion.
        grasp: The grasp that it leads to.

    Returns:
        The reason with the worst ratio to a limit; None if all limits are kept.
    """
    most = measure_limits(trajectory, context.arm.limits, context.cell.speed_scale)
    if most.time_scale <= 1.0 + LIMIT_TOLERANCE:
        return None
    worst = max(most.velocity, most.acceleration, most.jerk, key=lambda peak: peak.ratio)
    return Reason("joint too slow", str(grasp), str(worst))


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
