"""Exact shapes of a robot's links against each other, at given configurations."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import (
    T_parent_child,
    joint_position,
    link_poses,
    parent_index,
    stated_position,
    touching_joints,
)


class LinkShapes:
    """The links of a robot, posed in each of several configurations.

    Args:
        robot: The robot.
        Q: (N, n) configurations.
        tool_state: State of the tool.
    """

    def __init__(self, robot: Robot, Q: Array, tool_state: ToolState) -> None:
        self._poses = link_poses(robot, Q)
        for i in touching_joints(robot):
            position = joint_position(robot, i, stated_position(robot, tool_state))
            self._poses[i + 1] = self._poses[parent_index(robot, i)] @ T_parent_child(robot, i, position)
        self._links = {link.name: (i, link) for i, link in enumerate(robot.links)}

    def distances(self, a: str, b: str) -> Array:
        """Measure the distances of two links.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) m; 0 where they touch or overlap.
        """
        return np.array([min(x.distance(y) for x, y in solids) for solids in self._posed(a, b)])

    def meet(self, a: str, b: str) -> NDArray[np.bool_]:
        """Find out where two links overlap.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) True where they do.
        """
        return np.array([any(x.meets(y) for x, y in solids) for solids in self._posed(a, b)], dtype=bool)

    def depths(self, a: str, b: str) -> Array:
        """Bound how deep two links overlap.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) m, upper bounds; 0 where they do not overlap.
        """
        return np.array([max(x.depth(y) for x, y in solids) for solids in self._posed(a, b)])

    def _posed(self, a: str, b: str) -> Iterator[list[tuple[Solid, Solid]]]:
        """Yield for each configuration the pairs of solids of two links, posed."""
        of_links = []
        for name in (a, b):
            i, link = self._links[name]
            of_links.append(
                [(Solid(body.shape), self._poses[i] @ body.T_parent_shape) for body in link.bodies]
            )
        pairs = [(x, y) for x, _ in of_links[0] for y, _ in of_links[1]]
        for k in range(self._poses.shape[1]):
            for solid, T in (*of_links[0], *of_links[1]):
                solid.place(T[k])
            yield pairs
