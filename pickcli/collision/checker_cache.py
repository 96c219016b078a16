"""Cache of the checkers of one collision model, for what is checked in the same scene again and again."""

from __future__ import annotations

from dataclasses import replace
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
    """Makes checkers and caches the most recently used ones.

    Scenes and attached items are compared by identity, like the cached solids of a scene.

    Args:
        model: The collision model of one cell.

    Attributes:
        model: The collision model of one cell.
    """

    def __init__(self, model: CollisionModel) -> None:
        """Create an empty cache."""
        self.model = model
        self._robots = lru_cache(maxsize=N_KEPT)(self._robot)
        self._tools = lru_cache(maxsize=N_KEPT)(self._tool)

    def robot(self, scene: Scene, mode: Mode) -> SceneChecker:
        """Return the checker for motions of the robot.

        Args:
            scene: The planning scene.
            mode: Tool state, attached item, allowed contacts and reserve.

        Returns:
            The checker, from the cache if it is there.
        """
        return self._robots(scene, mode)

    def tool(
        self, scene: Scene, tool_state: ToolState, R_world_axes: Array, contacts: AllowedContacts
    ) -> FreeToolChecker:
        """Return the checker for motions of the tool without the arm.

        Args:
            scene: The planning scene.
            tool_state: State of the tool.
            R_world_axes: (3, 3) axes about which the tool is level.
            contacts: Solids that the cup may touch, at any depth.

        Returns:
            The checker, from the cache if it is there.
        """
        return self._tools(scene, tool_state, np.ascontiguousarray(R_world_axes).tobytes(), contacts)

    def item(
        self,
        scene: Scene,
        free: FreeItem,
        contacts: AllowedContacts,
        beside: tuple[FreeItemChecker, ...] = (),
    ) -> FreeItemChecker:
        """Return the checker for motions of an item as a free flyer; not cached, because each is used once.

        Args:
            scene: The planning scene.
            free: The item.
            contacts: Solids that it may touch, and how deep.
            beside: Checkers of the item with only one neighbour each that may roll along.

        Returns:
            A new checker.
        """
        return FreeItemChecker(self.model, scene, free, contacts, beside)

    def _robot(self, scene: Scene, mode: Mode) -> SceneChecker:
        if mode.reserve != 0.0:  # the same solids, another margin
            without = self.robot(scene, replace(mode, reserve=0.0))
            return without.at_margin(self.model.cell.clearance + mode.reserve)
        return SceneChecker(self.model, scene, mode.tool_state, mode.attached, mode.contacts)

    def _tool(
        self, scene: Scene, tool_state: ToolState, axes: bytes, contacts: AllowedContacts
    ) -> FreeToolChecker:
        R_world_axes = np.frombuffer(axes).reshape(3, 3)
        return FreeToolChecker(self.model, scene, tool_state, R_world_axes, contacts)
