"""A pick with two fingers as it is played: from plan to delivered, and what tells that it went wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.world import World
from support.gripper_cell import CLOSED, OPEN

ERASER = "expo_dry_erase_board_eraser"  # 130 x 54 x 35 mm, 20 g


@pytest.fixture(scope="module")
def scene(gripper_cell: Cell) -> Scene:
    place, item = gripper_cell.places["tote"], gripper_cell.item(ERASER)
    T = gripper_cell.T_world_place(place) @ pose((0.1, 0.0, item.shape.extents[2] / 2), rpy=(0.0, 0.0, 0.3))
    return Scene(gripper_cell, gripper_cell.T_world_pod, (PlacedItem(ERASER, item, "tote", T),), PoseNoise())


@pytest.fixture(scope="module")
def plan(gripper_cell: Cell, scene: Scene) -> Plan:
    start = Start(gripper_cell.configurations["home"].q, OPEN)
    return plan_pick(PlanningContext(gripper_cell), scene, PickQuery("tote", ERASER), start, seed=1)


def played(
    plan: Plan, scene: Scene, on_step: Callable[[World], None] | None = None
) -> tuple[World, Execution]:
    world = World(scene, plan.trajectory.positions[0], OPEN)
    return world, execute(plan, world, on_step=on_step)


def test_a_pick_is_played_from_its_plan_to_the_item_let_go(plan: Plan, scene: Scene) -> None:
    slips: list[float] = []

    def look(world: World) -> None:
        assert world.fingers is not None
        slips.append(world.fingers.slip)

    world, run = played(plan, scene, look)
    assert run.trouble == "" and run.is_clean
    assert [(e.event.action, e.reading) for e in run.events] == [("closed", None), ("open", None)]
    (fall,) = run.falls
    assert fall.is_wanted and fall.item == ERASER
    assert world.held is None and world.tool_state == OPEN and world.placed(ERASER).location == "tote"
    assert max(slips) < 5e-4
    assert plan.grasp is not None and 0.0 < run.max_load < 1.5 * plan.grasp.load_ratio + 0.01
    world.close()


def test_an_item_that_is_not_there_is_told_by_the_width_of_the_fingers(plan: Plan, scene: Scene) -> None:
    (placed,) = scene.items
    aside = replace(placed, T_world_item=pose((-0.2, 0.0, 0.0)) @ placed.T_world_item)
    world, run = played(plan, replace(scene, items=(aside,)))
    assert run.stop is not None and run.stop.cause is StopCause.NOT_GRASPED
    assert run.stopped_in is SegmentKind.LIFT and run.has_item is False
    assert run.stop.measured < 0.01 and run.stop.threshold == pytest.approx(0.054 - 0.005)
    assert world.tool_state == CLOSED and run.collisions == ()
    world.close()


def test_an_item_that_slides_away_is_told_by_fingers_that_close_further(plan: Plan, scene: Scene) -> None:
    transfer = next(s for s in plan.segments if s.kind is SegmentKind.TRANSFER)

    def grow_slippery(world: World) -> None:
        assert world.fingers is not None
        if world.t > transfer.t_start:
            world.fingers.friction = 1e-3

    world, run = played(plan, scene, grow_slippery)
    assert run.stop is not None and run.stop.cause is StopCause.GRASP_LOST
    assert run.has_item is False
    assert [(r.item, r.is_wanted) for r in run.releases] == [(ERASER, False)]
    world.close()
