"""Exact shapes of a robot's links against each other, at given configurations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.verification.fcl_solids import PosedGeometry, Solid, Surface
from pickcli.verification.forward_kinematics import (
    T_parent_child,
    joint_position,
    link_poses,
    parent_index,
    stated_position,
    touching_joints,
)

G = TypeVar("G", bound=PosedGeometry)


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
        pairs = self._posed(self._solids(a), self._solids(b))
        return np.array([min(x.distance(y) for x, y in each) for each in pairs])

    def depths(self, a: str, b: str) -> Array:
        """Bound how deep two links overlap.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) m, upper bounds; 0 where they do not overlap.
        """
        pairs = self._posed(self._solids(a), self._solids(b))
        return np.array([max(x.depth(y) for x, y in each) for each in pairs])

    def overlap(self, a: str, b: str) -> NDArray[np.bool_]:
        """Find out where the shapes of two links overlap, of meshes their convex pieces.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) True where they do.
        """
        pairs = self._posed(self._solids(a), self._solids(b))
        return np.array([any(x.meets(y) for x, y in each) for each in pairs], dtype=bool)

    def touch(self, a: str, b: str) -> NDArray[np.bool_]:
        """Find out where two links touch, of meshes the triangles themselves.

        Args:
            a: Name of one link.
            b: Name of the other.

        Returns:
            (N,) True where they do; not where one mesh lies in the other.

        Raises:
            InputError: The file of a mesh cannot be read any more.
        """
        pairs = self._posed(self._surfaces(a), self._surfaces(b))
        return np.array([any(x.meets(y) for x, y in each) for each in pairs], dtype=bool)

    def _solids(self, name: str) -> list[tuple[Solid, Array]]:
        """Solids of a link, each with its poses (N, 4, 4) in the world."""
        i, link = self._links[name]
        return [(Solid(body.shape), self._poses[i] @ body.T_parent_shape) for body in link.bodies]

    def _surfaces(self, name: str) -> list[tuple[PosedGeometry, Array]]:
        """Solids of a link with the meshes in place of their pieces, likewise."""
        i, link = self._links[name]
        found: list[tuple[PosedGeometry, Array]] = []
        known = set()
        for body in link.bodies:
            if body.piece_of is None:
                found.append((Solid(body.shape), self._poses[i] @ body.T_parent_shape))
                continue
            mesh, T = body.piece_of, body.T_parent_shape @ body.piece_of.T_shape_mesh
            key = (mesh.path, mesh.scale, (T.round(9) + 0.0).tobytes())  # of all pieces of one mesh
            if key not in known:
                known.add(key)
                found.append((Surface(mesh.path, mesh.scale), self._poses[i] @ T))
        return found

    def _posed(
        self, a: Sequence[tuple[G, Array]], b: Sequence[tuple[G, Array]]
    ) -> Iterator[list[tuple[G, G]]]:
        """Yield for each configuration the pairs of geometries of two links, posed."""
        pairs = [(x, y) for x, _ in a for y, _ in b]
        for k in range(self._poses.shape[1]):
            for geometry, T in (*a, *b):
                geometry.place(T[k])
            yield pairs
