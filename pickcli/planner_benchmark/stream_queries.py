"""Queries of a stream: from configurations of the arm to all pregrasps of an item as one goal set.

As in the PR2 conveyor system of 2013, an item is to be met where it passes the middle of the arm's window;
that place is fixed, and no other time is tried.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, InputError, NoPlanError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.planner_benchmark.benchmark_entries import BenchmarkQuery
from pickcli.planner_benchmark.benchmark_summary import NamePair
from pickcli.planning.belt_picks.belt_query import InterceptQuery, QueryBelt
from pickcli.planning.belt_picks.belt_raise import raised_over_belt
from pickcli.planning.pick_motion import GraspMotion
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.scene.item_stream import ItemStream, RidingItem

ON_BELT = 0.01  # s that an item is on the belt before it is asked for


@dataclass(frozen=True, eq=False)
class StreamQueries:
    """Queries to the pregrasps of the items of a stream.

    Attributes:
        queries: By the name of the start and the id of the item.
        without: Ids of items that have no pregrasp where they are to be met, with the reason.
    """

    queries: dict[NamePair, BenchmarkQuery]
    without: dict[str, str]


def stream_queries(context: PlanningContext, stream: ItemStream, seed: int = 0) -> StreamQueries:
    """Make the queries of a stream, from each named configuration that is free.

    Args:
        context: The cell, with the stream's conveyor, and its models.
        stream: The items on a conveyor that runs.
        seed: Seed of the grasps.

    Returns:
        The queries.

    Raises:
        InputError: The belt stands, or no item has a pregrasp.
    """
    if stream.speed == 0.0:
        raise InputError(
            "the belt of the stream stands; name a stream whose belt runs (apc make-stream --speed)"
        )
    queries, without = dict[NamePair, BenchmarkQuery](), dict[str, str]()
    for riding in stream.items:
        try:
            queries |= _queries_of(context, stream.presenting(riding.id), riding, seed)
        except NoPlanError as error:
            without[riding.id] = str(error)
    if not queries:
        first, why = next(iter(without.items()))
        raise InputError(f"no item of the stream has a pregrasp in the middle of the window; {first}: {why}")
    return StreamQueries(queries, without)


def _queries_of(
    context: PlanningContext, stream: ItemStream, riding: RidingItem, seed: int
) -> dict[NamePair, BenchmarkQuery]:
    """Return the queries of one item. Raises NoPlanError if it has no pregrasp."""
    behind = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[0]) - float(riding.T_belt_item[0, 3])
    query = InterceptQuery(riding.id, max(0.0, riding.stamp + behind / stream.speed) + ON_BELT)
    belt = QueryBelt.of(stream, stream.scene_at(query.now), query)
    grasps = _pregrasps(context, belt, query, seed)
    state = grasps[0].grasp.tool_state
    goals = np.array([grasp.start for grasp in grasps if grasp.grasp.tool_state == state])
    planning = context.checker_for(belt.coming, Mode(state, reserve=COARSE_RESERVE))
    proving, limits = context.checker_for(belt.coming, Mode(state)), context.cell.robot.limits
    return {
        (name, riding.id): BenchmarkQuery(
            context.cell, named.q, unwound_towards(limits, goals, named.q), planning, proving
        )
        for name, named in context.cell.configurations.items()
        if planning.is_valid(named.q)
    }


def _pregrasps(
    context: PlanningContext, belt: QueryBelt, query: InterceptQuery, seed: int
) -> list[GraspMotion]:
    """Return the grasps, raised to where they begin over the belt. Raises NoPlanError if there is none."""
    t_contact = (max(belt.first, 0.0) + belt.last) / 2
    scene, place = belt.at(t_contact), next(iter(belt.stream.carrier.places))
    into = next(name for name in context.cell.places if name != place)
    picked = PickQuery(place, query.item, into)
    problem = replace(PickProblem.of(context, scene, picked, seed), over_rim=True)
    grasps, failures = feasible_grasps(problem, ())
    found: list[GraspMotion] = []
    for grasp in grasps:
        raised = raised_over_belt(problem, grasp, belt.coming, belt.left(t_contact))
        if isinstance(raised, Failures):
            failures += raised
        else:
            found.append(raised)
    if not found:
        raise NoPlanError(query.label(place), failures)
    return found
