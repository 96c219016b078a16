"""Coarse motions tell everything that kept them from every goal."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoPlanError
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from support.tool_states import STRAIGHT

GOALS = ("bin_A", "bin_L")


def carton(name: str) -> Item:
    shape = Shape(ShapeKind.BOX, (0.1, 0.1, 0.1))
    return Item(name, 2016, shape, 0.2, 0, dict.fromkeys(shape.face_names, 1.0), "test", "", 0.0, 1.0, "", "")


@pytest.fixture(scope="module")
def blocked(cell: Cell, context: PlanningContext) -> Scene:
    """An item around the tip of the tool in each of two configurations."""
    tips = [context.arm.tip(cell.configurations[name].q, STRAIGHT) for name in GOALS]
    items = (PlacedItem(f"at_{g}", carton("carton"), g, T) for g, T in zip(GOALS, tips, strict=True))
    return Scene(cell, cell.T_world_pod, tuple(items), PoseNoise())


def test_what_stands_at_any_of_the_goals_is_named(
    cell: Cell, context: PlanningContext, blocked: Scene
) -> None:
    checker = context.checker_for(blocked, Mode(STRAIGHT))
    goals = np.stack([cell.configurations[name].q for name in GOALS])
    found = plan_coarse(context, checker, cell.configurations["home"].q, goals, [0.0, 0.0], 1, "transit")
    assert isinstance(found, Failures)
    assert set(found.in_the_way) == {"at_bin_A", "at_bin_L"}
    assert {reason.where for reason in found} == {"transit, goal 0", "transit, goal 1"}


def test_what_stands_where_a_move_begins_is_named(
    cell: Cell, context: PlanningContext, blocked: Scene
) -> None:
    start = Start(cell.configurations["bin_A"].q, STRAIGHT)
    with pytest.raises(NoPlanError) as caught:
        plan_move(context, blocked, start, MoveGoal(cell.configurations["home"].q))
    assert caught.value.in_the_way == ("at_bin_A",)
    assert [reason.where for reason in caught.value.reasons] == ["move, start"]


def test_no_path_is_told_with_one_place(context: PlanningContext, cell: Cell) -> None:
    hasty = replace(context, settings=replace(context.settings, rrt_iterations=1))
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    start, goal = (cell.configurations[name].q for name in ("bin_A", "drop_12_down"))
    checker = hasty.checker_for(scene, Mode(STRAIGHT))
    assert not checker.is_valid_edge(start, goal)
    found = plan_coarse(hasty, checker, start, goal[None], [0.0], 1, "transit")
    assert isinstance(found, Failures)
    told = [(reason.what, reason.where) for reason in found]
    assert told == [("no path", "transit"), ("collision", "transit")]  # the latter of the straight edge
