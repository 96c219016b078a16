"""Where the tool frame of a cell stands on its flange, by the verifier's kinematics."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, inverse
from pickcli.verification.forward_kinematics import link_poses, tip_poses


def tip_in_flange(cell: Cell, state: ToolState | None = None) -> Array:
    """Pose (4, 4) of the tool frame in the flange link; without a state in the default one."""
    tool, names = cell.robot.tool, [link.name for link in cell.robot.links]
    links = link_poses(cell.robot, np.zeros((1, cell.robot.n_joints)))
    flange = links[names.index(tool.flange_link), 0]
    return np.asarray(inverse(flange) @ tip_poses(cell.robot, links, state or tool.default_state)[0])
