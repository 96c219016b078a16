"""The reach of the default cell: in-bin poses with a free configuration, in every bin."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PoseNoise, Scene
from support.tool_states import DOWN, STRAIGHT

# Tool frames in the bin frame: the lance points into the bin; frontal the cup with it, top-down the cup down.
APPROACHES = {
    STRAIGHT: np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
    DOWN: np.array([[-1.0, 0, 0], [0, 1, 0], [0, 0, -1]]),
}


def poses_in(cell: Cell, name: str, tool_state: ToolState, rng: np.random.Generator, n: int) -> Array:
    """(n, 4, 4) tool poses with the lance 30 mm inside the mouth's edges and the cup behind the lip."""
    cell_bin = cell.pod.bins[name]
    half, height = cell_bin.access.width / 2 - 0.03, cell_bin.access.height
    hangs = float(np.linalg.norm(cell.robot.tool.T_last_tip[:3, 3])) if tool_state == DOWN else 0.0
    points = rng.uniform((0.06, -half, 0.03 - hangs), (0.38, half, height - 0.03 - hangs), (n, 3))
    return np.array([cell_bin.T_carrier_place @ pose(p, R=APPROACHES[tool_state]) for p in points])


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_every_bin_is_within_reach(cell: Cell, arm: Arm, tool_state: ToolState) -> None:
    rng = np.random.default_rng(2016)
    empty = Scene(cell, cell.T_world_pod, (), PoseNoise())
    checker = SceneChecker(CollisionModel(cell), empty, tool_state)
    assert cell.pod.bins
    for name in cell.pod.bins:
        for T in poses_in(cell, name, tool_state, rng, 8):
            solutions = arm.solve_spread(T, tool_state, rng, 32)
            assert len(solutions) and checker.are_valid(solutions).any(), (name, T[:3, 3])
