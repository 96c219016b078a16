"""The way of an item through a pick is as the page about the architecture draws it, short, and leads down."""

from __future__ import annotations

import ast
import re
import sys
from functools import cache
from itertools import groupby, pairwise
from pathlib import Path
from types import FrameType

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from planning.conftest import SceneWith

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "pickcli" / "planning"
MOST_STOPS, MOST_STEPS_BACK = 30, 5

# What stages hand to each other. A method of these derives a value from the value that it belongs to: who
# reads `problem.contacts` does not go there, so it is no stop. The methods of all other classes do work and
# are counted.
VALUES = ("pick_problem", "pick_motion", "planning_context")


def drawn() -> list[str]:
    """The functions and methods in the drawing, in their order."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    (block,) = re.findall(r"```text\n(pick\.plan_pick\n.*?)```", page, re.DOTALL)
    return [line.split()[0] for line in block.splitlines()]


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
def passed(cell: Cell, context: PlanningContext, scene_with: SceneWith) -> list[tuple[str, str]]:
    """(module, name) of what is called in the package, in the order of the first calls.

    Every function and every method is there, private ones and properties too, but the methods of VALUES.
    Comprehensions and functions within functions count as what they stand in.
    """
    scene = scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0))
    home = cell.configurations["home"]
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
        plan = plan_pick(context, scene, PickQuery("bin_B", "crayola_24_ct"), Start(home.q, home.tool_state))
    finally:
        sys.setprofile(before)
    assert np.isfinite(plan.trajectory.duration)
    return list(found)


def test_a_pick_goes_the_way_that_is_drawn(passed: list[tuple[str, str]]) -> None:
    public = [f"{module}.{name}" for module, name in passed if not re.search(r"\b_", name)]
    assert public == drawn()


def stops_of(passed: list[tuple[str, str]]) -> list[str]:
    """The modules that are entered, one after the other."""
    return [module for module, _ in groupby(module for module, _ in passed)]


def steps_back(stops: list[str]) -> list[tuple[str, str]]:
    """The steps from a module to one that stands higher by its imports."""
    return [(a, b) for a, b in pairwise(stops) if floor(f"planning.{b}") > floor(f"planning.{a}")]


def test_the_way_of_a_pick_is_short_and_seldom_leads_back_up(passed: list[tuple[str, str]]) -> None:
    """A stop is a module that is entered; a step back leads to one that stands higher than the last."""
    assert any(name.startswith("_") for _, name in passed) and any("." in name for _, name in passed)
    stops = stops_of(passed)
    assert len(stops) <= MOST_STOPS
    back = steps_back(stops)
    assert len(back) <= MOST_STEPS_BACK, back
