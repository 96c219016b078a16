"""A pick across an area that is narrower than the cup, and two by a base, from outside and from inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PoseNoise
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.verify import certify

BIN = "bin_E"
NOISE = PoseNoise(0.002, float(np.radians(1.0)))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "seed", "face"), [
    ("fiskars_scissors_red", 3000, "+z"), ("rolodex_jumbo_pencil_cup", 3001, "-z"),
    ("rolodex_jumbo_pencil_cup", 3004, "+z/inside"),
])  # fmt: skip
def test_it_is_planned_certified_and_carried_out_where_the_item_really_is(
    cell: Cell, context: PlanningContext, home: Start, name: str, seed: int, face: str
) -> None:
    """The item is 1.5 mm aside of where it is seen."""
    real = make_scene({BIN: [name]}, cell, seed)
    (item,) = real.items
    seen = replace(item, T_world_item=pose([0.0, 0.0015, 0.0]) @ item.T_world_item)
    scene = replace(real, items=(seen,), noise=NOISE)
    plan = certify(plan_pick(context, scene, PickQuery(BIN, name), home), scene)
    assert plan.grasp is not None and plan.grasp.face == face
    world = World(real, home.q, home.tool_state)
    run = execute(plan, world)
    assert run.collisions == () and run.trouble == ""
    assert world.placed(name).location == "tote"
    world.close()
