"""Interface to pybullet: states of bodies, motors, forces and pictures; poses as (4, 4) arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array, cross, from_quaternion, length, pose
from pickcli.simulation.engine_bodies import PROBED, EngineBodies
from pickcli.simulation.engine_client import pybullet as p


@dataclass(frozen=True)
class ContactPoint:
    """One contact point between two bodies, as reported by the engine.

    Attributes:
        a: Name of one body.
        link_a: Name of its link ("" for bodies without links).
        b: Name of the other body.
        link_b: Name of its link.
        depth: m, positive if the shapes overlap.
        position: (x, y, z) in the world, m.
        force: N along the normal.
        normal: Unit normal in the world, from ``b`` towards ``a``.
    """

    a: str
    link_a: str
    b: str
    link_b: str
    depth: float
    position: tuple[float, float, float]
    force: float
    normal: tuple[float, float, float] = (0.0, 0.0, 0.0)


class Engine(EngineBodies):
    """A physics world: its bodies, their state, motors and forces, and pictures."""

    # State -------------------------------------------------------------------------------------------

    def pose(self, name: str, link: str = "") -> Array:
        """Return the pose of a body, or of one of its links (the link frame of the URDF).

        Args:
            name: Name of the body.
            link: Name of the link, "" for the body.

        Returns:
            (4, 4) ``T_world_body``.
        """
        index = self._links[name][link]
        if index < 0:
            xyz, quaternion = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)
        else:
            xyz, quaternion = self._link_state(name, index)[4:6]
        return pose(xyz, R=from_quaternion(quaternion))

    def _link_state(self, name: str, index: int) -> tuple[Any, ...]:
        """State of a link from pybullet, cached until the next step."""
        state = self._link_states.get((name, index))
        if state is None:
            state = p.getLinkState(
                self._ids[name], index, computeLinkVelocity=1, computeForwardKinematics=1,
                physicsClientId=self._client,
            )  # fmt: skip
            self._link_states[name, index] = state
        return state

    def speed(self, name: str) -> tuple[float, float]:
        """Return the speed of a free body.

        Args:
            name: Name of the body.

        Returns:
            Linear (m/s) and angular (rad/s).
        """
        linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
        return length(np.array(linear)), length(np.array(angular))

    def pressing_points(self, name: str, link: str) -> list[ContactPoint]:
        """Return the contact points of a link that bore a force in the last step.

        In a flat contact some of these are separated by micrometres.

        Args:
            name: Name of the body.
            link: Name of its link.

        Returns:
            The contact points.
        """
        found = p.getContactPoints(
            bodyA=self._ids[name], linkIndexA=self._links[name][link], physicsClientId=self._client
        )
        return [self._contact_point(c) for c in found if c[9] > 0.0]

    def contact_points(self, name: str) -> list[ContactPoint]:
        """Return the contact points of a body in the last step at which shapes touch or overlap.

        Args:
            name: Name of the body.

        Returns:
            The contact points.
        """
        found = p.getContactPoints(bodyA=self._ids[name], physicsClientId=self._client)
        return [self._contact_point(c) for c in found if c[8] <= 0.0]

    def _contact_point(self, contact: tuple) -> ContactPoint:  # type: ignore[type-arg]
        a, b = self._names[contact[1]], self._names[contact[2]]
        return ContactPoint(
            a, self._link_names[a][contact[3]], b, self._link_names[b][contact[4]],
            -contact[8], contact[5], contact[9], contact[7],
        )  # fmt: skip

    def near(self, centre: Array, reach: float) -> frozenset[str]:
        """Return the bodies whose bounding boxes overlap a box around a point.

        Args:
            centre: (3,) m in the world.
            reach: m, half extent of the box.

        Returns:
            Names.
        """
        found = p.getOverlappingObjects(
            (centre - reach).tolist(), (centre + reach).tolist(), physicsClientId=self._client
        )
        return frozenset(self._names[body] for body, _ in found or ())

    def distance(self, a: str, link_a: str, b: str, farthest: float) -> float:
        """Compute the signed distance between a link and a body.

        Args:
            a: Name of the body with the link.
            link_a: Name of the link.
            b: Name of the other body.
            farthest: m, upper bound of the result.

        Returns:
            m.
        """
        points = p.getClosestPoints(
            self._ids[a], self._ids[b], farthest, self._links[a][link_a], physicsClientId=self._client
        )
        return min((float(c[8]) for c in points), default=farthest)

    def ray_faces(self, starts: Array, ends: Array) -> list[tuple[str, float, tuple[float, float, float]]]:
        """Find the first item or firm body on each ray, and how its surface faces there.

        Args:
            starts: (R, 3) m in the world.
            ends: (R, 3) m in the world.

        Returns:
            Name, the fraction in [0, 1] of the ray, and the outward unit normal in the world; ("", 1.0) and
            no direction without a hit.
        """
        hits = p.rayTestBatch(
            starts.tolist(), ends.tolist(), collisionFilterMask=PROBED, physicsClientId=self._client
        )
        none = ("", 1.0, (0.0, 0.0, 0.0))
        return [(self._names.get(h[0], ""), float(h[2]), h[4]) if h[0] >= 0 else none for h in hits]

    # Motors and forces -------------------------------------------------------------------------------

    def joints(self, name: str) -> dict[str, int]:
        """Return the indices of all movable joints by name.

        Args:
            name: Name of the body.

        Returns:
            The indices.
        """
        body = self._ids[name]
        infos = [
            p.getJointInfo(body, i, physicsClientId=self._client)
            for i in range(p.getNumJoints(body, physicsClientId=self._client))
        ]
        return {info[1].decode(): info[0] for info in infos if info[2] != p.JOINT_FIXED}

    def reset_joints(self, name: str, positions: Mapping[int, float]) -> None:
        """Set joint positions at rest. Only for initialisation; later the robot moves only by its motors.

        Args:
            name: Name of the body.
            positions: By index of the joint, rad or m.
        """
        self._link_states.clear()
        for index, value in positions.items():
            p.resetJointState(self._ids[name], index, value, physicsClientId=self._client)

    def joint_states(self, name: str, indices: Sequence[int]) -> tuple[Array, Array]:
        """Return the positions of joints, and the efforts of their motors in the last step.

        Args:
            name: Name of the body.
            indices: Indices of k joints.

        Returns:
            Positions (k,) in rad or m, and efforts (k,) in Nm or N.
        """
        states = p.getJointStates(self._ids[name], indices, physicsClientId=self._client)
        return np.array([state[0] for state in states]), np.array([state[3] for state in states])

    def inverse_dynamics(self, name: str, q: Array, dq: Array, ddq: Array) -> Array:
        """Compute the motor efforts of a motion of all movable joints, by the model in the robot's URDF.

        Args:
            name: Name of the body.
            q: (m,) positions.
            dq: (m,) velocities.
            ddq: (m,) accelerations.

        Returns:
            (m,) Nm or N.
        """
        torques = p.calculateInverseDynamics(
            self._ids[name], q.tolist(), dq.tolist(), ddq.tolist(), physicsClientId=self._client
        )
        return np.array(torques)

    def mass_matrix(self, name: str, q: Array) -> Array:
        """Compute the inertia of a robot at its movable joints, by the model in its URDF.

        Args:
            name: Name of the body.
            q: (m,) positions.

        Returns:
            (m, m) kg m^2, kg m or kg.
        """
        return np.array(p.calculateMassMatrix(self._ids[name], q.tolist(), physicsClientId=self._client))

    def joint_velocities(self, name: str, indices: Sequence[int]) -> Array:
        """Return the velocities of joints.

        Args:
            name: Name of the body.
            indices: Indices of k joints.

        Returns:
            (k,) rad/s or m/s.
        """
        states = p.getJointStates(self._ids[name], indices, physicsClientId=self._client)
        return np.array([state[1] for state in states])

    def release_joints(self, name: str, indices: Sequence[int]) -> None:
        """Switch the velocity motors of joints off, so that ``exert`` alone acts on them.

        Args:
            name: Name of the body.
            indices: Indices of the joints.
        """
        self.drive(name, indices, [0.0] * len(indices), [0.0] * len(indices))

    def exert(self, name: str, indices: Sequence[int], efforts: Array) -> None:
        """Set the efforts of joints for the next step only.

        Args:
            name: Name of the body.
            indices: Indices of k joints whose velocity motors are off.
            efforts: (k,) Nm or N.
        """
        p.setJointMotorControlArray(
            self._ids[name], indices, p.TORQUE_CONTROL, forces=efforts.tolist(), physicsClientId=self._client
        )

    def drive(
        self, name: str, indices: Sequence[int], velocities: Sequence[float], forces: Sequence[float]
    ) -> None:
        """Set velocity targets of joint motors with limited forces.

        Args:
            name: Name of the body.
            indices: Indices of k joints.
            velocities: (k,) rad/s or m/s.
            forces: (k,) Nm or N.
        """
        p.setJointMotorControlArray(
            self._ids[name],
            indices,
            p.VELOCITY_CONTROL,
            targetVelocities=velocities,
            forces=forces,
            physicsClientId=self._client,
        )

    def velocity(self, name: str, link: str, point: Array) -> tuple[Array, Array]:
        """Compute the velocity of a body's material point.

        Args:
            name: Name of the body.
            link: Name of the link, "" for the body.
            point: (3,) m in the world.

        Returns:
            Linear velocity (3,) in m/s and angular velocity (3,) in rad/s, world axes.
        """
        index = self._links[name][link]
        if index < 0:
            linear, angular = p.getBaseVelocity(self._ids[name], physicsClientId=self._client)
            centre = p.getBasePositionAndOrientation(self._ids[name], physicsClientId=self._client)[0]
        else:
            state = self._link_state(name, index)
            linear, angular, centre = state[6], state[7], state[0]
        turn = np.array(angular)
        return np.array(linear) + cross(turn, point - np.array(centre)), turn

    def relative_velocity(self, name: str, other: str, link: str, point: Array) -> tuple[Array, Array]:
        """Compute the velocity of a body's material point relative to another body's link at the same point.

        Args:
            name: Name of the body.
            other: Name of the other body.
            link: Name of the other body's link.
            point: (3,) m in the world.

        Returns:
            Linear velocity (3,) in m/s and angular velocity (3,) in rad/s, world axes.
        """
        linear, turn = self.velocity(name, "", point)
        other_linear, other_turn = self.velocity(other, link, point)
        return linear - other_linear, turn - other_turn

    def apply_force(self, name: str, force: Array, point: Array, link: str = "") -> None:
        """Apply a force to a body or its link, for the next step only.

        Args:
            name: Name of the body.
            force: (3,) N, world axes.
            point: (3,) m in the world.
            link: Name of the link, "" for the body.
        """
        p.applyExternalForce(
            self._ids[name], self._links[name][link], force.tolist(), point.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    def twist(self, name: str, torque: Array, link: str = "") -> None:
        """Apply a torque to a body or its link, for the next step only.

        Args:
            name: Name of the body.
            torque: (3,) Nm, world axes.
            link: Name of the link, "" for the body.
        """
        p.applyExternalTorque(
            self._ids[name], self._links[name][link], torque.tolist(), p.WORLD_FRAME,
            physicsClientId=self._client,
        )  # fmt: skip

    # Pictures ----------------------------------------------------------------------------------------

    def picture(
        self, eye: Sequence[float], target: Sequence[float], fov: float, size: tuple[int, int]
    ) -> NDArray[np.uint8]:
        """Render a colour picture in software, z up.

        Args:
            eye: (3,) m in the world.
            target: (3,) m in the world.
            fov: Vertical field of view, degrees.
            size: Width and height in pixels.

        Returns:
            (height, width, 3) uint8.
        """
        width, height = size
        view = p.computeViewMatrix(list(eye), list(target), [0, 0, 1])
        projection = p.computeProjectionMatrixFOV(fov, width / height, 0.05, 10.0)
        image = p.getCameraImage(
            width, height, view, projection, shadow=1, lightDirection=[-1.5, 0.8, 2.5],
            renderer=p.ER_TINY_RENDERER, physicsClientId=self._client,
        )  # fmt: skip
        return np.asarray(image[2], dtype=np.uint8).reshape(height, width, 4)[:, :, :3]
