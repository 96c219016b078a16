"""Picks from the belt of pr2_belt, planned once for the tests that look at them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

from pickcli.cell.cell_file import load_workcell
from pickcli.motion.plan import Plan
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import Scene

CELL = "pr2_belt"


@cache
def context(arm: str = "left") -> PlanningContext:
    return PlanningContext(load_workcell(CELL).cell(arm))


def home(arm: str = "left") -> Start:
    named = context(arm).cell.home
    return Start(named.q, named.tool_state)


@cache
def stream(speed: float = 0.33, seed: int = 6, n: int = 4, one_by_one: bool = False) -> ItemStream:
    request = StreamRequest(n, speed, (1.8, 2.4), one_by_one, (0.6, 1.5) if one_by_one else None)
    return make_stream(context().cell, request, seed)


@dataclass(frozen=True, eq=False)
class ArmPick:
    """A plan in which all joints follow the belt, with its stream."""

    stream: ItemStream
    plan: Plan

    @property
    def scene(self) -> Scene:
        """The scene at the start of the plan."""
        assert self.plan.tracking is not None
        return self.stream.scene_at(self.plan.tracking.t_stream)


@cache
def arm_pick(arm: str = "left", k: int = 3) -> ArmPick:
    """The pick of the k-th item by an arm, from 0.3 s after it is on the belt; not verified."""
    items = replace(stream(), cell=context(arm).cell)
    query = InterceptQuery(items.items[k].id, items.items[k].stamp + 0.3, f"bin_{arm}")
    return ArmPick(items, plan_intercept(context(arm), items, query, home(arm)))
