"""The tool by itself, moved along straight lines: can it get there at all, whatever arm holds it?

Far cheaper to ask than an arm, which has to be brought there by inverse kinematics first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import PivotState
from pickcli.cell.scene import Scene
from pickcli.collision.explain import Contact
from pickcli.collision.floating import CUP, LANCE, N_FREE, floating_chain, tool_spheres
from pickcli.collision.model import CollisionModel
from pickcli.collision.world import build_world
from pickcli.geometry import Array, pose
from pickcli.kernel import Checker

ROLL_JUMPS = 0.75 * np.pi  # rad, where roll starts anew

# The axes of the tool frame that become x, y, z of the turning joints: x along the lance, into the bin, and z
# away from where a pivoted cup points, so that yaw and pitch stay far from where they jump.
_R_TOOL_TURNING = {
    PivotState.STRAIGHT: np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]),
    PivotState.DOWN: np.diag([-1.0, 1.0, -1.0]),
}


class ToolGhost:
    """Lance and cup in one pivot state at any pose of the tool frame, as the covers of the robot have them.

    R_world_axes: (3, 3) axes about which the tool is level. without: ids of items that are not there.
    touching: names that the cup may touch; the lance keeps clear of them.
    """

    def __init__(
        self, model: CollisionModel, scene: Scene, pivot: PivotState, R_world_axes: Array,
        without: frozenset[str], touching: frozenset[str] = frozenset(),
    ) -> None:  # fmt: skip
        self.margin = model.cell.clearance
        self._R_axes, self._R_tool = R_world_axes, _R_TOOL_TURNING[pivot]
        self._parts = {LANCE: model.robot.tool.lance_link, CUP: model.robot.tool.cup_link}
        spheres = tool_spheres(model, pivot, pose(R=self._R_tool.T))
        chain = floating_chain(np.zeros(3), R_world_axes)
        self._kernel = Checker(chain, *spheres, np.zeros((0, 2), np.int32))
        world = build_world(model, scene)
        self._kept = np.flatnonzero(world.is_kept(without))
        self._names, self._kinds = world.names, world.kinds
        ignored = np.zeros(len(world.names), np.uint64)
        ignored[world.indices(touching - without)] = np.uint64(1 << CUP)
        world.enter(self._kernel, self._kept, ignored)

    def are_free(self, T_world_tip: Array) -> NDArray[np.bool_]:
        """(N,) whether the tool keeps the clearance at each of the poses (N, 4, 4)."""
        if len(T_world_tip) == 0:
            return np.zeros(0, dtype=bool)
        return np.asarray(self._kernel.are_free(self._displacements(T_world_tip), self.margin), dtype=bool)

    def path_is_free(self, T_world_tip: Array) -> int:
        """Index of the first straight push of the poses (N, 4, 4) that is not proven free, or -1."""
        return int(self._kernel.path_is_free(self._displacements(T_world_tip), self.margin))

    def clearance(self, T_world_tip: Array) -> Contact:
        """What is closest to the tool at a pose (4, 4)."""
        distance, frame, _, index = self._kernel.clearance(self._displacements(T_world_tip[None])[0], 1.0)
        if frame < 0:
            return Contact(float(distance), "", "")
        solid = int(self._kept[index])
        return Contact(float(distance), self._parts[frame], self._names[solid], self._kinds[solid])

    def _displacements(self, T: Array) -> Array:
        """(N, 6): x, y, z along the axes, then yaw, pitch and roll."""
        R = self._R_axes.T @ T[:, :3, :3] @ self._R_tool
        d = np.empty((len(T), N_FREE))
        d[:, :3] = T[:, :3, 3] @ self._R_axes
        d[:, 3] = np.arctan2(R[:, 1, 0], R[:, 0, 0])
        d[:, 4] = np.arcsin(np.clip(-R[:, 2, 0], -1.0, 1.0))
        roll = np.arctan2(R[:, 2, 1], R[:, 2, 2])
        d[:, 5] = (roll + ROLL_JUMPS) % (2 * np.pi) - ROLL_JUMPS  # as no quarter turn is there
        return d
