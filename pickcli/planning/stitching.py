"""From lines and coarse motions to one timed, proven plan with its events.

Delft, section 3: the segments are stitched into one motion plan, timed as a whole, and the events follow
the key waypoints. The motion stops only on the item and over the tote.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Reason
from pickcli.grasping.holding import Hold
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.certified_timing import carried_run, proven_run
from pickcli.planning.events import schedule
from pickcli.planning.planning_context import Planner
from pickcli.planning.promises import thrown
from pickcli.planning.stages.grasp_motion import GraspMotion
from pickcli.planning.stages.placement import PlaceMotion
from pickcli.scene.scene import Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.concatenation import concatenate
from pickcli.timing.timed_run import TimedRun


@dataclass(frozen=True, eq=False)
class PickMotion:
    """The geometry of a whole pick.

    Attributes:
        transit: From where the robot is to the pre-approach.
        in_bin: In the bin, to the item and out with it.
        transfer: From the end of the retreat to where the placement begins.
        placement: To the release, and away from there.
    """

    transit: MotionSegment
    in_bin: GraspMotion
    transfer: MotionSegment
    placement: PlaceMotion


def stitch_pick(query: BinQuery, motion: PickMotion, label: str, seed: int) -> Plan | Reason:
    """Time, prove and bind a pick. Reason when the cup cannot hold at any speed or a proof fails."""
    planner, settings, grasp = query.planner, query.planner.settings, motion.in_bin.grasp
    item, scene = query.target.item, query.scene
    to_item = _moving(planner, [motion.transit, *motion.in_bin.inward])
    to_place = _moving(planner, [*motion.in_bin.outward, motion.transfer, *motion.placement.inward])
    away = _moving(planner, motion.placement.away)
    first = proven_run(planner, scene, to_item)
    if isinstance(first, Reason):
        return first
    hold = Hold.of(item, grasp.face, motion.in_bin.attached.T_tip_item, planner.cell.robot.tool)
    slowed = [segment.scaled(item.speed_scale) for segment in to_place]
    carried = carried_run(planner, scene, slowed, grasp, hold)
    if isinstance(carried, Reason):
        return carried
    last = proven_run(planner, motion.placement.scene, away)
    if isinstance(last, Reason):
        return last
    runs, rests = [first, carried.run, last], [settings.seal_time, settings.release_time]
    trajectory, segments = _joined([*to_item, *to_place, *away], runs, rests)
    scheduled = schedule(planner, segments, trajectory)
    if isinstance(scheduled, Reason):
        return scheduled
    segments, trajectory, events = scheduled
    plan = Plan(
        query=label,
        cell_fingerprint=planner.cell.fingerprint,
        scene_hash=scene_hash(scene),
        seed=seed,
        segments=segments,
        trajectory=trajectory,
        events=events,
        grasp=carried.load.of(grasp),
        speed_scale=item.speed_scale,
    )
    return thrown(planner.arm, plan, planner.cell.devices) or plan


def stitch_run(
    planner: Planner, scene: Scene, segments: Sequence[MotionSegment], label: str, seed: int
) -> Plan | Reason:
    """Time and prove one run of the empty tool, without events."""
    segments = _moving(planner, segments)
    if not segments:
        return Reason("nothing to do", label, "start and goal are the same")
    run = proven_run(planner, scene, segments)
    if isinstance(run, Reason):
        return run
    trajectory, timed = _joined(segments, [run], [])
    return Plan(label, planner.cell.fingerprint, scene_hash(scene), seed, timed, trajectory, ())


def _moving(planner: Planner, segments: Iterable[MotionSegment]) -> list[MotionSegment]:
    """The segments that move at all, at the cell's speed."""
    return [segment.scaled(planner.cell.speed_scale) for segment in segments if segment.has_length]


def _joined(
    segments: Sequence[MotionSegment], runs: Sequence[TimedRun], rests: Sequence[float]
) -> tuple[Trajectory, tuple[Segment, ...]]:
    """All runs as one trajectory, and its segments; the hold after a run belongs to its last segment."""
    joined = concatenate(runs, rests)
    starts = np.concatenate([run.part_times[:-1] + t for run, t in zip(runs, joined.starts, strict=True)])
    starts[0] = 0.0
    ends = np.append(starts[1:], joined.trajectory.duration)
    timed = (s.timed(float(t0), float(t1)) for s, t0, t1 in zip(segments, starts, ends, strict=True))
    return joined.trajectory, tuple(timed)
