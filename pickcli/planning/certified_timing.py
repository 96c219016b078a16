"""Runs that are timed and proven: one stitched motion between two stops, timed under what the cup bears."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.grasping.holding import Hold, Load
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Grasp
from pickcli.planning.cup_load import carried_load, path_load
from pickcli.planning.pieces import SLOWER_THAN_ALLOWED, Piece
from pickcli.planning.planning_context import Planner
from pickcli.planning.promises import broken_promise, mended
from pickcli.timing.path_constraint import PathConstraint
from pickcli.timing.timed_run import RunPart, TimedRun, time_run
from pickcli.timing.trajectory_chords import trajectory_chords
from pickcli.timing.wrench_limit import WrenchLimit

BETWEEN = 1e-3  # share of the load that may be added between the states at which the timing checked it
MENDS = 5  # times that a run is timed, with narrower blends or slower, to keep what is promised of lines
NUDGE = 1e-4  # step of the central difference that gives the tool's speed; exact to 1e-8 of it


@dataclass(frozen=True, eq=False)
class Carried:
    """A run with an item, and what the cup feels."""

    run: TimedRun
    load: Load


def proven_run(planner: Planner, pieces: Sequence[Piece]) -> TimedRun | Reason:
    """One run over the pieces whose timed motion is proven free."""
    failed: Reason | None = None
    for are_blends_proven in (False, True):
        run = _timed(planner, pieces, 1.0, are_blends_proven)
        if isinstance(run, Reason):
            return run
        failed = prove(run, pieces)
        if failed is None:
            return run
    assert failed is not None
    return failed


def carried_run(
    planner: Planner, pieces: Sequence[Piece], grasp: Grasp, hold: Hold, speed_scale: float
) -> Carried | Reason:
    """The same with an item, nowhere faster than the cup holds under gravity and acceleration.

    Where the motion without a load keeps what the cup bears, that is the answer. Else it is timed anew, with
    the wrench among its limits.

    hold: the item as it hangs in the cup. speed_scale: the item's, of all limits
    """
    most = planner.settings.load_ratio
    where = f"{grasp.kind} grasp on face {grasp.face}"
    waypoints = np.vstack([piece.waypoints for piece in pieces])
    still = path_load(planner.arm, grasp.tool_state, waypoints, hold)
    if still.ratio > most:
        return Reason("does not hold", where, f"{still} at rest on the way, {still.ratio:.2f} of the limit")
    cup = WrenchLimit(planner.arm, grasp.tool_state, hold.body, hold.limits, most * hold.vacuum_share)
    limit, are_blends_proven = None, False
    while True:
        run = _timed(planner, pieces, speed_scale, are_blends_proven, limit)
        if isinstance(run, Reason):
            return run
        load = carried_load(planner.arm, grasp.tool_state, run.trajectory, hold)
        if load.ratio > most * (1.0 + BETWEEN):
            if limit is not None:
                return Reason("does not hold", where, f"{load} as timed, {load.ratio:.2f} of the limit")
            limit = cup
            continue
        failed = prove(run, pieces)
        if failed is None:
            return Carried(run, load)
        if are_blends_proven:
            return failed
        are_blends_proven = True


def prove(run: TimedRun, pieces: Sequence[Piece]) -> Reason | None:
    """Prove the timed motion itself free, quintic by quintic, by the checker of the piece it lies in.

    What reaches into two pieces is proven by both. None when all is free.
    """
    chords, slack = trajectory_chords(run.trajectory)
    times = run.trajectory.times
    for piece, t_start, t_end in zip(pieces, run.part_times[:-1], run.part_times[1:], strict=True):
        first = max(0, int(np.searchsorted(times, t_start, side="right")) - 1)
        last = min(len(times) - 1, int(np.searchsorted(times, t_end, side="left")))
        if last <= first:
            continue
        i = piece.checker.first_invalid_edge(chords[first : last + 1], slack[first:last])
        if i >= 0:
            reason = piece.checker.explain_edge(chords[first + i], chords[first + i + 1])
            where = f"{piece.kind} at {times[first + i]:.3f} s"
            what = "the timed motion is not proven free"
            return Reason(what, where, str(reason), reason.in_the_way)
    return None


def _timed(
    planner: Planner,
    pieces: Sequence[Piece],
    slower: float,
    are_blends_proven: bool,
    limit: PathConstraint | None = None,
) -> TimedRun | Reason:
    """One run that keeps what is promised of lines and contact, or what it breaks however it is mended."""
    fastest = planner.cell.robot.tool.contact_speed
    run = _timed_once(planner, pieces, slower, are_blends_proven, limit)
    for _ in range(MENDS):
        if isinstance(run, Reason) or (better := mended(planner.arm, fastest, run, pieces)) is None:
            return run
        pieces = better
        run = _timed_once(planner, pieces, slower, are_blends_proven, limit)
    return run if isinstance(run, Reason) else broken_promise(planner.arm, fastest, run, pieces) or run


def _timed_once(
    planner: Planner,
    pieces: Sequence[Piece],
    slower: float,
    are_blends_proven: bool,
    limit: PathConstraint | None,
) -> TimedRun | Reason:
    """One run, with corners as round as asked for, or only as round as is proven free.

    The former is nearly always free and is proven afterwards, with its time; the latter costs another proof.
    """
    most = planner.cell.max_tool_speed
    cap = None if most is None else SLOWER_THAN_ALLOWED * most
    parts = [
        RunPart(p.kind, p.waypoints, p.scale * slower, _lower(p.max_tool_speed, cap), p.blend) for p in pieces
    ]

    def is_free(part: int, chords: Array, slack: Array) -> int:
        return pieces[part].checker.first_invalid_edge(chords, slack)

    # A cell's own limit holds for both places of the cup, whichever it is in.
    tool_states = [pieces[-1].tool_state] if most is None else planner.cell.robot.tool.states

    def tool_speed(Q: Array, dQ: Array) -> Array:
        return np.asarray(
            np.max([_tip_travel(planner.arm, Q, dQ, tool_state) for tool_state in tool_states], axis=0)
        )

    blends = is_free if are_blends_proven else None
    try:
        return time_run(planner.arm.names, parts, planner.arm.limits, blends, tool_speed, constraint=limit)
    except NoPlanError as error:
        return error.reasons[0]


def _lower(*speeds: float | None) -> float | None:
    """The lowest of limits in m/s, of which None is none."""
    return min((speed for speed in speeds if speed is not None), default=None)


def _tip_travel(arm: Arm, Q: Array, dQ: Array, tool_state: ToolState) -> Array:
    """(M,) m that the tip goes per unit of a path, at Q (M, n) in the direction of dQ (M, n)."""
    ahead, behind = (arm.tips(Q + h * dQ, tool_state)[:, :3, 3] for h in (NUDGE, -NUDGE))
    return np.asarray(np.linalg.norm(ahead - behind, axis=1) / (2 * NUDGE))
