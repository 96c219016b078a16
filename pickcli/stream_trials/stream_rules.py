"""Rules by which a trial of a stream chooses the arm and the place of a meeting.

Ours plans for the next items on the belt, each met as early as any arm can, with the arm that acted last if
it has a plan, and takes the one after which most others can still be taken (``pick_schedule``).

The rules of the PR2 system of 2013 (Cowley et al., section IV-C) are: every item is met at one fixed place,
the centre of the arm's workspace; an arm tries it if the item is there later than now and the duration of
its motion to the grasp, ``t_pred > now + d_p + d_g``; it moves at once, and waits over the belt for the
rest; arms alternate. Grasps that were recorded pass a chase filter and a kinematic filter first (IV-A).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # the names of the rules are read for every help
    from pickcli.cell.station import Carrier
    from pickcli.planning.belt_picks.belt_query import InterceptQuery
    from pickcli.planning.belt_picks.grasp_filtering import FilteredContext
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.scene.item_stream import ItemStream


MOST_PLANNED = 4  # as many as are in a window at once, at gaps of 0.4 m


class StreamRule(StrEnum):
    """Where items are met, and by which arm."""

    EARLIEST = "earliest"  # as early as possible, by the arm that acted last, if it can
    PR2_2013 = "pr2-2013"  # at one place for each arm, by the arms in turns

    @property
    def most_planned(self) -> int:
        """For how many of the next items there are plans at most when one of them is chosen."""
        return MOST_PLANNED if self is StreamRule.EARLIEST else 1

    def meeting_place(self, context: PlanningContext, carrier: Carrier) -> float | None:
        """Return where an arm meets all items.

        Args:
            context: The cell as the arm sees it.
            carrier: The conveyor.

        Returns:
            m from the infeed: abreast of the arm's shoulder, within the window; None for anywhere.
        """
        if self is StreamRule.EARLIEST or carrier.conveyor is None:
            return None
        T, (first, last) = carrier.T_world_carrier, carrier.conveyor.window
        return min(last, max(first, float(T[:3, 0] @ (context.cell.robot.shoulder - T[:3, 3]))))

    def filtered(
        self, context: PlanningContext, stream: ItemStream, query: InterceptQuery, seed: int
    ) -> FilteredContext:
        """Return what a query is planned with: by the rules of 2013, after the filters of recorded grasps.

        Args:
            context: The cell as the arm sees it, with recorded grasps or without.
            stream: The items on the conveyor.
            query: The requested pick.
            seed: Seed of inverse kinematics.

        Returns:
            The context, and the grasps that were removed from it.

        Raises:
            UnknownNameError: There is no such item.
        """
        from pickcli.planning.belt_picks.grasp_filtering import FilteredContext, filter_recorded

        if self is StreamRule.EARLIEST:
            return FilteredContext(context)
        return filter_recorded(context, stream, query, seed)

    def in_turn(
        self, contexts: Sequence[PlanningContext], acting: PlanningContext, last: PlanningContext | None
    ) -> tuple[PlanningContext, ...]:
        """Order the arms by which of them tries an item first.

        Args:
            contexts: Those of all arms, the preferred one first.
            acting: That of the arm which is not parked.
            last: That of the arm which took the last item; None before the first.

        Returns:
            All contexts.
        """
        if self is StreamRule.EARLIEST:
            return acting, *(each for each in contexts if each is not acting)
        k = 0 if last is None else 1 + next(i for i, each in enumerate(contexts) if each is last)
        return *contexts[k:], *contexts[:k]
