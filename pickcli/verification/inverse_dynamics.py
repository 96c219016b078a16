"""The verifier's own inverse dynamics: Newton and Euler in numpy over all states at once, in world axes.

Bodies are numbered by how many planned joints carry them; links that no planned joint divides are one body.
The tool's own joints are at 0: what they move weighs a few grams.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import Joint, JointType, Robot
from pickcli.geometry import Array
from pickcli.verification.forward_kinematics import parent_index

GRAVITY = np.array([0.0, 0.0, 9.81])  # m/s^2, upwards: the acceleration that resists gravity


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """Motion of a body in N states; vectors (N, 3) in world axes, of its origin.

    Attributes:
        joint: Joint that carries it; None for what stands.
        origin: m.
        axis: Unit vector along the axis of its joint.
        acceleration: m/s^2.
        omega: Angular velocity, rad/s.
        alpha: Angular acceleration, rad/s^2.
    """

    joint: Joint | None
    origin: Array
    axis: Array
    acceleration: Array
    omega: Array
    alpha: Array

    def acceleration_at(self, point: Array) -> Array:
        """Return the acceleration of a point of the body.

        Args:
            point: (N, 3) m, in the world.

        Returns:
            (N, 3) m/s^2.
        """
        arm = point - self.origin
        return self.acceleration + np.cross(self.alpha, arm) + np.cross(self.omega, np.cross(self.omega, arm))

    def during(self, chosen: NDArray[np.bool_]) -> BodyMotion:
        """Return the motion in some of the states.

        Args:
            chosen: (N,) mask of the states.

        Returns:
            The motion in those.
        """
        rows = (self.origin, self.axis, self.acceleration, self.omega, self.alpha)
        return BodyMotion(self.joint, *(row[chosen] for row in rows))


@dataclass(frozen=True, eq=False)
class CarriedBody:
    """Something that a body carries.

    Attributes:
        body: Number of the body.
        poses: (N, 4, 4) of its frame in the world.
        inertial: Its mass properties in that frame.
    """

    body: int
    poses: Array
    inertial: Inertial


def body_motions(robot: Robot, links: Array, dQ: Array, ddQ: Array) -> list[BodyMotion]:
    """Compute how the bodies of a robot move.

    Args:
        robot: The robot.
        links: (L, N, 4, 4) poses of its links.
        dQ: (N, n) velocities of the planned joints.
        ddQ: (N, n) their accelerations.

    Returns:
        One for each body: what stands, then what each planned joint carries, from the base outwards.
    """
    zero = np.zeros((links.shape[1], 3))
    found = [BodyMotion(None, links[0, :, :3, 3], zero, zero, zero, zero)]
    for k, joint in enumerate(robot.joints):
        if joint.name not in robot.joint_names:
            continue
        j, before = robot.joint_names.index(joint.name), found[-1]
        origin, axis = links[k + 1, :, :3, 3], links[k + 1, :, :3, :3] @ joint.axis
        acceleration, rate, change = (
            before.acceleration_at(origin),
            axis * dQ[:, j, None],
            axis * ddQ[:, j, None],
        )
        turned = np.cross(before.omega, rate)
        if joint.type is JointType.PRISMATIC:
            acceleration = acceleration + change + 2.0 * turned
            found.append(BodyMotion(joint, origin, axis, acceleration, before.omega, before.alpha))
        else:
            omega, alpha = before.omega + rate, before.alpha + change + turned
            found.append(BodyMotion(joint, origin, axis, acceleration, omega, alpha))
    return found


def carried_links(robot: Robot, links: Array) -> list[CarriedBody]:
    """Return all links that move, as what the bodies carry.

    Args:
        robot: The robot.
        links: (L, N, 4, 4) poses of its links.

    Returns:
        One for each link.
    """
    bodies = [0]
    for k, joint in enumerate(robot.joints):
        bodies.append(bodies[parent_index(robot, k)] + (joint.name in robot.joint_names))
    each = zip(bodies, links, robot.links, strict=True)
    return [CarriedBody(body, poses, link.inertial) for body, poses, link in each if body > 0]


def efforts(robot: Robot, motions: list[BodyMotion], carried: Iterable[CarriedBody]) -> Array:
    """Compute the efforts of the joints that move what they carry.

    Args:
        robot: The robot.
        motions: Motions of its bodies, from ``body_motions``.
        carried: What is carried.

    Returns:
        (N, n) Nm, or N of prismatic joints.
    """
    forces, torques = np.zeros((2, len(motions), *motions[0].origin.shape))  # about the origin of each body
    for each in carried:
        motion, own, R = motions[each.body], each.inertial, each.poses[:, :3, :3]
        centre = each.poses[:, :3, 3] + R @ own.centre
        force = own.mass * (motion.acceleration_at(centre) + GRAVITY)
        inertia = R @ own.inertia @ np.swapaxes(R, 1, 2)
        spin = _times(inertia, motion.alpha) + np.cross(motion.omega, _times(inertia, motion.omega))
        forces[each.body] += force
        torques[each.body] += np.cross(centre - motion.origin, force) + spin
    out = np.zeros((len(motions[0].origin), robot.n_joints))
    for b in range(len(motions) - 1, 0, -1):
        motion = motions[b]
        assert motion.joint is not None
        bears = forces[b] if motion.joint.type is JointType.PRISMATIC else torques[b]
        out[:, robot.joint_names.index(motion.joint.name)] = (motion.axis * bears).sum(axis=1)
        forces[b - 1] += forces[b]
        torques[b - 1] += torques[b] + np.cross(motion.origin - motions[b - 1].origin, forces[b])
    return out


def _times(matrices: Array, vectors: Array) -> Array:
    """Return products (N, 3) of matrices (N, 3, 3) and vectors (N, 3)."""
    return np.asarray((matrices @ vectors[:, :, None])[:, :, 0])
