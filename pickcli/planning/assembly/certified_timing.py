"""Runs that are timed and proven: one stitched motion between two stops, timed under what the cup bears."""

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
from pickcli.motion.plan import Grasp
from pickcli.planning.assembly.grip_load import carried_load, path_load
from pickcli.planning.assembly.timed_motion_validation import prove
from pickcli.planning.assembly.tool_path_check import broken_promise, mended
from pickcli.planning.pick_settings import SLOWER_THAN_ALLOWED
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.timing.path_constraint import PathConstraint
from pickcli.timing.timed_run import TimedRun, time_run
from pickcli.timing.wrench_limit import WrenchLimit

BETWEEN = 1e-3  # share of the load that may be added between the states at which the timing checked it
LEVEL = np.cos(np.pi / 4)  # sine of a cup's slope under which it holds an item by its side
TURNS = 0.25  # share of what the cup bears from which on the weight's torque has to be taken up slowly
MENDS = 5  # times that a run is timed, with narrower blends or slower, to keep what is promised of lines


@dataclass(frozen=True, eq=False)
class CertifiedRun:
    """A run with an item, and what the cup feels.

    Attributes:
        run: The timed run.
        load: The worst load on the cup over it.
    """

    run: TimedRun
    load: GripLoad


def proven_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment]
) -> TimedRun | Failures:
    """One run whose timed motion is proven free.

    Args:
        context: The cell with the models that time and prove the run.
        scene: What stands around it.
        segments: Segments of the run, from rest to rest.

    Returns:
        The run, or every reason why it cannot be timed or proven.
    """
    checkers = _checkers(context, scene, segments)
    failures = Failures()
    for are_blends_proven in (False, True):
        run = _timed(context, segments, checkers if are_blends_proven else None)
        if isinstance(run, Failures):
            return failures + run
        unproven = prove(run, segments, checkers)
        if unproven is None:
            return run
        failures += unproven
    return failures


def carried_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], grasp: Grasp, hold: Hold
) -> CertifiedRun | Failures:
    """One run with an item, nowhere faster than the cup holds under gravity and acceleration.

    Where the motion without a load keeps what the cup bears, that is the answer. Else it is timed again, with
    the wrench among its limits.

    Args:
        context: The cell with the models that time and prove the run.
        scene: What stands around it.
        segments: Segments of the run, from rest to rest.
        grasp: Where the cup sits on the item.
        hold: The item as it hangs in the cup.

    Returns:
        The run with the load on the cup, or every reason why the cup would not hold or the motion is not
        proven.
    """
    most = context.settings.load_ratio
    where = str(grasp)
    waypoints = np.vstack([segment.waypoints for segment in segments])
    still = path_load(context.arm, grasp.tool_state, waypoints, hold)
    if still.ratio > most:
        at_rest = f"{still} at rest on the way, {still.ratio:.2f} of the limit"
        return Failures.of(Reason("does not hold", where, at_rest))
    cup = WrenchLimit(context.arm, grasp.tool_state, hold.body, hold.limits, most * hold.share)
    checkers = _checkers(context, scene, segments)
    limit, are_blends_proven, failures = None, False, Failures()
    while True:
        run = _timed(context, segments, checkers if are_blends_proven else None, limit)
        if isinstance(run, Failures):
            return failures + run
        load = carried_load(context.arm, grasp.tool_state, run.trajectory, hold)
        if load.ratio > most * (1.0 + BETWEEN):
            if limit is not None:
                as_timed = f"{load} as timed, {load.ratio:.2f} of the limit"
                return failures + Reason("does not hold", where, as_timed)
            limit = cup
            continue
        unproven = prove(run, segments, checkers)
        if unproven is None:
            return CertifiedRun(run, load)
        failures += unproven
        if are_blends_proven:
            return failures
        are_blends_proven = True


def carried_runs(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], grasp: Grasp, hold: Hold
) -> tuple[CertifiedRun, ...] | Failures:
    """The motion with the item: where that must be slow, the take-up of its weight is a run by itself.

    Args:
        context: The cell with the models that time and prove the runs.
        scene: What stands around them.
        segments: From where the item was grasped to where it is let go.
        grasp: Where the cup sits on the item.
        hold: The item as it hangs in the cup.

    Returns:
        One run, or two of which the first ends within the first segment; or every reason why there is none.
    """
    divided = divided_lift(context.arm, context.method, segments[0], hold)
    parts = (segments,) if divided is None else (divided[:1], (divided[1], *segments[1:]))
    runs: list[CertifiedRun] = []
    for part in parts:
        run = carried_run(context, scene, part, grasp, hold)
        if isinstance(run, Failures):
            return run
        runs.append(run)
    return tuple(runs)


def divided_lift(
    arm: Arm, method: GraspMethod, lift: MotionSegment, hold: Hold
) -> tuple[MotionSegment, MotionSegment] | None:
    """Divide the lift where the cup has taken the weight up, if it has to do so slowly.

    The cup gives way until it bears what stood on its support. So the weight comes on as a ramp of some
    duration T, and an item that swings on the cup at the rate w overshoots it by up to 1 / (w T) of itself
    (docs/simulation.md). Under its cup an item hangs by the stiff axis, beside it by the soft tilt.

    Args:
        arm: Kinematics of the arm.
        method: How the tool holds the item.
        lift: With the item in the cup, from where it was grasped.
        hold: The item as it hangs in the cup.

    Returns:
        The take-up, at its speed, and the rest of the lift; None where the weight hardly turns the cup.
    """
    if method.take_up == 0.0:
        return None
    tips = arm.tips(lift.waypoints, lift.mode.tool_state)
    R_world_tip, p = tips[0, :3, :3], tips[:, :3, 3]
    ways = np.linalg.norm(p - p[0], axis=1)
    if (
        abs(R_world_tip[2, 2]) > LEVEL
        or hold.torque_at_rest(R_world_tip) < TURNS
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


def _timed(
    context: PlanningContext,
    segments: Sequence[MotionSegment],
    checkers: Sequence[SceneChecker] | None,
    limit: PathConstraint | None = None,
) -> TimedRun | Failures:
    """One run that keeps what is promised of lines and contact, or what it breaks however it is mended."""
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
    """One run, with corners as round as asked for, or only as round as the checkers prove free.

    The former is nearly always free and is proven afterwards, with its time; the latter costs another proof.
    """
    most = context.cell.max_tool_speed
    cap = None if most is None else SLOWER_THAN_ALLOWED * most
    capped = [
        replace(s, limits=replace(s.limits, max_tool_speed=_lower(s.limits.max_tool_speed, cap)))
        for s in segments
    ]

    def is_free(part: int, chords: Array, slack: Array) -> int:
        assert checkers is not None
        return checkers[part].first_invalid_edge(chords, slack)

    # A cell's own limit holds for both places of the cup, whichever it is in.
    states = [segments[-1].mode.tool_state] if most is None else context.cell.robot.tool.states

    def tool_speed(Q: Array, dQ: Array) -> Array:
        return np.asarray(np.max([_tip_travel(context.arm, Q, dQ, state) for state in states], axis=0))

    arm, blends = context.arm, None if checkers is None else is_free
    try:
        return time_run(arm.names, capped, arm.limits, blends, tool_speed, constraint=limit)
    except NoPlanError as error:
        return error.failures


def _lower(*speeds: float | None) -> float | None:
    """The lowest of several limits of speed, m/s; None is no limit."""
    return min((speed for speed in speeds if speed is not None), default=None)


def _tip_travel(arm: Arm, Q: Array, dQ: Array, tool_state: ToolState) -> Array:
    """(M,) m that the tip goes per unit of a path, at Q (M, n) in the direction of dQ (M, n)."""
    return np.asarray(np.linalg.norm(arm.tip_motion(Q, dQ, np.zeros_like(Q), tool_state).velocity, axis=1))
