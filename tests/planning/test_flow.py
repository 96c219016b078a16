"""The way of an item through a pick is as the page about the architecture draws it, short, and leads down.

So is that of an item that is stowed: taken out of the tote, and set down in a bin.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Callable
from functools import cache
from itertools import groupby, pairwise
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from planning.conftest import SceneWith

ITEM = "crayola_24_ct"
ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pickcli" / "planning"
MOST_STOPS = 30  # modules that are entered
MOST_DRAWN = 34  # functions and methods in a drawing; three are public because picks from belts share them
MOST_STEPS_BACK = {"pick": 5, "stow": 6}  # a stow plans a second pick, which takes the item back

# What stages hand to each other. A method of these derives a value from the value that it belongs to: who
# reads `problem.contacts` does not go there, so it is no stop. The methods of all other classes do work and
# are counted.
VALUES = ("pick_problem", "pick_motion", "planning_context")


def drawn() -> dict[str, list[str]]:
    """The functions and methods in the two drawings, in their order."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    blocks = re.findall(r"```text\n(pick\.plan_pick\n.*?)```", page, re.DOTALL)
    functions = [[line.split()[0] for line in block.splitlines()] for block in blocks]
    return dict(zip(("pick", "stow"), functions, strict=True))


@cache
def floor(module: str) -> int:
    """How many modules stand on each other below one, by its imports."""
    path = ROOT / "pickcli" / f"{module.replace('.', '/')}.py"
    if not path.exists():
        return 0
    nodes = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ImportFrom))
    below = (str(node.module) for node in nodes if str(node.module).startswith("pickcli."))
    return 1 + max((floor(name.removeprefix("pickcli.")) for name in below), default=0)


@pytest.fixture(scope="module")
def in_tote(cell: Cell) -> Scene:
    """One box in the tote."""
    item = cell.item(ITEM)
    T_tote_item = pose([0.1, 0.0, float(item.shape.extents[2]) / 2 + 0.0005])
    placed = PlacedItem(ITEM, item, TOTE, cell.T_world_place(cell.places[TOTE]) @ T_tote_item)
    return Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))


@pytest.fixture(scope="module")
def passed(
    context: PlanningContext, scene_with: SceneWith, in_tote: Scene, home: Start
) -> dict[str, list[tuple[str, str]]]:
    """(module, name) of what is called in the package by a pick and by a stow."""
    in_bin = scene_with((ITEM, "bin_B", 0.2, 0.0))
    return {
        "pick": called(lambda: plan_pick(context, in_bin, PickQuery("bin_B", ITEM), home)),
        "stow": called(lambda: plan_pick(context, in_tote, PickQuery(TOTE, ITEM, into="bin_H"), home)),
    }


def called(query: Callable[[], Plan]) -> list[tuple[str, str]]:
    """(module, name) of what a query calls in the package, in the order of the first calls.

    Every function and every method is there, private ones and properties too, but the methods of VALUES.
    Comprehensions and functions within functions count as what they stand in.
    """
    found: dict[tuple[str, str], None] = {}

    def note(frame: FrameType, event: str, arg: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(str(PACKAGE)) and "<" not in code.co_qualname:
            module = ".".join(Path(code.co_filename).relative_to(PACKAGE).with_suffix("").parts)
            if "." not in code.co_qualname or module not in VALUES:
                found[module, code.co_qualname] = None

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        plan = query()
    finally:
        sys.setprofile(before)
    assert np.isfinite(plan.trajectory.duration)
    return list(found)


@pytest.mark.parametrize("query", MOST_STEPS_BACK)
def test_an_item_goes_the_way_that_is_drawn(passed: dict[str, list[tuple[str, str]]], query: str) -> None:
    public = [f"{module}.{name}" for module, name in passed[query] if not re.search(r"\b_", name)]
    assert public == drawn()[query]


def stops_of(passed: list[tuple[str, str]]) -> list[str]:
    """The modules that are entered, one after the other."""
    return [module for module, _ in groupby(module for module, _ in passed)]


def steps_back(stops: list[str]) -> list[tuple[str, str]]:
    """The steps from a module to one that stands higher by its imports."""
    return [(a, b) for a, b in pairwise(stops) if floor(f"planning.{b}") > floor(f"planning.{a}")]


@pytest.mark.parametrize(("query", "most_back"), MOST_STEPS_BACK.items())
def test_the_way_is_short_and_seldom_leads_back_up(
    passed: dict[str, list[tuple[str, str]]], query: str, most_back: int
) -> None:
    """A stop is a module that is entered; a step back leads to one that stands higher than the last."""
    names = [name for _, name in passed[query]]
    assert any(name.startswith("_") for name in names) and any("." in name for name in names)
    stops = stops_of(passed[query])
    assert len(stops) <= MOST_STOPS
    assert len(drawn()[query]) <= MOST_DRAWN
    back = steps_back(stops)
    assert len(back) <= most_back, back
