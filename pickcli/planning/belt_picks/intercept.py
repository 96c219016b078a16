"""``plan_intercept``: a pick from a running conveyor, met at the earliest time at which the arm can be there.

Relative to the belt its items stand still, so grasp and lines are those of a pick from a table. Where a
linear axis runs along the belt, that axis follows it (``axis_intercept``), else the whole arm does
(``arm_intercept``).
"""

from __future__ import annotations

from pickcli.collision.motion_segment import Mode
from pickcli.errors import NoPlanError
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import Certify, Plan
from pickcli.planning.belt_picks.arm_intercept import plan_arm_intercept, why_unmet
from pickcli.planning.belt_picks.axis_intercept import plan_axis_intercept, why_out_of_time
from pickcli.planning.belt_picks.belt_query import InterceptQuery, QueryBelt
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.item_stream import ItemStream


def plan_intercept(
    context: PlanningContext,
    stream: ItemStream,
    query: InterceptQuery,
    start: Start,
    seed: int = 0,
    certify: Certify | None = None,
) -> Plan:
    """Plan the pick of an item that rides on a conveyor; from a belt that stands, as from any place.

    Args:
        context: The cell, its models and its precomputed files.
        stream: The items on the conveyor.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.
        seed: Seed of all random choices.
        certify: Returns the plan with its certificate, or the reasons for its rejection; None leaves plans
            uncertified.

    Returns:
        The plan, valid for ``stream.scene_at(query.now)``.

    Raises:
        UnknownNameError: There is no such item or destination.
        NoPlanError: The item cannot be met, with every reason.
    """
    stream.find(query.item)
    scene = stream.scene_at(query.now)
    if stream.speed == 0.0:
        picked = PickQuery(next(iter(stream.carrier.places)), query.item, query.into)
        return plan_pick(context, scene, picked, start, seed, certify=certify)
    belt = QueryBelt.of(stream, scene, query)
    if (never := _why_unmet(context, belt, query, start)) is not None:
        raise never
    standing = context.checker_for(scene, Mode(start.tool_state))
    if not standing.is_valid(start.q):
        raise NoPlanError(query.label(stream.conveyor), [standing.explain(start.q).at("start")])
    plan = plan_axis_intercept if _has_axis_along(context, stream) else plan_arm_intercept
    return plan(context, belt, query, start, seed, certify)


def why_never(
    context: PlanningContext, stream: ItemStream, query: InterceptQuery, start: Start
) -> NoPlanError | None:
    """Tell by bounds or a table alone, in about a millisecond, that there is no plan.

    Args:
        context: The cell and its models.
        stream: The items on a conveyor that runs.
        query: The requested pick.
        start: Configuration and tool state in which the robot is at rest.

    Returns:
        The error that ``plan_intercept`` would raise; None if a search may find a plan.
    """
    try:
        belt = QueryBelt.of(stream, stream.scene_at(query.now), query)
    except NoPlanError as error:
        return error
    return _why_unmet(context, belt, query, start)


def _why_unmet(
    context: PlanningContext, belt: QueryBelt, query: InterceptQuery, start: Start
) -> NoPlanError | None:
    """Say by bounds alone that an item on the belt cannot be met."""
    if _has_axis_along(context, belt.stream):
        return why_out_of_time(context, belt, query, start)
    return why_unmet(context, belt, query)


def _has_axis_along(context: PlanningContext, stream: ItemStream) -> bool:
    """Whether a linear axis of the robot runs along the belt."""
    return linear_axis(context.cell.robot, stream.carrier.T_world_carrier[:3, 0]) is not None
