"""The default cell's arm, and forward kinematics in numpy as its oracle."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.kinematics.arm import Arm


@pytest.fixture(scope="session")
def arm(cell: Cell) -> Arm:
    return Arm(cell.robot)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(2016)
