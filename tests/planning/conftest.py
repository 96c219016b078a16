"""One warm planner, and a scene with one box in the middle of a bin."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

SceneWith = Callable[..., Scene]


@pytest.fixture(scope="session")
def context(cell: Cell) -> PlanningContext:
    return PlanningContext(cell)


@pytest.fixture(scope="session")
def home(cell: Cell) -> Start:
    named = cell.configurations["home"]
    return Start(named.q, named.tool_state)


@pytest.fixture(scope="session")
def scene_with(cell: Cell) -> SceneWith:
    """scene_with(("crayola_24_ct", "bin_B", x, y), ...): items level on the bins' floors."""

    def make(*entries: tuple[str, str, float, float]) -> Scene:
        placed = []
        for name, bin_name, x, y in entries:
            item, cell_bin = cell.item(name), cell.pod.bins[bin_name]
            floor, _ = cell_bin.room.rest(np.array(x - item.shape.extents[0] / 2), np.array(0.0))
            z = float(floor) + float(item.shape.extents[2]) / 2 + 0.0005
            T = cell.T_world_place(cell_bin) @ pose([x, y, z])
            placed.append(PlacedItem(name, item, bin_name, T))
        noise = PoseNoise(0.002, float(np.radians(1.0)))
        return Scene(cell, cell.T_world_pod, tuple(placed), noise)

    return make
