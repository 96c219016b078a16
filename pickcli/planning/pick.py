"""``plan_pick``: from leaving for the bin to the item let go, in the tote or in another bin."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoPlanError, Reason, UnknownNameError
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp, GraspKind, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.planning_context import RESERVE, Planner
from pickcli.planning.stages.grasp_motion import GraspMotion
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.placement import plan_placement
from pickcli.planning.stages.transit import plan_coarse
from pickcli.planning.stitching import PickMotion, stitch_pick
from pickcli.scene.scene import TOTE, Scene
from pickcli.seeds import derived_seed


@dataclass(frozen=True, eq=False)
class Start:
    """Where the robot is when the query is asked."""

    q: Array  # (n,)
    tool_state: ToolState


@dataclass(frozen=True, eq=False)
class WayIn:
    """A grasp with the coarse motion to it."""

    in_bin: GraspMotion
    transit: MotionSegment
    total: float  # about the seconds to the end of the retreat, and what the grasp's score is worth


def plan_pick(
    planner: Planner,
    scene: Scene,
    bin_name: str,
    item: str,
    start: Start,
    seed: int = 0,
    exclude: Sequence[Grasp | GraspKind] = (),
    neighbours: Neighbours = Neighbours.AVOID,
    into: str = TOTE,
) -> Plan:
    """Plan one pick, uncertified (``verification.verify`` adds the certificate).

    scene: poses as perceived; their noise bounds inflate the shapes. item: instance id or item name.
    exclude: grasps that failed before, or kinds of them.
    into: where the item is brought, the tote or a bin, onto its floor.
    Raises UnknownNameError for a bin or item that is not there, NoPlanError with every reason when no
    candidate leads to a whole motion.
    """
    began = time.perf_counter()
    bins = planner.cell.pod.bins
    if bin_name not in bins:
        raise UnknownNameError("bin", bin_name, list(bins))
    if into not in (TOTE, *bins):
        raise UnknownNameError("place", into, [TOTE, *bins])
    target = scene.find(item, bin_name)
    label = f"pick {target.id} from {bin_name}" + ("" if into == TOTE else f" into {into}")
    query = BinQuery(planner, scene, bins[bin_name], target, neighbours, seed)
    feasible, failures = feasible_grasps(query, seed, exclude)
    grasped = time.perf_counter()
    for option in _ways_in(query, feasible, start, seed):
        motion = option if isinstance(option, Failures) else _carried_out(query, option, into, seed)
        if isinstance(motion, Failures):
            failures += motion
            continue
        carried = time.perf_counter()
        plan = stitch_pick(query, motion, label, seed)
        if isinstance(plan, Reason):
            failures += plan
            continue
        plan.statistics.update(
            grasps_ms=1e3 * (grasped - began),
            coarse_ms=1e3 * (carried - grasped),
            timing_ms=1e3 * (time.perf_counter() - carried),
            planning_ms=1e3 * (time.perf_counter() - began),
        )
        return plan
    raise NoPlanError(label, failures)


def _ways_in(
    query: BinQuery, feasible: Sequence[GraspMotion], start: Start, seed: int
) -> Iterator[WayIn | Failures]:
    """Ways to the pre-approach configurations, the fastest whole way in first, and why others failed.

    All grasps with one tool state go to the planner as one goal set. Losers stay as fallbacks, planned
    when they are asked for.
    """
    groups = {
        tool_state: [f for f in feasible if f.grasp.tool_state == tool_state]
        for tool_state in query.planner.cell.robot.tool.states
    }
    heads: dict[ToolState, WayIn] = {}
    todo = list(groups)
    while todo or heads:
        for tool_state in todo:
            head = _way_in(query, groups[tool_state], tool_state, start, seed) if groups[tool_state] else None
            if isinstance(head, WayIn):
                heads[tool_state] = head
            elif head is not None:
                yield head
        if not heads:
            return
        best = min(heads, key=lambda tool_state: (heads[tool_state].total, tool_state))
        chosen = heads.pop(best)
        yield chosen
        groups[best].remove(chosen.in_bin)
        todo = [best]


def _way_in(
    query: BinQuery, group: Sequence[GraspMotion], tool_state: ToolState, start: Start, seed: int
) -> WayIn | Failures:
    """The fastest way into one of the grasps with one tool state."""
    planner = query.planner
    # While the cup turns on the way, the volume that it sweeps must be free.
    mode = Mode(tool_state if tool_state == start.tool_state else MOVING, reserve=RESERVE)
    goals = np.stack([f.start for f in group])
    worth = planner.settings.load_worth
    extra = [_in_bin_duration(planner, f) + 0.2 * f.grasp.score + worth * f.grasp.load_ratio for f in group]
    name = derived_seed(seed, "transit", query.target.id, tool_state)
    checker = planner.checker_for(query.scene, mode)
    coarse = plan_coarse(planner, checker, start.q, goals, extra, name, "transit")
    if isinstance(coarse, Failures):
        return coarse
    transit = coarse.segment(SegmentKind.TRANSIT, replace(mode, reserve=0.0))
    return WayIn(group[coarse.goal], transit, coarse.duration + extra[coarse.goal])


def _in_bin_duration(planner: Planner, f: GraspMotion) -> float:
    """Estimated seconds from the pre-approach to the end of the retreat."""
    segments = (*f.inward, *f.outward)
    return float(sum(estimated_duration(planner.space, segment.waypoints) for segment in segments))


def _carried_out(query: BinQuery, option: WayIn, into: str, seed: int) -> PickMotion | Failures:
    """The way from the end of the retreat to where the item is let go, for one way in."""
    planner, chosen, target = query.planner, option.in_bin, query.target
    cell_bin = None if into == TOTE else planner.cell.pod.bins[into]
    placements = plan_placement(query, chosen, cell_bin, seed)
    if isinstance(placements, Failures):
        return placements
    mode = Mode(chosen.grasp.tool_state, chosen.attached, query.contacts.while_transferring(), RESERVE)
    goals = np.stack([placement.start for placement in placements])
    extra = [placement.cost for placement in placements]
    name = derived_seed(seed, "transfer", target.id)
    checker = planner.checker_for(query.scene, mode)
    coarse = plan_coarse(planner, checker, chosen.end, goals, extra, name, "transfer")
    if isinstance(coarse, Failures):
        return coarse
    transfer = coarse.segment(SegmentKind.TRANSFER, replace(mode, reserve=0.0))
    return PickMotion(option.transit, chosen, transfer, placements[coarse.goal])
