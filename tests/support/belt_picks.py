"""Picks from the belt of conveyor_sia20, planned once for the tests that look at them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.motion.plan import Plan
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import Scene

CELL = "conveyor_sia20"


@dataclass(frozen=True, eq=False)
class BeltPick:
    """A plan with its stream, and the time of the stream at which it starts."""

    stream: ItemStream
    now: float
    plan: Plan

    @property
    def scene(self) -> Scene:
        """The scene at the start of the plan."""
        return self.stream.scene_at(self.now)


@cache
def context() -> PlanningContext:
    return PlanningContext(load_cell(CELL))


def cell() -> Cell:
    return context().cell


def home() -> Start:
    return Start(cell().home.q, cell().home.tool_state)


@cache
def stream(speed: float = 0.33, seed: int = 4, n: int = 6) -> ItemStream:
    return make_stream(cell(), StreamRequest(n, speed, (0.03, 0.30)), seed)


@cache
def pick_on_the_way(k: int = 2) -> BeltPick:
    """The pick of an item in the window, from over the tote: the axis comes up to its speed on the way."""
    items, over_tote = stream(seed=3), cell().configurations["drop_01"]
    now = items.items[k].stamp + (1.35 - float(items.items[k].T_belt_item[0, 3])) / items.speed
    query = InterceptQuery(items.items[k].id, now)
    start = Start(over_tote.q, over_tote.tool_state)
    return BeltPick(items, now, plan_intercept(context(), items, query, start))


@cache
def belt_pick(speed: float = 0.33, seed: int = 4, k: int = 1) -> BeltPick:
    """The pick of the k-th item, from 0.3 s after it is on the belt."""
    items = stream(speed, seed)
    now = items.items[k].stamp + 0.3
    return BeltPick(
        items, now, plan_intercept(context(), items, InterceptQuery(items.items[k].id, now), home())
    )
