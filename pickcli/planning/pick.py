"""``plan_pick``: from the start configuration to the item released in the tote or in another bin."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoExtractionError, NoPlanError
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.assembly.stitching import stitch_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery, shift_label
from pickcli.planning.pick_settings import DropPlace
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.grasp_transit import transits_to_grasps
from pickcli.planning.stages.shift_corridor import shift_corridor
from pickcli.planning.stages.stated_placement import pick_from_stated_place
from pickcli.planning.stages.transfer import plan_transfer
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene

MOST_REJECTED = 4  # rejected plans of one query after which planning fails


def plan_pick(
    context: PlanningContext,
    scene: Scene,
    query: PickQuery,
    start: Start,
    seed: int = 0,
    recorder: ExperienceRecorder | None = None,
    certify: Certify | None = None,
) -> Plan:
    """Plan one pick, or the shift of an item within its place.

    If ``certify`` rejects a plan, the next candidate is tried.

    Args:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived; their noise bounds inflate the shapes.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        recorder: Records experience of coarse queries; None discards it.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified (see ``verification.verify``).

    Returns:
        The plan, with its computation times in ms under ``statistics``.

    Raises:
        UnknownNameError: If a place or item of the query does not exist.
        NoExtractionError: If no grasp leads the item out of its place; with every reason.
        NoPlanError: If the start is not free, or no candidate leads to a complete, certified motion; with
            every reason.
    """
    began = time.perf_counter()
    problem = _problem(context, scene, query, seed)
    standing = context.checker_for(scene, Mode(start.tool_state))
    if not standing.is_valid(start.q):
        raise NoPlanError(problem.label, [standing.explain(start.q).at("start")])
    failures, n_rejected = Failures(), 0
    for plan in _candidates(problem, query, start, recorder or ExperienceRecorder(), began):
        if isinstance(plan, Failures):
            failures += plan
            continue
        certified = plan if certify is None else certify(plan)
        if not isinstance(certified, Failures):
            return certified
        failures, n_rejected = failures + certified, n_rejected + 1
        if n_rejected == MOST_REJECTED or _is_needed_by_others(problem, certified):
            break
    raise NoPlanError(problem.label, failures)


def _is_needed_by_others(problem: PickProblem, rejected: Failures) -> bool:
    """Whether a plan was rejected for what rests or leans on the target, which no other grasp changes."""
    return any(reason.where == problem.target.id and reason.in_the_way for reason in rejected.reasons)


def _problem(context: PlanningContext, scene: Scene, query: PickQuery, seed: int) -> PickProblem:
    """Return the problem of a query, of a shift with its way.

    Raises NoPlanError if a shift has none, or an item cannot stand where that is stated.
    """
    problem = PickProblem.of(context, scene, query, seed)
    if problem.at is not None and isinstance(
        against := pick_from_stated_place(problem, problem.at), Failures
    ):
        raise NoPlanError(problem.label, against)
    if query.by is None:
        is_from_rim = context.settings.drop_from is DropPlace.RIM and query.into != query.out_of
        return replace(problem, over_rim=is_from_rim)
    way = shift_corridor(problem, query.by)
    if isinstance(way, Failures):
        raise NoPlanError(shift_label(problem.target, query.by), way)
    return replace(problem, shift=way)


def _candidates(
    problem: PickProblem, query: PickQuery, start: Start, recorder: ExperienceRecorder, began: float
) -> Iterator[Plan | Failures]:
    """Yield uncertified plans of a pick, one per grasp, the best first, and the failures of other grasps.

    Raises NoExtractionError if there is no grasp.

    began: s by ``time.perf_counter`` at the start of the query
    """
    grasps, failures = feasible_grasps(problem, query.exclude)
    if not grasps:
        raise NoExtractionError(problem.label, failures)
    grasped = time.perf_counter()
    elsewhere = 0.0  # s in which candidates were verified
    yield failures
    for reached in transits_to_grasps(problem, grasps, start):
        if isinstance(reached, Failures):
            yield reached
            continue
        recorder.record(reached.experience)
        motion = plan_transfer(problem, reached)
        if isinstance(motion, Failures):
            yield motion
            continue
        recorder.record(motion.transfer.experience)
        carried = time.perf_counter()
        plan = stitch_pick(problem, motion)
        if not isinstance(plan, Failures):
            plan = plan.with_statistics(
                grasps_ms=1e3 * (grasped - began),
                coarse_ms=1e3 * (carried - grasped - elsewhere),
                timing_ms=1e3 * (time.perf_counter() - carried),
                planning_ms=1e3 * (time.perf_counter() - began - elsewhere),
                **reached.figures,
            )
        done = time.perf_counter()
        yield plan
        elsewhere += time.perf_counter() - done
