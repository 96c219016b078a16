"""From lines and coarse motions to one timed, proven plan with its events.

Delft, section 3: the segments are stitched into one motion plan, timed as a whole, and the events follow
the key waypoints. The motion stops only on the item and over the tote.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.robot import PivotState
from pickcli.cell.scene import Scene
from pickcli.cell.scene_file import scene_hash
from pickcli.collision.checker import Held, SceneChecker
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.grasping.holding import Load
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.coarse import Coarse
from pickcli.planning.context import Planner
from pickcli.planning.drop import Drop
from pickcli.planning.events import schedule
from pickcli.planning.in_bin import BinQuery, InBin
from pickcli.planning.payload import carried_load, path_load
from pickcli.timing.chords import trajectory_chords
from pickcli.timing.sequence import concatenate
from pickcli.timing.run import RunPart, TimedRun, time_run

FINE = 0.002  # joint units: blends inside the bin stay this close to the lines
COARSE_BLEND = 0.05
SLOWER = 0.9  # speed is lowered by at least this factor at a time until the cup holds
SLOWEST = 0.1
NUDGE = 1e-4  # step of the central difference that gives the tool's speed; exact to 1e-8 of it


@dataclass(frozen=True, eq=False)
class PickMotion:
    """The geometry of a whole pick."""

    in_bin: InBin
    transit: Coarse
    transit_pivot: PivotState  # MOVING where the cup turns on the way
    transfer: Coarse
    drop: Drop


@dataclass(frozen=True, eq=False)
class Piece:
    """One segment before it has a time: its path, how fast, and what proves it."""

    kind: SegmentKind
    waypoints: Array
    pivot: PivotState
    checker: SceneChecker
    held: str | None = None
    touching: frozenset[str] = frozenset()
    max_tool_speed: float | None = None
    blend: float = FINE
    scale: float = 1.0


def assemble_pick(query: BinQuery, motion: PickMotion, label: str, seed: int) -> Plan | Reason:
    """Time, prove and bind a pick. Reason when the cup cannot hold at any speed or a proof fails."""
    planner, settings = query.planner, query.planner.settings
    way_in, way_out, leave = pick_pieces(query, motion)
    first = _proven(planner, way_in)
    if isinstance(first, Reason):
        return first
    carried = _carried(query, motion, way_out)
    if isinstance(carried, Reason):
        return carried
    second, scale, worst = carried
    last = _proven(planner, leave)
    if isinstance(last, Reason):
        return last
    runs, rests = [first, second, last], [settings.seal_time, settings.release_time]
    trajectory, segments = _joined([*way_in, *way_out, *leave], runs, rests)
    scheduled = schedule(planner, segments, trajectory)
    if isinstance(scheduled, Reason):
        return scheduled
    segments, trajectory, events = scheduled
    grasp = replace(motion.in_bin.grasp, moment=worst.moment, pull=worst.pull, shear=worst.shear)
    return Plan(
        label, planner.cell.fingerprint, scene_hash(query.scene), seed, segments, trajectory, events, grasp, scale
    )


def assemble_move(
    planner: Planner, scene: Scene, pivot: PivotState, coarse: Coarse, label: str, seed: int
) -> Plan | Reason:
    """Time and prove a coarse motion of the empty tool."""
    piece = Piece(SegmentKind.TRANSIT, coarse.waypoints, pivot, planner.checker(scene, pivot), blend=COARSE_BLEND)
    return assemble_pieces(planner, scene, [piece], label, seed)


def assemble_pieces(planner: Planner, scene: Scene, pieces: Sequence[Piece], label: str, seed: int) -> Plan | Reason:
    """Time and prove one run of the empty tool, without events."""
    pieces = _moving(pieces, planner.cell.speed_scale)
    if not pieces:
        return Reason("nothing to do", label, "start and goal are the same")
    run = _proven(planner, pieces)
    if isinstance(run, Reason):
        return run
    trajectory, segments = _joined(pieces, [run], [])
    return Plan(label, planner.cell.fingerprint, scene_hash(scene), seed, segments, trajectory, ())


def pick_pieces(query: BinQuery, motion: PickMotion) -> tuple[list[Piece], list[Piece], list[Piece]]:
    """The pieces of the three runs: to the item, with it into the tote, and up from there."""
    planner, scene, settings, speed = query.planner, query.scene, query.planner.settings, query.planner.cell.speed_scale
    b, pivot, target = motion.in_bin, motion.in_bin.grasp.pivot, query.target.id
    gone, meeting = b.ignored | {target}, frozenset({target})

    def checker(
        without: frozenset[str], held: Held | None = None, touching: frozenset[str] = frozenset(), state: PivotState = pivot
    ) -> SceneChecker:
        return planner.checker(scene, state, held=held, without=without, touching=touching)

    carrying = checker(gone, b.held)
    loaded = {"pivot": pivot, "held": target}
    kind, transit, contact_speed = SegmentKind, motion.transit, planner.cell.robot.tool.contact_speed
    way_in = [
        Piece(kind.TRANSIT, transit.waypoints, motion.transit_pivot, checker(frozenset(), state=motion.transit_pivot), blend=COARSE_BLEND),
        Piece(kind.PREAPPROACH, b.preapproach.waypoints, pivot, checker(b.ignored), max_tool_speed=settings.preapproach_speed),
        Piece(kind.APPROACH, b.approach.waypoints, pivot, checker(b.ignored), max_tool_speed=settings.approach_speed),
        Piece(kind.CONTACT, b.contact.waypoints, pivot, checker(b.ignored, touching=meeting), touching=meeting | b.touching, max_tool_speed=contact_speed),
    ]  # fmt: skip
    way_out = [
        Piece(kind.LIFT, b.freed.waypoints, checker=checker(gone, b.held, b.touching), touching=b.touching, max_tool_speed=settings.lift_speed, **loaded),
        Piece(kind.LIFT, b.lift.waypoints, checker=carrying, max_tool_speed=settings.lift_speed, **loaded),
        Piece(kind.RETREAT, b.retreat.waypoints, checker=carrying, max_tool_speed=settings.retreat_speed, **loaded),
        Piece(kind.TRANSFER, motion.transfer.waypoints, checker=checker(frozenset({target}), b.held), blend=COARSE_BLEND, **loaded),
        Piece(kind.PLACE, motion.drop.place.waypoints, checker=checker(frozenset({target}), b.held), max_tool_speed=settings.place_speed, **loaded),
    ]  # fmt: skip
    leave = [Piece(kind.DEPART, motion.drop.depart.waypoints, pivot, checker(frozenset({target})), max_tool_speed=settings.place_speed)]
    return _moving(way_in, speed), _moving(way_out, speed), _moving(leave, speed)


def _moving(pieces: Sequence[Piece], speed: float) -> list[Piece]:
    """The pieces that move at all, at the cell's speed."""
    kept = []
    for piece in pieces:
        if float(np.abs(np.diff(piece.waypoints, axis=0)).sum()) > 1e-6:
            kept.append(replace(piece, scale=speed * piece.scale))
    return kept


def _proven(planner: Planner, pieces: Sequence[Piece]) -> TimedRun | Reason:
    """One run over the pieces whose timed motion is proven free."""
    for are_blends_proven in (False, True):
        run = _timed(planner, pieces, 1.0, are_blends_proven)
        if isinstance(run, Reason):
            return run
        failed = prove(run, pieces)
        if failed is None:
            return run
    return failed


def _timed(planner: Planner, pieces: Sequence[Piece], slower: float, are_blends_proven: bool) -> TimedRun | Reason:
    """One run over the pieces, with corners as round as asked for, or only as round as is proven free.

    The former is nearly always free and is proven afterwards, with its time; the latter costs another proof.
    """
    parts = [RunPart(p.kind, p.waypoints, p.scale * slower, p.max_tool_speed, p.blend) for p in pieces]

    def is_free(part: int, chords: Array, slack: Array) -> int:
        return pieces[part].checker.path_is_free(chords, slack)

    def tool_speed(Q: Array, dQ: Array) -> Array:
        ahead, behind = (planner.arm.tips(Q + h * dQ, pieces[-1].pivot)[:, :3, 3] for h in (NUDGE, -NUDGE))
        return np.asarray(np.linalg.norm(ahead - behind, axis=1) / (2 * NUDGE))

    blends = is_free if are_blends_proven else None
    try:
        return time_run(planner.arm.names, parts, planner.arm.limits, blends, tool_speed)
    except NoPlanError as error:
        return error.reasons[0]


def _carried(
    query: BinQuery, motion: PickMotion, pieces: Sequence[Piece]
) -> tuple[TimedRun, float, Load] | Reason:
    """The run with the item, slowed down until the cup holds under gravity and acceleration."""
    planner, grasp, item = query.planner, motion.in_bin.grasp, query.target.item
    tool, most = planner.cell.robot.tool, planner.settings.load_ratio
    where = f"{grasp.kind} grasp on face {grasp.face}"
    still = path_load(planner.arm, grasp.pivot, np.vstack([p.waypoints for p in pieces]), grasp, item.mass)
    if still.ratio(tool) > most:
        return Reason("does not hold", where, f"{still} on the way at rest, {still.ratio(tool):.2f} of the limit")
    scale, are_blends_proven = item.speed_scale, False
    while True:
        run = _timed(planner, pieces, scale, are_blends_proven)
        if isinstance(run, Reason):
            return run
        worst = carried_load(planner.arm, grasp.pivot, run.trajectory, grasp, item.mass)
        ratio = worst.ratio(tool)
        if ratio <= most:
            failed = prove(run, pieces)
            if failed is None:
                return run, scale, worst
            if are_blends_proven:
                return failed
            are_blends_proven = True
        elif scale <= SLOWEST:
            return Reason("does not hold", where, f"{worst} at {scale:.0%} of the speed, {ratio:.2f} of the limit")
        else:
            # What motion adds to the load at rest goes with the acceleration, and that with the scale.
            scale = max(SLOWEST, scale * min(SLOWER, (most - still.ratio(tool)) / (ratio - still.ratio(tool))))


def _joined(
    pieces: Sequence[Piece], runs: Sequence[TimedRun], rests: Sequence[float]
) -> tuple[Trajectory, tuple[Segment, ...]]:
    """All runs as one trajectory, and its segments; the hold after a run belongs to its last segment."""
    joined = concatenate(runs, rests)
    starts = np.concatenate([run.part_times[:-1] + t for run, t in zip(runs, joined.starts, strict=True)])
    starts[0] = 0.0
    ends = np.append(starts[1:], joined.trajectory.duration)
    segments = tuple(
        Segment(p.kind, float(t0), float(t1), p.pivot, p.held, tuple(sorted(p.touching)))
        for p, t0, t1 in zip(pieces, starts, ends, strict=True)
    )
    return joined.trajectory, segments


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
        i = piece.checker.path_is_free(chords[first : last + 1], slack[first:last])
        if i >= 0:
            reason = piece.checker.explain_edge(chords[first + i], chords[first + i + 1])
            where = f"{piece.kind} at {times[first + i]:.3f} s"
            return Reason("the timed motion is not proven free", where, str(reason))
    return None
