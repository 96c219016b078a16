"""Checkers of one collision model, each made once; planners get their checkers here and nowhere else."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker, FreeToolChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.scene.scene import Scene

N_KEPT = 64  # of each kind: more than one query needs


class CheckerCache:
    """Makes checkers, and keeps those that were asked for last.

    Scenes and attached items count by identity, as the solids of a scene are kept.

    Args:
        model: The collision model of one cell.

    Attributes:
        model: The collision model of one cell.
    """

    def __init__(self, model: CollisionModel) -> None:
        """Keep nothing yet."""
        self.model = model
        self._robots = lru_cache(maxsize=N_KEPT)(self._robot)
        self._tools = lru_cache(maxsize=N_KEPT)(self._tool)

    def robot(self, scene: Scene, mode: Mode) -> SceneChecker:
        """The checker of motions of the robot.

        Args:
            scene: What stands around it.
            mode: What they must be free for.

        Returns:
            The checker, a kept one if there is one.
        """
        return self._robots(scene, mode)

    def tool(
        self, scene: Scene, tool_state: ToolState, R_world_axes: Array, contacts: AllowedContacts
    ) -> FreeToolChecker:
        """The checker of motions of the tool by itself.

        Args:
            scene: What stands around it.
            tool_state: State of the tool.
            R_world_axes: (3, 3) axes about which the tool is level.
            contacts: What the cup may touch, here however deep.

        Returns:
            The checker, a kept one if there is one.
        """
        return self._tools(scene, tool_state, np.ascontiguousarray(R_world_axes).tobytes(), contacts)

    def item(
        self,
        scene: Scene,
        free: FreeItem,
        contacts: AllowedContacts,
        beside: tuple[FreeItemChecker, ...] = (),
    ) -> FreeItemChecker:
        """The checker of motions of an item by itself; of each there is but one, so that none is kept.

        Args:
            scene: What stands around it.
            free: The item.
            contacts: What it may touch, and how deep.
            beside: The item with nothing but one neighbour each that may roll along.

        Returns:
            A new checker.
        """
        return FreeItemChecker(self.model, scene, free, contacts, beside)

    def _robot(self, scene: Scene, mode: Mode) -> SceneChecker:
        margin = self.model.cell.clearance + mode.reserve
        return SceneChecker(self.model, scene, mode.tool_state, mode.attached, mode.contacts, margin)

    def _tool(
        self, scene: Scene, tool_state: ToolState, axes: bytes, contacts: AllowedContacts
    ) -> FreeToolChecker:
        R_world_axes = np.frombuffer(axes).reshape(3, 3)
        return FreeToolChecker(self.model, scene, tool_state, R_world_axes, contacts)
