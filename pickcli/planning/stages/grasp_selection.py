"""The grasps of a target whose lines in the bin are proven: of few, and of many where none of those goes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.errors import Failures, Reason
from pickcli.grasping.candidates import CandidateSet, sample_grasps
from pickcli.grasping.search import USUAL, WIDE, Search
from pickcli.motion.plan import Grasp, GraspKind
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.stages.extraction import Ways
from pickcli.planning.stages.grasp_motion import GraspMotion, plan_grasp_motion
from pickcli.planning.stages.tool_clearance import with_room
from pickcli.seeds import derived_rng

SAME_GRASP = 0.012  # m: a retry must put the cup at least this far from where it failed


def feasible_grasps(
    query: BinQuery, seed: int, exclude: Sequence[Grasp | GraspKind]
) -> tuple[tuple[GraspMotion, ...], Failures]:
    """At most ``wanted`` grasps, best first, and the reasons against the others.

    exclude: grasps that failed before, or kinds of them
    """
    rng = derived_rng(seed, "grasps", query.target.id)
    failures = Failures()
    for search, ways in ((USUAL, Ways.FEW), (WIDE, Ways.MANY)):
        candidates = _candidates(query, search, exclude, rng)
        failures += Failures(tuple(candidates.rejected))
        if candidates.grasps and (obstacles := (*query.blockers, *query.contradictions)):
            return (), failures + Failures(obstacles)
        if candidates.grasps and isinstance(query.corridors, Reason):
            return (), failures + query.corridors
        feasible, against = _tried(query, candidates.grasps, ways, rng)
        failures += against
        if feasible or not query.target.item.suction:
            return feasible, failures
    return (), failures


def _candidates(
    query: BinQuery, search: Search, exclude: Sequence[Grasp | GraspKind], rng: np.random.Generator
) -> CandidateSet:
    target, tool, most = query.target, query.planner.cell.robot.tool, query.planner.settings.load_ratio
    found = sample_grasps(target.id, target.item, query.T_bin_item, tool, query.cell_bin, rng, search, most)
    return replace(found, grasps=tuple(g for g in found.grasps if not any(_same(g, e) for e in exclude)))


def _tried(
    query: BinQuery, grasps: Sequence[Grasp], ways: Ways, rng: np.random.Generator
) -> tuple[tuple[GraspMotion, ...], Failures]:
    feasible: list[GraspMotion] = []
    roomy, failures = with_room(query, grasps, ways)
    for grasp in _steady_first(query, roomy if ways is Ways.FEW else _in_turns(roomy), feasible):
        result = plan_grasp_motion(query, grasp, rng, ways)
        if isinstance(result, Failures):
            failures += result
            continue
        feasible.append(result)
        if len(feasible) >= query.planner.settings.wanted:
            break
    return tuple(feasible), failures


def _steady_first(
    query: BinQuery, grasps: Iterable[Grasp], feasible: Sequence[GraspMotion]
) -> Iterator[Grasp]:
    """Grasps in their order; those that tip the target only where no other was found feasible by then."""
    tipping = []
    for grasp in grasps:
        if query.tips(grasp):
            tipping.append(grasp)
        else:
            yield grasp
    if not feasible:
        yield from tipping


def _in_turns(grasps: list[Grasp]) -> list[Grasp]:
    """The best of every kind, the second best of every kind, ...: where one kind has no room others may."""
    rank: Counter[str] = Counter()
    ranked = []
    for grasp in grasps:
        ranked.append((rank[grasp.kind], grasp.score))
        rank[grasp.kind] += 1
    return [grasps[i] for i in sorted(range(len(grasps)), key=ranked.__getitem__)]


def _same(a: Grasp, b: Grasp | GraspKind) -> bool:
    """Whether two grasps put the cup on the same place in the same way, or one is of a kind."""
    if isinstance(b, GraspKind):
        return (a.kind, a.face) == (b.kind, b.face)
    near = float(np.linalg.norm(a.T_item_tip[:3, 3] - b.T_item_tip[:3, 3])) < SAME_GRASP
    return a.face == b.face and a.kind == b.kind and near
