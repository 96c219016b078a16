"""Why no corridor is free, and no tool has room: the body that blocks it, at a pose that is not valid."""

from __future__ import annotations

import re

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import Failures
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import CorridorSet, extraction_of
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind

APART = re.compile(r"([\d.]+) mm apart \(([\d.]+) mm are needed")


@pytest.fixture(scope="module")
def problems(cell: Cell, context: PlanningContext) -> list[PickProblem]:
    """The picks of all items of an order."""
    scene = make_scene(make_order(OrderKind.PICK, 2016, 4410).bin_contents, cell, 4410)
    seen = Scene(cell, scene.T_world_pod, scene.items, PoseNoise(0.002, float(np.radians(1.0))))
    tote = cell.places["tote"]
    return [PickProblem(context, seen, cell.places[p.location], p, tote) for p in seen.items]


@pytest.fixture(scope="module")
def reasons(problems: list[PickProblem]) -> list[str]:
    """Every reason against the ways out of the items."""
    found = []
    for problem in problems:
        ways = extraction_of(problem).transforms(CorridorSet.FEW)
        if isinstance(ways, Failures):
            found += [str(reason) for reason in ways]
    return found


def test_what_is_named_is_nearer_than_it_may_be(reasons: list[str]) -> None:
    told = [match for reason in reasons if (match := APART.search(reason))]
    assert len(reasons) > 10
    assert all(float(match[1]) <= float(match[2]) for match in told), told


def test_what_leaves_a_tool_no_room_is_nearer_than_it_may_be(problems: list[PickProblem]) -> None:
    failures = [reason for problem in problems for reason in feasible_grasps(problem, ())[1]]
    without_room = [reason for reason in failures if reason.what == "no room for the tool"]
    segments = {reason.where.rpartition(", ")[2] for reason in without_room}
    assert segments == {"contact", "approach", "lift"}
    told = [match for reason in without_room if (match := APART.search(str(reason)))]
    assert told and all(float(match[1]) <= float(match[2]) for match in told), told
    assert not [reason for reason in failures if reason.what == "no collision"]
