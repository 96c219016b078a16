"""Timed and proven runs: one stitched motion between two stops, by what motors exert and the cup bears."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.grasping.grasp_method import GraspMethod
from pickcli.grasping.holding import GripLoad, Hold
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.kinematics.held_body import HeldBody
from pickcli.motion.plan import Grasp
from pickcli.planning.assembly.grip_load import carried_load, path_load
from pickcli.planning.assembly.timed_motion_validation import why_not_proven
from pickcli.planning.assembly.tool_path_check import broken_promise, mended
from pickcli.planning.pick_settings import SLOWER_THAN_ALLOWED
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.timing.effort_limit import EffortLimit
from pickcli.timing.path_constraint import PathConstraint, PathConstraints
from pickcli.timing.timed_run import TimedRun, time_run
from pickcli.timing.wrench_limit import WrenchLimit

BETWEEN = 1e-3  # share of the load by which it may exceed the limit between the states that timing checks
# An item's weight is taken up slowly if the cup holds it by its side, the cup's axis sloping less than this
# sine, and the torque of the weight is at least this share of what the cup bears. Both include a little more
# than the verifier's rules, so that differences in computation leave no plan between the two.
SIDE_HOLD_SLOPE = np.sin(np.radians(45.0))
SLOW_TAKE_UP_TORQUE = 0.25
# Share of its largest effort that a motor may use by the model: the rest is for friction, for what the cup
# presses against, and for keeping to the path. The verifier allows a little more.
MOTOR_SHARE = 0.9
MENDS = 5  # times that a run is timed again, with narrower blends or slower, to keep its promises


@dataclass(frozen=True, eq=False)
class CarriedRun:
    """A timed run with an item, and the load on the cup.

    Attributes:
        run: The timed run.
        load: The worst load on the cup during the run.
    """

    run: TimedRun
    load: GripLoad


def proven_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment]
) -> TimedRun | Failures:
    """Time one run and prove the timed motion free.

    Args:
        context: The cell with the models that time and prove the run.
        scene: The planning scene.
        segments: Segments of the run, from rest to rest.

    Returns:
        The run, or every reason why it cannot be timed or proven.
    """
    checkers = _checkers(context, scene, segments)
    failures = Failures()
    for are_blends_proven in (False, True):
        run = _timed_by_motors(context, segments, checkers if are_blends_proven else None)
        if isinstance(run, Failures):
            return failures + run
        unproven = why_not_proven(run, segments, checkers)
        if unproven is None:
            return run
        failures += unproven
    return failures


def carried_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], grasp: Grasp, hold: Hold,
    most: float,
) -> CarriedRun | Failures:  # fmt: skip
    """Time one run with an item so that the cup holds under gravity and acceleration.

    If the run timed without regard to the load keeps within what the cup bears, it is returned. Else it is
    timed again, with the wrench among its limits.

    Args:
        context: The cell with the models that time and prove the run.
        scene: The planning scene.
        segments: Segments of the run, from rest to rest, all in one state of the tool.
        grasp: Grasp of the item.
        hold: The item as the cup holds it.
        most: Share of what the cup bears that the load may use.

    Returns:
        The run with the load on the cup, or every reason why the cup would not hold or the motion is not
        proven.
    """
    tool_state = segments[0].mode.tool_state
    where = str(grasp)
    waypoints = np.vstack([segment.waypoints for segment in segments])
    still = path_load(context.arm, tool_state, waypoints, hold)
    if still.ratio > most:
        at_rest = f"{still} at rest on the way, {still.ratio:.2f} of the limit"
        return Failures.of(Reason("does not hold", where, at_rest))
    cup = WrenchLimit(context.arm, tool_state, hold.body, hold.limits, most * hold.share)
    checkers = _checkers(context, scene, segments)
    limit, are_blends_proven, failures = None, False, Failures()
    while True:
        proving = checkers if are_blends_proven else None
        run = _timed_by_motors(context, segments, proving, hold.body, limit)
        if isinstance(run, Failures):
            return failures + run
        load = carried_load(context.arm, tool_state, run.trajectory, hold)
        if load.ratio > most * (1.0 + BETWEEN):
            if limit is not None:
                as_timed = f"{load} as timed, {load.ratio:.2f} of the limit"
                return failures + Reason("does not hold", where, as_timed)
            limit = cup
            continue
        unproven = why_not_proven(run, segments, checkers)
        if unproven is None:
            return CarriedRun(run, load)
        failures += unproven
        if are_blends_proven:
            return failures
        are_blends_proven = True


def divided_lift(
    arm: Arm, method: GraspMethod, lift: MotionSegment, hold: Hold
) -> tuple[MotionSegment, MotionSegment] | None:
    """Divide the lift at the end of the take-up of the weight, if that has to be slow.

    The cup gives way until it bears the weight that was on its support. So the load rises as a ramp of some
    duration T, and an item that swings on the cup with angular frequency w overshoots by up to 1 / (w T) of
    its weight (docs/simulation.md). An item below its cup loads the stiff axis, one beside it the soft tilt.

    Args:
        arm: Kinematics of the arm.
        method: How the tool holds the item.
        lift: The lift with the item, from the grasp on.
        hold: The item as the cup holds it.

    Returns:
        The take-up, at its speed, and the rest of the lift; None if the weight hardly turns the cup.
    """
    if method.take_up == 0.0:
        return None
    tips = arm.tips(lift.waypoints, lift.mode.tool_state)
    R_world_tip, p = tips[0, :3, :3], tips[:, :3, 3]
    ways = np.linalg.norm(p - p[0], axis=1)
    if (
        abs(R_world_tip[2, 2]) > SIDE_HOLD_SLOPE
        or hold.torque_at_rest(R_world_tip) < SLOW_TAKE_UP_TORQUE
        or ways[-1] <= method.take_up
    ):
        return None
    k = int(np.argmax(ways > method.take_up))
    share = (method.take_up - ways[k - 1]) / (ways[k] - ways[k - 1])
    end = lift.waypoints[k - 1] + share * (lift.waypoints[k] - lift.waypoints[k - 1])
    slow = replace(lift.limits, max_tool_speed=SLOWER_THAN_ALLOWED * method.take_up_speed)
    return (
        replace(lift, waypoints=np.vstack([lift.waypoints[:k], end]), limits=slow),
        replace(lift, waypoints=np.vstack([end, lift.waypoints[k:]])),
    )


def _checkers(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment]
) -> list[SceneChecker]:
    return [context.checker_for(scene, segment.mode) for segment in segments]


def _timed_by_motors(
    context: PlanningContext,
    segments: Sequence[MotionSegment],
    checkers: Sequence[SceneChecker] | None,
    held: HeldBody | None = None,
    limit: PathConstraint | None = None,
) -> TimedRun | Failures:
    """Time a run; if its motors are too weak for that, time it again with their efforts among its limits."""
    run = _timed(context, segments, checkers, limit)
    robot = context.cell.robot
    most = MOTOR_SHARE * np.array([robot.motor_forces[name] for name in robot.joint_names])
    motors = EffortLimit(ArmDynamics(context.arm, segments[0].mode.tool_state, held), most)
    if isinstance(run, Failures) or motors.is_kept(run.trajectory):
        return run
    return _timed(context, segments, checkers, motors if limit is None else PathConstraints((limit, motors)))


def _timed(
    context: PlanningContext,
    segments: Sequence[MotionSegment],
    checkers: Sequence[SceneChecker] | None,
    limit: PathConstraint | None = None,
) -> TimedRun | Failures:
    """Time a run so that it keeps its promises of lines and contact; else return the one it still breaks."""
    coming = context.method.contact_limit
    run = _timed_once(context, segments, checkers, limit)
    for _ in range(MENDS):
        if isinstance(run, Failures) or (better := mended(context.arm, coming, run, segments)) is None:
            return run
        segments = better
        run = _timed_once(context, segments, checkers, limit)
    if isinstance(run, Failures):
        return run
    broken = broken_promise(context.arm, coming, run, segments)
    return run if broken is None else Failures.of(broken)


def _timed_once(
    context: PlanningContext,
    segments: Sequence[MotionSegment],
    checkers: Sequence[SceneChecker] | None,
    limit: PathConstraint | None,
) -> TimedRun | Failures:
    """Time a run once, with blends as wide as requested, or only as wide as the checkers prove free.

    Requested blends are nearly always free and are proven afterwards, with their timing; the other way costs
    an additional proof.
    """
    most = context.cell.max_tool_speed
    cap = None if most is None else SLOWER_THAN_ALLOWED * most
    capped = [
        replace(s, limits=replace(s.limits, max_tool_speed=_lower(s.limits.max_tool_speed, cap)))
        for s in segments
    ]

    def is_free(part: int, chords: Array, slack: Array) -> int:
        assert checkers is not None
        return checkers[part].first_blocked_edge(chords, slack)

    # The cell's speed limit holds for every tool state.
    states = [segments[-1].mode.tool_state] if most is None else context.cell.robot.tool.states

    def tool_speed(Q: Array, dQ: Array) -> Array:
        return np.asarray(np.max([_tip_travel(context.arm, Q, dQ, state) for state in states], axis=0))

    arm, blends = context.arm, None if checkers is None else is_free
    try:
        return time_run(arm.names, capped, arm.limits, blends, tool_speed, constraint=limit)
    except NoPlanError as error:
        return error.failures


def _lower(*speeds: float | None) -> float | None:
    """Return the lowest of several speed limits, m/s; None stands for no limit."""
    return min((speed for speed in speeds if speed is not None), default=None)


def _tip_travel(arm: Arm, Q: Array, dQ: Array, tool_state: ToolState) -> Array:
    """Return (M,) m of tip travel per unit of a path, at Q (M, n) in the direction of dQ (M, n)."""
    return np.asarray(np.linalg.norm(arm.tip_motion(Q, dQ, np.zeros_like(Q), tool_state).velocity, axis=1))
