"""OMPL's RRTConnect, states tested by pybullet."""

from __future__ import annotations

import tempfile
from itertools import combinations
from typing import Any

import numpy as np
import pybullet
from ompl import util

from bench.peers.ompl_peer import OmplPeer

PACKAGES = ("ompl", "pybullet")


class Peer(OmplPeer):
    """See ``worker``."""

    def __init__(self, problem: dict[str, Any]) -> None:
        super().__init__(problem)
        pybullet.connect(pybullet.DIRECT)

    def prepare(self, query: dict[str, Any], number: int) -> None:
        """Everything that does not count as planning."""
        util.RNG.setSeed(number + 1)
        pybullet.resetSimulation()
        self._world: dict[str, list[int]] = {}
        for solid in self.problem["scenes"][query["scene"]]:
            if solid["name"] not in query["without"]:
                self._world.setdefault(solid["name"], []).append(_body(solid, self.problem["margin"]))
        self._robot = _robot(query["robot"]["urdf"])
        infos = [pybullet.getJointInfo(self._robot, j) for j in range(pybullet.getNumJoints(self._robot))]
        index = {info[1].decode(): info[0] for info in infos}
        self._joints = [index[name] for name in self.problem["joint_names"]]
        self._links = {info[12].decode(): info[0] for info in infos}
        self._links[query["robot"]["links"][0]["name"]] = -1
        self._spare(query["robot"])
        self.is_free = self._is_free

    def _spare(self, robot: dict[str, Any]) -> None:
        """Leave out the pairs that are not tested."""
        for a, b in combinations(self._links, 2):
            is_tested = [a, b] not in robot["untested"] and [b, a] not in robot["untested"]
            pybullet.setCollisionFilterPair(
                self._robot, self._robot, self._links[a], self._links[b], int(is_tested)
            )
        for pair in robot["allowed"]:
            link = next(name for name in pair if name in self._links)
            for body in self._world.get(next(name for name in pair if name != link), []):
                pybullet.setCollisionFilterPair(self._robot, body, self._links[link], -1, 0)

    def _is_free(self, q: np.ndarray) -> bool:
        pybullet.resetJointStatesMultiDof(self._robot, self._joints, [[value] for value in q])
        pybullet.performCollisionDetection()
        # Index 8 is the distance: contacts within the breaking threshold are listed before they touch.
        return all(contact[8] > 0.0 for contact in pybullet.getContactPoints(self._robot))


def _robot(urdf: str) -> int:
    flags = pybullet.URDF_USE_SELF_COLLISION | pybullet.URDF_USE_SELF_COLLISION_INCLUDE_PARENT
    with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
        file.write(urdf)
        file.flush()
        return int(pybullet.loadURDF(file.name, useFixedBase=True, flags=flags))


def _body(solid: dict[str, Any], margin: float) -> int:
    kind, size, T = solid["kind"], solid["size"], np.array(solid["T"])
    if kind == "box":
        half = [s / 2 + margin for s in size]
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=half)
    elif kind == "cylinder":
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_CYLINDER, radius=size[0] + margin, height=size[1] + 2 * margin
        )
    else:
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=size[0] + margin)
    rotation = _quaternion(T[:3, :3])
    return int(pybullet.createMultiBody(0.0, shape, basePosition=T[:3, 3], baseOrientation=rotation))


def _quaternion(R: np.ndarray) -> list[float]:
    """x, y, z, w of a rotation matrix."""
    from scipy.spatial.transform import Rotation

    return [float(value) for value in Rotation.from_matrix(R).as_quat()]
