"""From lines and coarse motions to one timed, proven plan with its events.

Delft, section 3: the segments are stitched into one motion plan, timed as a whole, and the events follow
the key waypoints. The motion stops only on the item and over the tote.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.grasping.holding import Hold
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.certified_timing import carried_run, proven_run
from pickcli.planning.events import schedule
from pickcli.planning.pieces import COARSE_BLEND, PickMotion, Piece, moving, way_in, way_out, way_up
from pickcli.planning.planning_context import Planner
from pickcli.planning.promises import thrown
from pickcli.planning.stages.transit import Coarse
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.concatenation import concatenate
from pickcli.timing.timed_run import TimedRun


def assemble_pick(query: BinQuery, motion: PickMotion, label: str, seed: int) -> Plan | Reason:
    """Time, prove and bind a pick. Reason when the cup cannot hold at any speed or a proof fails."""
    planner, settings, grasp = query.planner, query.planner.settings, motion.in_bin.grasp
    speed = planner.cell.speed_scale
    ways = way_in(query, motion), way_out(query, motion), way_up(motion)
    to_item, to_place, up = (moving(way, speed) for way in ways)
    first = proven_run(planner, to_item)
    if isinstance(first, Reason):
        return first
    item = query.target.item
    hold = Hold.of(item, grasp.face, motion.in_bin.held.T_tip_item, planner.cell.robot.tool)
    carried = carried_run(planner, to_place, grasp, hold, item.speed_scale)
    if isinstance(carried, Reason):
        return carried
    last = proven_run(planner, up)
    if isinstance(last, Reason):
        return last
    runs, rests = [first, carried.run, last], [settings.seal_time, settings.release_time]
    trajectory, segments = _joined([*to_item, *to_place, *up], runs, rests)
    scheduled = schedule(planner, segments, trajectory)
    if isinstance(scheduled, Reason):
        return scheduled
    segments, trajectory, events = scheduled
    plan = Plan(
        query=label,
        cell_fingerprint=planner.cell.fingerprint,
        scene_hash=scene_hash(query.scene),
        seed=seed,
        segments=segments,
        trajectory=trajectory,
        events=events,
        grasp=carried.load.of(grasp),
        speed_scale=item.speed_scale,
    )
    return thrown(planner.arm, plan, planner.cell.devices) or plan


def assemble_move(
    planner: Planner, scene: Scene, tool_state: ToolState, coarse: Coarse, label: str, seed: int
) -> Plan | Reason:
    """Time and prove a coarse motion of the empty tool."""
    checker = planner.checker(scene, tool_state)
    piece = Piece(SegmentKind.TRANSIT, coarse.waypoints, tool_state, checker, blend=COARSE_BLEND)
    return assemble_pieces(planner, scene, [piece], label, seed)


def assemble_pieces(
    planner: Planner, scene: Scene, pieces: Sequence[Piece], label: str, seed: int
) -> Plan | Reason:
    """Time and prove one run of the empty tool, without events."""
    pieces = moving(pieces, planner.cell.speed_scale)
    if not pieces:
        return Reason("nothing to do", label, "start and goal are the same")
    run = proven_run(planner, pieces)
    if isinstance(run, Reason):
        return run
    trajectory, segments = _joined(pieces, [run], [])
    return Plan(label, planner.cell.fingerprint, scene_hash(scene), seed, segments, trajectory, ())


def _joined(
    pieces: Sequence[Piece], runs: Sequence[TimedRun], rests: Sequence[float]
) -> tuple[Trajectory, tuple[Segment, ...]]:
    """All runs as one trajectory, and its segments; the hold after a run belongs to its last segment."""
    joined = concatenate(runs, rests)
    starts = np.concatenate([run.part_times[:-1] + t for run, t in zip(runs, joined.starts, strict=True)])
    starts[0] = 0.0
    ends = np.append(starts[1:], joined.trajectory.duration)
    segments = tuple(
        Segment(p.kind, float(t0), float(t1), p.tool_state, p.held, tuple(sorted(p.touching)))
        for p, t0, t1 in zip(pieces, starts, ends, strict=True)
    )
    return joined.trajectory, segments
