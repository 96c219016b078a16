"""The way of an item through a pick is as the page about the architecture draws it, and short."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import FrameType

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from planning.conftest import SceneWith

ROOT = Path(__file__).parents[2]
ROOM = str(ROOT / "pickcli" / "planning")
MOST_STOPS = 30


def drawn() -> list[str]:
    """The functions in the drawing, in their order."""
    page = (ROOT / "docs" / "architecture.md").read_text()
    (block,) = re.findall(r"```text\n(pick\.plan_pick\n.*?)```", page, re.DOTALL)
    return [line.split()[0] for line in block.splitlines()]


def test_a_pick_goes_the_way_that_is_drawn(
    cell: Cell, planner: PlanningContext, scene_with: SceneWith
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0))
    home = cell.configurations["home"]
    passed: dict[str, None] = {}

    def note(frame: FrameType, event: str, arg: object) -> None:
        code = frame.f_code
        if (
            event == "call"
            and code.co_filename.startswith(ROOM)
            and re.fullmatch("[a-z]\\w*", code.co_qualname)
        ):
            module = Path(code.co_filename).relative_to(ROOM).with_suffix("")
            passed[".".join((*module.parts, code.co_qualname))] = None

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        plan = plan_pick(planner, scene, PickQuery("bin_B", "crayola_24_ct"), Start(home.q, home.tool_state))
    finally:
        sys.setprofile(before)
    assert np.isfinite(plan.trajectory.duration)
    assert list(passed) == drawn()
    assert len(passed) <= MOST_STOPS
