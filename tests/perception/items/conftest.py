"""A bin with a few items of the package, and the camera on the gripper before it."""

from __future__ import annotations

import pytest

from pickcli.cell.cell import Cell
from pickcli.random_scenes.make_scene import make_scene
from support.filled_bins import CONTENTS, Filled, looked_at


@pytest.fixture(scope="session")
def filled(cell: Cell) -> Filled:
    return looked_at(make_scene({"bin_E": CONTENTS}, cell, seed=5))
