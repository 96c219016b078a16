"""The door to pybullet: the state of bodies, motors, forces and pictures; poses as (4, 4) arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array, from_quaternion, pose
from pickcli.simulation.engine_bodies import PROBED, EngineBodies
from pickcli.simulation.engine_bodies import pybullet as p


@dataclass(frozen=True)
class Touch:
    """One contact point between two bodies as the engine found it.

    link_a, link_b: names of the links ("" for bodies of one part)
    depth: m, positive when the shapes overlap
    position: (x, y, z) in the world, m
    """

    a: str
    link_a: str
    b: str
    link_b: str
    depth: float
    position: tuple[float, float, float]
    force: float  # N along the normal


class Engine(EngineBodies):
    """A physics world. ``close()`` frees it; so does the garbage collector.

    time_step: s per ``step()``
    """

    # State -------------------------------------------------------------------------------------------

    def pose(self, name: str, link: str = "") -> Array:
        """``T_world_body`` (4, 4), or of one of its links (the link frame of the URDF)."""
        index = self._links[name][link]
        if index < 0:
            xyz, quaternion = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)
        else:
            xyz, quaternion = p.getLinkState(
                self._ids[name], index, computeForwardKinematics=1, physicsClientId=self._client
            )[4:6]
        return pose(xyz, R=from_quaternion(quaternion))

    def speed(self, name: str) -> tuple[float, float]:
        """Linear (m/s) and angular (rad/s) speed of a free body."""
        linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
        return float(np.linalg.norm(linear)), float(np.linalg.norm(angular))

    def touches(self, name: str) -> list[Touch]:
        """Every contact point of a body in the last step whose shapes touch or overlap."""
        found = p.getContactPoints(bodyA=self._ids[name], physicsClientId=self._client)
        return [self._touch(c) for c in found if c[8] <= 0.0]

    def _touch(self, contact: tuple) -> Touch:  # type: ignore[type-arg]
        a, b = self._names[contact[1]], self._names[contact[2]]
        return Touch(
            a, self._link_names[a][contact[3]], b, self._link_names[b][contact[4]],
            -contact[8], contact[5], contact[9],
        )  # fmt: skip

    def near(self, centre: Array, reach: float) -> frozenset[str]:
        """Names of the bodies whose bounding boxes come within ``reach`` m of a point along an axis."""
        found = p.getOverlappingObjects(
            (centre - reach).tolist(), (centre + reach).tolist(), physicsClientId=self._client
        )
        return frozenset(self._names[body] for body, _ in found or ())

    def distance(self, a: str, link_a: str, b: str, farthest: float) -> float:
        """Signed distance between a link and a body in m; ``farthest`` if they are farther apart."""
        points = p.getClosestPoints(
            self._ids[a], self._ids[b], farthest, self._links[a][link_a], physicsClientId=self._client
        )
        return min((float(c[8]) for c in points), default=farthest)

    def ray_hits(self, starts: Array, ends: Array) -> list[tuple[str, float]]:
        """First item or firm body on each ray and the fraction in [0, 1] where; ("", 1.0) where none is."""
        hits = p.rayTestBatch(
            starts.tolist(), ends.tolist(), collisionFilterMask=PROBED, physicsClientId=self._client
        )
        return [(self._names.get(h[0], ""), float(h[2])) if h[0] >= 0 else ("", 1.0) for h in hits]

    # Motors and forces -------------------------------------------------------------------------------

    def joints(self, name: str) -> dict[str, int]:
        """Index by name of every movable joint."""
        body = self._ids[name]
        infos = [
            p.getJointInfo(body, i, physicsClientId=self._client)
            for i in range(p.getNumJoints(body, physicsClientId=self._client))
        ]
        return {info[1].decode(): info[0] for info in infos if info[2] != p.JOINT_FIXED}

    def reset_joints(self, name: str, positions: Mapping[int, float]) -> None:
        """Set joint positions at rest. Only for the start: later the robot moves by its motors alone."""
        for index, value in positions.items():
            p.resetJointState(self._ids[name], index, value, physicsClientId=self._client)

    def joint_states(self, name: str, indices: Sequence[int]) -> tuple[Array, Array]:
        """Positions (k,) of joints by index, and what their motors exerted (k,) in the last step."""
        states = p.getJointStates(self._ids[name], indices, physicsClientId=self._client)
        return np.array([state[0] for state in states]), np.array([state[3] for state in states])

    def inverse_dynamics(self, name: str, q: Array, dq: Array, ddq: Array) -> Array:
        """Motor torques (m,) that a motion of all movable joints needs, by the model in the robot's URDF."""
        torques = p.calculateInverseDynamics(
            self._ids[name], q.tolist(), dq.tolist(), ddq.tolist(), physicsClientId=self._client
        )
        return np.array(torques)

    def drive(self, name: str, indices: Sequence[int], velocities: Array, forces: Array) -> None:
        """Run the motors of joints at velocities (k,), as far as forces (k,) suffice."""
        p.setJointMotorControlArray(
            self._ids[name],
            indices,
            p.VELOCITY_CONTROL,
            targetVelocities=velocities.tolist(),
            forces=forces.tolist(),
            physicsClientId=self._client,
        )

    def velocity(self, name: str, link: str, point: Array) -> tuple[Array, Array]:
        """Velocity (3,) in m/s of a body's material point at a world point (3,), and its turn (3,), rad/s."""
        index = self._links[name][link]
        if index < 0:
            linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
            centre = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)[0]
        else:
            state = p.getLinkState(
                self._ids[name], index, computeLinkVelocity=1, computeForwardKinematics=1,
                physicsClientId=self._client,
            )  # fmt: skip
            linear, angular, centre = state[6], state[7], state[0]
        turn = np.array(angular)
        return np.array(linear) + _cross(turn, point - np.array(centre)), turn

    def push(self, name: str, force: Array, point: Array, link: str = "") -> None:
        """Force (3,) in N at a world point (3,) on a body or its link, for the next step only."""
        p.applyExternalForce(
            self._ids[name], self._links[name][link], force.tolist(), point.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    def twist(self, name: str, torque: Array, link: str = "") -> None:
        """Torque (3,) in Nm, world axes, on a body or its link, for the next step only."""
        p.applyExternalTorque(
            self._ids[name], self._links[name][link], torque.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    # Pictures ----------------------------------------------------------------------------------------

    def picture(
        self, eye: Sequence[float], target: Sequence[float], fov: float, size: tuple[int, int]
    ) -> NDArray[np.uint8]:
        """Colour picture (height, width, 3) uint8 by the software renderer, z up; fov in degrees."""
        width, height = size
        view = p.computeViewMatrix(list(eye), list(target), [0, 0, 1])
        projection = p.computeProjectionMatrixFOV(fov, width / height, 0.05, 10.0)
        image = p.getCameraImage(
            width, height, view, projection, shadow=1, lightDirection=[-1.5, 0.8, 2.5],
            renderer=p.ER_TINY_RENDERER, physicsClientId=self._client,
        )  # fmt: skip
        return np.asarray(image[2], dtype=np.uint8).reshape(height, width, 4)[:, :, :3]


def _cross(a: Array, b: Array) -> Array:
    """Cross product of two (3,) arrays; numpy's takes ten times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
