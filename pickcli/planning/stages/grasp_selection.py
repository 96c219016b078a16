"""Selection of grasps with proven lines in the bin: from few candidates, and from more if none succeeds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.grasping.contact_speeds import ContactSpeeds
from pickcli.grasping.grasp_target import CandidateSet, GraspBatch
from pickcli.grasping.search import USUAL, WIDE_SEARCH, Search
from pickcli.motion.plan import Grasp, GraspKind
from pickcli.planning.pick_motion import GraspMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.region_query import RegionSearch
from pickcli.planning.stages.extraction import CorridorSet, extraction_of
from pickcli.planning.stages.grasp_motion import arm_seeds, plan_grasp_motion
from pickcli.planning.stages.recorded_candidates import recorded_candidates
from pickcli.planning.stages.region_candidates import region_candidates
from pickcli.planning.stages.shift_end import plan_end_of_shift, shift_transforms
from pickcli.planning.stages.target_check import check_target
from pickcli.planning.stages.tool_clearance import tool_lines, with_tool_clearance
from pickcli.seeds import derived_rng

SAME_GRASP = 0.012  # m: a retry must put the cup at least this far from a failed grasp
# Grasps that the arm may fail to follow. In bins none succeeds after the 22nd; at the edges of a tote the arm
# reaches some grasps of a heap in few ways only: the 93rd, 247th and 394th in three of its stuck heaps.
MOST_UNFOLLOWED = 400
MOST_TRIED = 1000  # grasps of one search, those that would tip the item included

# One after the other, until grasps succeed: how candidates are found, and the ways out that they choose from.
_FIXED: tuple[tuple[Search | RegionSearch, CorridorSet], ...] = (
    (USUAL, CorridorSet.FEW),
    (WIDE_SEARCH, CorridorSet.MANY),
)
_RECORDED: tuple[tuple[Search | RegionSearch, CorridorSet], ...] = ((USUAL, CorridorSet.MANY),)
_BY_REGION = ((RegionSearch(250, 2), CorridorSet.FEW), (RegionSearch(1000, 8), CorridorSet.MANY))
SEARCHES = {
    GraspApproach.LINES: _FIXED,
    GraspApproach.REGION: _BY_REGION,
    GraspApproach.REACTIVE: _BY_REGION,
    GraspApproach.LINES_THEN_REGION: _FIXED + _BY_REGION[-1:],
}


def feasible_grasps(
    problem: PickProblem, exclude: Sequence[Grasp | GraspKind]
) -> tuple[tuple[GraspMotion, ...], Failures]:
    """Find grasps whose motion in the bin is proven.

    Args:
        problem: The pick.
        exclude: Grasps that failed before, or kinds of them.

    Returns:
        At most ``settings.wanted`` grasps, best first, and the reasons against the others.
    """
    rng = derived_rng(problem.seed, "grasps", problem.target.id)
    failures = Failures()
    for search, corridors in searches_of(problem):
        candidates = candidates_of(problem, search, corridors, rng, exclude)
        if isinstance(candidates, Failures):
            return (), failures + candidates
        told = Failures(tuple(candidates.rejected))
        if candidates.batches:
            ways_out = ways_out_of(problem, corridors)
            if isinstance(ways_out, Failures):
                return (), failures + told + ways_out
            feasible, against = _tried(problem, search, candidates, ways_out, rng)
            told += against
            if feasible:
                return feasible, failures + told
        if _tells(problem, search):
            failures += told
        if not problem.context.method.may_hold(problem.target.item):
            break
    return (), failures


def _tells(problem: PickProblem, search: Search | RegionSearch) -> bool:
    """Whether reasons of a search are told: a region query repeats what stands against fixed candidates.

    A trial decides by the most frequent reasons what it tries next.
    """
    is_alone = problem.settings.approach in (GraspApproach.REGION, GraspApproach.REACTIVE)
    return is_alone or not isinstance(search, RegionSearch)


def searches_of(problem: PickProblem) -> tuple[tuple[Search | RegionSearch, CorridorSet], ...]:
    """Return the searches for grasps of a pick, in their order.

    Args:
        problem: The pick.

    Returns:
        Of each, how candidates are found, and the ways out that they choose from.
    """
    return _RECORDED if problem.context.recorded is not None else SEARCHES[problem.settings.approach]


def candidates_of(
    problem: PickProblem, search: Search | RegionSearch, corridors: CorridorSet, rng: np.random.Generator,
    exclude: Sequence[Grasp | GraspKind] = (),
) -> CandidateSet | Failures:  # fmt: skip
    """Find the candidates of a search: recorded ones if the context has any.

    Args:
        problem: The pick.
        search: How candidates are found.
        corridors: Ways out that they choose from.
        rng: Source of random candidates.
        exclude: Grasps that failed before, or kinds of them.

    Returns:
        The candidates but those to exclude; or the reasons against picking the target.
    """
    if (recorded := problem.context.recorded) is not None:
        found = recorded_candidates(problem, recorded)
    elif isinstance(search, RegionSearch):
        ways_out = ways_out_of(problem, corridors)
        if isinstance(ways_out, Failures):
            return ways_out
        found = region_candidates(problem, search, ways_out, rng, explains=_tells(problem, search))
    else:
        most = problem.settings.load_ratio
        found = problem.context.method.sample(problem.grasp_target, rng, search, most)
    return found.select([~_is_like_any(batch, exclude) for batch in found.batches]) if exclude else found


def ways_out_of(problem: PickProblem, corridors: CorridorSet) -> tuple[Array, ...] | Failures:
    """Find the ways out for the target as a free flyer.

    Args:
        problem: The pick.
        corridors: Set of ways to choose from.

    Returns:
        Displacements (K, 4, 4) of each way; or the reasons against picking the target at all.
    """
    if problem.shift is not None:  # already checked
        return (shift_transforms(problem),)
    if (against := check_target(problem)).reasons:
        return against
    return extraction_of(problem).transforms(corridors)


def _tried(
    problem: PickProblem,
    search: Search | RegionSearch,
    candidates: CandidateSet,
    ways_out: Sequence[Array],
    rng: np.random.Generator,
) -> tuple[tuple[GraspMotion, ...], Failures]:
    feasible: list[GraspMotion] = []
    roomy, failures = with_tool_clearance(problem, candidates, ways_out)
    n_unfollowed = 0
    speeds = ContactSpeeds(problem.context.method, problem.contacts)
    for grasp in (roomy if search is USUAL else _in_turns(roomy))[:MOST_TRIED]:
        speed = speeds.of(grasp)
        if speed is None:
            failures += Reason(
                "tips the item", str(grasp), "the cup presses it over the edge of what carries it"
            )
            continue
        tool = tool_lines(problem, grasp, ways_out)
        if isinstance(tool, Failures):
            failures += tool
            continue
        result = plan_grasp_motion(problem, tool, speed, arm_seeds(problem, rng))
        if problem.shift is not None and not isinstance(result, Failures):
            end = plan_end_of_shift(problem, result)
            result = end if isinstance(end, Failures) else result
        if isinstance(result, Failures):
            failures += result
            n_unfollowed += 1
        else:
            feasible.append(result)
        if len(feasible) >= problem.settings.wanted or n_unfollowed >= MOST_UNFOLLOWED:
            break
    return tuple(feasible), failures


def _in_turns(grasps: Sequence[Grasp]) -> list[Grasp]:
    """Order grasps as the best of every kind, the second best of every kind, ..., to try all kinds soon."""
    rank: Counter[str] = Counter()
    ranked = []
    for grasp in grasps:
        ranked.append((rank[grasp.kind], grasp.score))
        rank[grasp.kind] += 1
    return [grasps[i] for i in sorted(range(len(grasps)), key=ranked.__getitem__)]


def _is_like_any(batch: GraspBatch, others: Sequence[Grasp | GraspKind]) -> NDArray[np.bool_]:
    """Whether grasps (N,) put the tool on the same place in the same way as others, or are of given kinds."""
    found = np.zeros(len(batch), dtype=bool)
    for other in others:
        is_like = (batch.kinds == other.kind) & (batch.face == other.face)
        if isinstance(other, Grasp):
            off = batch.T_item_tip[:, :3, 3] - other.T_item_tip[:3, 3]
            is_like &= np.linalg.norm(off, axis=1) < SAME_GRASP
        found |= is_like
    return found
