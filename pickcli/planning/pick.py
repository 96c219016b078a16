"""``plan_pick``: from leaving for the bin to the item released in the tote and the tool above it."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import PivotState
from pickcli.cell.scene import Scene
from pickcli.errors import NoPlanError, Reason, UnknownNameError
from pickcli.geometry import Array
from pickcli.grasping.candidates import sample_grasps
from pickcli.motion.plan import Grasp, Plan
from pickcli.planning.assemble import assemble_pick
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.coarse import Coarse, plan_coarse
from pickcli.planning.context import RESERVE, Planner
from pickcli.planning.drop import Drop, Spot, plan_drop, spots
from pickcli.planning.in_bin import InBin, plan_in_bin
from pickcli.planning.pieces import PickMotion
from pickcli.planning.settings import Neighbours
from pickcli.roadmap.cost import estimated_duration
from pickcli.seeds import derived_rng, derived_seed

SAME_GRASP = 0.012  # m: a retry must put the cup at least this far from where it failed


@dataclass(frozen=True, eq=False)
class Start:
    """Where the robot is when the query is asked."""

    q: Array  # (n,)
    pivot: PivotState


@dataclass(frozen=True, eq=False)
class WayIn:
    """A grasp with the coarse motion to it."""

    in_bin: InBin
    transit: Coarse
    transit_pivot: PivotState
    total: float  # about the seconds to the end of the retreat, and what the grasp's score is worth


def plan_pick(
    planner: Planner,
    scene: Scene,
    bin_name: str,
    item: str,
    start: Start,
    seed: int = 0,
    exclude: Sequence[Grasp] = (),
    neighbours: Neighbours = Neighbours.AVOID,
) -> Plan:
    """Plan one pick, uncertified (``verification.verify`` adds the certificate).

    scene: poses as perceived; their noise bounds inflate the shapes. item: instance id or item name.
    exclude: grasps that failed before. Raises UnknownNameError for a bin or item that is not there,
    NoPlanError with every reason when no candidate leads to a whole motion.
    """
    began = time.perf_counter()
    if bin_name not in planner.cell.pod.bins:
        raise UnknownNameError("bin", bin_name, list(planner.cell.pod.bins))
    target = scene.find(item, bin_name)
    label = f"pick {target.id} from {bin_name}"
    query = BinQuery(planner, scene, planner.cell.pod.bins[bin_name], target, neighbours)
    feasible, reasons = _feasible_grasps(query, seed, exclude)
    grasped = time.perf_counter()
    for option in _ways_in(query, feasible, start, seed, reasons):
        motion = _carried_out(query, option, seed, reasons)
        if motion is None:
            continue
        carried = time.perf_counter()
        plan = assemble_pick(query, motion, label, seed)
        if isinstance(plan, Reason):
            reasons.append(plan)
            continue
        plan.statistics.update(
            grasps_ms=1e3 * (grasped - began),
            coarse_ms=1e3 * (carried - grasped),
            timing_ms=1e3 * (time.perf_counter() - carried),
            planning_ms=1e3 * (time.perf_counter() - began),
        )
        return plan
    raise NoPlanError(label, reasons)


def _feasible_grasps(
    query: BinQuery, seed: int, exclude: Sequence[Grasp]
) -> tuple[list[InBin], list[Reason]]:
    """Grasps whose lines inside the bin are all proven, at most ``wanted`` of them, best first."""
    planner, target = query.planner, query.target
    rng = derived_rng(seed, "grasps", target.id)
    tool = planner.cell.robot.tool
    candidates = sample_grasps(target.id, target.item, query.T_bin_item, tool, query.cell_bin, rng)
    reasons = list(candidates.rejected)
    if candidates.grasps and isinstance(query.corridors, Reason):
        return [], [*reasons, query.corridors]
    feasible: list[InBin] = []
    tried = [g for g in candidates.grasps if not any(_same(g, e) for e in exclude)]
    for grasp in tried[: planner.settings.max_candidates]:
        result = plan_in_bin(query, grasp, rng)
        if isinstance(result, list):
            reasons += result
            continue
        feasible.append(result)
        if len(feasible) >= planner.settings.wanted:
            break
    return feasible, reasons


def _same(a: Grasp, b: Grasp) -> bool:
    """Whether two grasps put the cup on the same place in the same way."""
    near = float(np.linalg.norm(a.T_item_tip[:3, 3] - b.T_item_tip[:3, 3])) < SAME_GRASP
    return a.face == b.face and a.kind == b.kind and near


def _ways_in(
    query: BinQuery, feasible: list[InBin], start: Start, seed: int, reasons: list[Reason]
) -> Iterator[WayIn]:
    """Ways to the pre-approach configurations, the fastest whole way in first.

    All grasps with one pivot state go to the planner as one goal set. Losers stay as fallbacks, planned
    when they are asked for.
    """
    groups = {
        pivot: [f for f in feasible if f.grasp.pivot is pivot]
        for pivot in (PivotState.STRAIGHT, PivotState.DOWN)
    }
    heads = {pivot: _way_in(query, group, pivot, start, seed, reasons) for pivot, group in groups.items()}
    while any(heads.values()):
        _, pivot = min((head.total, pivot) for pivot, head in heads.items() if head is not None)
        best = heads[pivot]
        assert best is not None
        yield best
        groups[pivot].remove(best.in_bin)
        heads[pivot] = _way_in(query, groups[pivot], pivot, start, seed, reasons)


def _way_in(
    query: BinQuery, group: list[InBin], pivot: PivotState, start: Start, seed: int, reasons: list[Reason]
) -> WayIn | None:
    """The fastest way into one of the grasps with one pivot state, or None."""
    if not group:
        return None
    planner = query.planner
    # While the cup turns on the way, the volume that it sweeps must be free.
    shape = pivot if pivot is start.pivot else PivotState.MOVING
    checker = planner.checker(query.scene, shape, reserve=RESERVE)
    goals = np.stack([f.preapproach.waypoints[0] for f in group])
    extra = [_in_bin_duration(planner, f) + 0.2 * f.grasp.score for f in group]
    name = derived_seed(seed, "transit", query.target.id, pivot)
    coarse = plan_coarse(planner, checker, start.q, goals, extra, name, "transit")
    if isinstance(coarse, Reason):
        reasons.append(coarse)
        return None
    return WayIn(group[coarse.goal], coarse, shape, coarse.duration + extra[coarse.goal])


def _in_bin_duration(planner: Planner, f: InBin) -> float:
    """Estimated seconds from the pre-approach to the end of the retreat."""
    lines = (f.preapproach, f.approach, f.contact, f.freed, f.lift, *f.retreat)
    return float(sum(estimated_duration(planner.space, line.waypoints) for line in lines))


def _carried_out(query: BinQuery, way_in: WayIn, seed: int, reasons: list[Reason]) -> PickMotion | None:
    """The way from the end of the retreat into the tote, for one way in."""
    planner, chosen = query.planner, way_in.in_bin
    held, pivot, target = chosen.held, chosen.grasp.pivot, query.target
    places = spots(query.scene, held, pivot)
    if isinstance(places, Reason):
        reasons.append(places)
        return None
    drops = _drops(query, chosen, places, seed, reasons)
    if not drops:
        return None
    carrying = planner.checker(query.scene, pivot, held=held, without=frozenset({target.id}), reserve=RESERVE)
    goals = np.stack([d.place.waypoints[0] for _, d in drops])
    extra = [2.0 * s.cost for s, _ in drops]
    name = derived_seed(seed, "transfer", target.id)
    transfer = plan_coarse(
        planner, carrying, chosen.retreat[-1].waypoints[-1], goals, extra, name, "transfer"
    )
    if isinstance(transfer, Reason):
        reasons.append(transfer)
        return None
    drop = drops[transfer.goal][1]
    return PickMotion(chosen, way_in.transit, way_in.transit_pivot, transfer, drop)


def _drops(
    query: BinQuery, chosen: InBin, places: Sequence[Spot], seed: int, reasons: list[Reason], n_most: int = 4
) -> list[tuple[Spot, Drop]]:
    """Spots whose straight lines are proven: the goal set of the transfer."""
    planner, pivot = query.planner, chosen.grasp.pivot
    rng = derived_rng(seed, "drop", query.target.id)
    named = [c.q for c in planner.cell.configurations.values() if c.kind in ("tote", "drop")]
    found: list[tuple[Spot, Drop]] = []
    carrying = planner.checker(query.scene, pivot, held=chosen.held, without=frozenset({query.target.id}))
    for spot in places:
        seeds = np.vstack([chosen.retreat[-1].waypoints[-1], *named, planner.arm.random_seeds(rng, 4)])
        solutions = planner.arm.solve(spot.above, pivot, seeds)
        for q in solutions[carrying.are_free(solutions)]:
            drop = plan_drop(planner, query.scene, chosen.held, pivot, query.target.id, spot, q)
            if not isinstance(drop, Reason):
                found.append((spot, drop))
                break
            reasons.append(drop)
        if len(found) >= n_most:
            return found
    if not found:
        reasons.append(Reason("no free place in the tote", "place", f"{len(places)} spots tried"))
    return found
