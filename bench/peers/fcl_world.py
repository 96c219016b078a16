"""Exact shapes by python-fcl, and forward kinematics in numpy."""

from __future__ import annotations

from typing import Any

import fcl
import numpy as np


class FclScene:
    """World and robot of one query.

    margin: m by which the solids of the world are grown
    """

    def __init__(self, problem: dict[str, Any], query: dict[str, Any], margin: float) -> None:
        robot, world = query["robot"], problem["scenes"][query["scene"]]
        self.links = robot["links"]
        self.parts = [
            [(_object(shape, np.eye(4)), np.array(shape["T"])) for shape in link["shapes"]]
            for link in self.links
        ]
        solids: dict[str, list[Any]] = {s["name"]: [] for s in world}
        for solid in world:
            if solid["name"] not in query["without"]:
                solids[solid["name"]].append(_object(solid, np.array(solid["T"]), margin))
        self._worlds = self._managers(solids, robot["allowed"])
        untested = {frozenset(pair) for pair in robot["untested"]}
        names = [link["name"] for link in self.links]
        self._pairs = [
            (i, j)
            for i in range(len(names))
            for j in range(i + 1, len(names))
            if frozenset((names[i], names[j])) not in untested and self.parts[i] and self.parts[j]
        ]

    def _managers(self, solids: dict[str, list[Any]], allowed: list[list[str]]) -> list[Any]:
        """For each link the world that it is tested against; most share one."""
        made: dict[frozenset[str], Any] = {}
        worlds = []
        for link in self.links:
            spared = frozenset(name for pair in allowed if link["name"] in pair for name in pair)
            if spared not in made:
                kept = [body for name, bodies in solids.items() if name not in spared for body in bodies]
                made[spared] = fcl.DynamicAABBTreeCollisionManager()
                made[spared].registerObjects(kept)
                made[spared].setup()
            worlds.append(made[spared])
        return worlds

    def is_free(self, q: np.ndarray) -> bool:
        """Whether nothing touches at a configuration."""
        T = np.eye(4)
        for parts, link in zip(self.parts, self.links, strict=True):
            T = T @ joint_pose(link["joint"], q)
            for body, T_link_shape in parts:
                T_shape = T @ T_link_shape
                body.setTransform(fcl.Transform(T_shape[:3, :3], T_shape[:3, 3]))
        return not self._hits_world() and not self._hits_itself()

    def _hits_world(self) -> bool:
        for parts, world in zip(self.parts[1:], self._worlds[1:], strict=True):
            for body, _ in parts:
                found = fcl.CollisionData()
                world.collide(body, found, fcl.defaultCollisionCallback)
                if found.result.is_collision:
                    return True
        return False

    def _hits_itself(self) -> bool:
        for i, j in self._pairs:
            for a, _ in self.parts[i]:
                for b, _ in self.parts[j]:
                    if fcl.collide(a, b, fcl.CollisionRequest(), fcl.CollisionResult()):
                        return True
        return False


def joint_pose(joint: dict[str, Any] | None, q: np.ndarray) -> np.ndarray:
    """Pose (4, 4) of a link in the link before it."""
    if joint is None:
        return np.eye(4)
    T = np.array(joint["T"])
    if joint["kind"] == "fixed":
        return T
    motion, axis, value = np.eye(4), np.array(joint["axis"]), q[joint["q"]]
    if joint["kind"] == "prismatic":
        motion[:3, 3] = value * axis
    else:
        x, y, z = axis
        K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        motion[:3, :3] += np.sin(value) * K + (1.0 - np.cos(value)) * (K @ K)
    return T @ motion


def _object(shape: dict[str, Any], T: np.ndarray, margin: float = 0.0) -> Any:
    return fcl.CollisionObject(geometry(shape, margin), fcl.Transform(T[:3, :3], T[:3, 3]))


def geometry(shape: dict[str, Any], margin: float = 0.0) -> Any:
    """A shape of fcl's, grown on every side."""
    kind, size = shape["kind"], shape["size"]
    if kind == "box":
        return fcl.Box(*(s + 2 * margin for s in size))
    if kind == "cylinder":
        return fcl.Cylinder(size[0] + margin, size[1] + 2 * margin)
    return fcl.Sphere(size[0] + margin)
