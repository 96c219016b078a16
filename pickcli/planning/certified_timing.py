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
from pickcli.grasping.holding import CupLoad, Hold
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Grasp
from pickcli.planning.cup_load import carried_load, path_load
from pickcli.planning.pick_settings import SLOWER_THAN_ALLOWED
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.timed_motion_validation import prove
from pickcli.planning.tool_path_check import broken_promise, mended
from pickcli.scene.scene import Scene
from pickcli.timing.path_constraint import PathConstraint
from pickcli.timing.timed_run import TimedRun, time_run
from pickcli.timing.wrench_limit import WrenchLimit

BETWEEN = 1e-3  # share of the load that may be added between the states at which the timing checked it
MENDS = 5  # times that a run is timed, with narrower blends or slower, to keep what is promised of lines


@dataclass(frozen=True, eq=False)
class CertifiedRun:
    """A run with an item, and what the cup feels.

    Attributes:
        run: The timed run.
        load: The worst load on the cup over it.
    """

    run: TimedRun
    load: CupLoad


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

    Where the motion without a load keeps what the cup bears, that is the answer. Else it is timed anew, with
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
    cup = WrenchLimit(context.arm, grasp.tool_state, hold.body, hold.limits, most * hold.vacuum_share)
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
    fastest = context.cell.robot.tool.contact_speed
    run = _timed_once(context, segments, checkers, limit)
    for _ in range(MENDS):
        if isinstance(run, Failures) or (better := mended(context.arm, fastest, run, segments)) is None:
            return run
        segments = better
        run = _timed_once(context, segments, checkers, limit)
    if isinstance(run, Failures):
        return run
    broken = broken_promise(context.arm, fastest, run, segments)
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
    """The lowest of limits in m/s, of which None is none."""
    return min((speed for speed in speeds if speed is not None), default=None)


def _tip_travel(arm: Arm, Q: Array, dQ: Array, tool_state: ToolState) -> Array:
    """(M,) m that the tip goes per unit of a path, at Q (M, n) in the direction of dQ (M, n)."""
    return np.asarray(np.linalg.norm(arm.tip_motion(Q, dQ, np.zeros_like(Q), tool_state).velocity, axis=1))
