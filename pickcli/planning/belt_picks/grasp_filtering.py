"""Recorded grasps of an item on a belt, filtered as the PR2 system of 2013 did it (Cowley et al., IV-A).

Its chase filter and its kinematic filter are asked where the item is to be met; what passes is planned with.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.errors import NoPlanError
from pickcli.grasping.recorded_filters import RemovedGrasp, filter_grasps
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.recorded_candidates import NO_RECORDED
from pickcli.scene.item_stream import ItemStream

MOST_TOLD = 20  # grasps that a message names


@dataclass(frozen=True, eq=False)
class FilteredContext:
    """What a query is planned with after the filters.

    Attributes:
        context: The context, whose recorded grasps are those that passed.
        removed: The other recorded grasps of the item, each with the filter that removed it, and why.
    """

    context: PlanningContext
    removed: tuple[RemovedGrasp, ...] = ()

    @property
    def told(self) -> tuple[str, ...]:
        """What is told of the removed grasps: a text of each, of many of the first ones."""
        n_more = len(self.removed) - MOST_TOLD
        more = (f"the filters removed {n_more} more recorded grasps",) if n_more > 0 else ()
        return (*map(str, self.removed[:MOST_TOLD]), *more)

    def explained(self, error: NoPlanError) -> NoPlanError:
        """Add the removed grasps to the reasons against a plan.

        Args:
            error: The error of a query with this context.

        Returns:
            The error, the same if no grasp was removed.
        """
        if not self.removed:
            return error
        others = [reason for reason in error.failures if reason.what != NO_RECORDED]
        text = "; ".join((error.text if others else "no recorded grasp passes the filters", *self.told))
        return NoPlanError(
            error.query, (*others, *(each.reason for each in self.removed)), text, error.blockers
        )


def filter_recorded(
    context: PlanningContext, stream: ItemStream, query: InterceptQuery, seed: int
) -> FilteredContext:
    """Filter the recorded grasps of a context for an item, where it is to be met.

    Args:
        context: The cell, with recorded grasps or without.
        stream: The items on the conveyor.
        query: The requested pick, with a place to meet at if the belt runs.
        seed: Seed of inverse kinematics.

    Returns:
        The context to plan with; the same one without recorded grasps. On a belt that stands there is nothing
        to chase, and the kinematic filter alone is asked.

    Raises:
        UnknownNameError: There is no such item.
    """
    riding = stream.find(query.item)
    if context.recorded is None:
        return FilteredContext(context)
    T_belt_item, velocity = riding.T_belt_item.copy(), stream.speed * stream.carrier.T_world_carrier[:3, 0]
    if stream.speed > 0.0:
        assert query.meet_at is not None  # by the rule whose filters these are
        T_belt_item[0, 3] = query.meet_at
    T_world_item = stream.carrier.T_world_carrier @ T_belt_item
    item = riding.item.name, riding.item.year
    found = filter_grasps(context.recorded, item, T_world_item, velocity, context.arm, seed)
    if not found.removed:
        return FilteredContext(context)
    return FilteredContext(replace(context, recorded=found.kept), found.removed)
