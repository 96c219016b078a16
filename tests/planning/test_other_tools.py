"""Picks with a tool of one state and of three: planned, certified, and carried out in simulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from pickcli.cell.tool import FIXED, MOVING
from pickcli.errors import NoPlanError
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.verify import certify
from support.cell_copies import CellCopy
from support.other_tools import ONE_STATE, THREE_STATES, with_tool

SceneWith = Callable[..., Scene]


BOTTLE, CRAYONS = "dasani_water_bottle", "crayola_24_ct"  # held from the front, and only from above


@pytest.mark.parametrize(("kind", "item", "n_turns"), [(ONE_STATE, BOTTLE, 0), (THREE_STATES, CRAYONS, 1)])
def test_a_pick_is_certified_and_carried_out(
    cell_copy: CellCopy, scene_with: SceneWith, kind: str, item: str, n_turns: int
) -> None:
    cell = with_tool(cell_copy, kind).load()
    scene = replace(scene_with((item, "bin_E", 0.25, 0.0)), cell=cell)
    home = cell.configurations["home"]
    start = Start(home.q, home.tool_state)
    plan = certify(plan_pick(PlanningContext(cell), scene, PickQuery("bin_E", item), start, seed=3), scene)
    assert sum(event.device == "cup_pivot" for event in plan.events) == n_turns
    assert {segment.tool_state for segment in plan.segments} <= set(cell.robot.tool.states_and_moving)
    assert kind != ONE_STATE or MOVING not in {segment.tool_state for segment in plan.segments}
    world = World(scene, home.q)
    execute(plan, world)
    assert world.placed(item).location == "tote" and not world.contacts.collisions
    assert world.tool_state == plan.segments[-1].tool_state
    world.close()


def test_a_grasp_that_no_state_serves_is_refused_for_that(cell_copy: CellCopy, scene_with: SceneWith) -> None:
    cell = with_tool(cell_copy, ONE_STATE).load()
    scene = replace(scene_with((CRAYONS, "bin_E", 0.25, 0.0)), cell=cell)
    start = Start(cell.configurations["home"].q, FIXED)
    with pytest.raises(NoPlanError, match="no state of the tool for this grasp"):
        plan_pick(PlanningContext(cell), scene, PickQuery("bin_E", CRAYONS), start)
