"""The grasps of a target whose lines in the bin are proven: of few, and of many where none of those goes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

from pickcli.errors import Reason
from pickcli.grasping.candidates import sample_grasps
from pickcli.grasping.search import USUAL, WIDE, Search
from pickcli.motion.plan import Grasp
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.in_bin import InBin, plan_in_bin
from pickcli.planning.tool_ways import with_room
from pickcli.seeds import derived_rng

SAME_GRASP = 0.012  # m: a retry must put the cup at least this far from where it failed


def feasible_grasps(query: BinQuery, seed: int, exclude: Sequence[Grasp]) -> tuple[list[InBin], list[Reason]]:
    """At most ``wanted`` grasps, best first, and the reasons against the others.

    exclude: grasps that failed before
    """
    rng = derived_rng(seed, "grasps", query.target.id)
    reasons: list[Reason] = []
    for search in (USUAL, WIDE):
        feasible, against = _searched(query, search, exclude, rng)
        reasons += against
        if feasible or not query.target.item.suction or isinstance(query.corridors, Reason):
            return feasible, reasons
    return [], reasons


def _searched(
    query: BinQuery, search: Search, exclude: Sequence[Grasp], rng: np.random.Generator
) -> tuple[list[InBin], list[Reason]]:
    target, tool, is_wide = query.target, query.planner.cell.robot.tool, search is WIDE
    candidates = sample_grasps(target.id, target.item, query.T_bin_item, tool, query.cell_bin, rng, search)
    reasons = list(candidates.rejected)
    if candidates.grasps and isinstance(query.corridors, Reason):
        return [], [*reasons, query.corridors]
    new = [g for g in candidates.grasps if not any(_same(g, e) for e in exclude)]
    feasible: list[InBin] = []
    roomy = with_room(query, new, is_wide, reasons)
    for grasp in _in_turns(roomy) if is_wide else roomy:
        result = plan_in_bin(query, grasp, rng, is_wide)
        if isinstance(result, list):
            reasons += result
            continue
        feasible.append(result)
        if len(feasible) >= query.planner.settings.wanted:
            break
    return feasible, reasons


def _in_turns(grasps: list[Grasp]) -> list[Grasp]:
    """The best of every kind, the second best of every kind, ...: where one kind has no room others may."""
    rank: Counter[str] = Counter()
    ranked = []
    for grasp in grasps:
        ranked.append((rank[grasp.kind], grasp.score))
        rank[grasp.kind] += 1
    return [grasps[i] for i in sorted(range(len(grasps)), key=ranked.__getitem__)]


def _same(a: Grasp, b: Grasp) -> bool:
    """Whether two grasps put the cup on the same place in the same way."""
    near = float(np.linalg.norm(a.T_item_tip[:3, 3] - b.T_item_tip[:3, 3])) < SAME_GRASP
    return a.face == b.face and a.kind == b.kind and near
