"""Rules by which a trial of a stream chooses the arm and the place of a meeting.

Ours plans for the next items on the belt, each met as early as an arm can that is free, and takes the one
after which most others can still be taken (``pick_schedule``). Of several arms one begins while another is
still on its way, if the two are proven apart; or one moves at a time.

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
    from pickcli.stream_trials.stream_arms import StreamArm


MOST_PLANNED = 4  # as many as are in a window at once, at gaps of 0.4 m


class StreamRule(StrEnum):
    """Where items are met, and by which arm."""

    EARLIEST = "earliest"  # as early as possible, by arms that move at the same time
    ONE_AT_A_TIME = "one-at-a-time"  # as early as possible, by one arm after the other
    PR2_2013 = "pr2-2013"  # at one place for each arm, by the arms in turns

    @property
    def moves_together(self) -> bool:
        """Whether one arm may begin while another is still on its way."""
        return self is StreamRule.EARLIEST

    @property
    def most_planned(self) -> int:
        """For how many of the next items there are plans at most when one of them is chosen."""
        return 1 if self is StreamRule.PR2_2013 else MOST_PLANNED

    def meeting_place(self, context: PlanningContext, carrier: Carrier) -> float | None:
        """Return where an arm meets all items.

        Args:
            context: The cell as the arm sees it.
            carrier: The conveyor.

        Returns:
            m from the infeed: abreast of the arm's shoulder, within the window; None for anywhere.
        """
        if self is not StreamRule.PR2_2013 or carrier.conveyor is None:
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

        if self is not StreamRule.PR2_2013:
            return FilteredContext(context)
        return filter_recorded(context, stream, query, seed)

    def in_turn(self, arms: Sequence[StreamArm], last: StreamArm | None) -> tuple[StreamArm, ...]:
        """Order the arms by which of them tries an item first.

        Args:
            arms: All arms, the preferred one first.
            last: The arm that took the last item; None before the first.

        Returns:
            The arms: as they are preferred, or by the rules of 2013 in turns.
        """
        if self is not StreamRule.PR2_2013:
            return tuple(arms)
        k = 0 if last is None else 1 + arms.index(last)
        return *arms[k:], *arms[:k]
