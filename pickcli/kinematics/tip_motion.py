"""How the tool frame moves while the joints do: twist and acceleration, velocity products included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class TipMotion:
    """Motion of the tool frame at N states; all vectors in world axes.

    Derivatives are those of whatever the joints' derivatives are by: time in s, or the parameter of a path.

    Attributes:
        poses: (N, 4, 4) T_world_tip.
        velocity: (N, 3) m of the frame's origin.
        angular_velocity: (N, 3) rad.
        acceleration: (N, 3) m of the frame's origin.
        angular_acceleration: (N, 3) rad.
    """

    poses: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array

    def at_rest(self) -> TipMotion:
        """The same poses without any motion."""
        zero = np.zeros_like(self.velocity)
        return TipMotion(self.poses, zero, zero, zero, zero)


@dataclass(frozen=True, eq=False)
class JointAxes:
    """The axes of K moving joints, from the base outwards.

    Attributes:
        frames: (K,) which of the chain's frames each joint moves.
        axes: (K, 3) unit axes in those frames; a joint's own motion leaves its axis where it is.
        indices: (K,) where in q each joint is.
        is_prismatic: (K,) along its axis, not about it.
    """

    frames: NDArray[np.intp]
    axes: Array
    indices: NDArray[np.intp]
    is_prismatic: NDArray[np.bool_]


def tip_motion(joints: JointAxes, frames: Array, T_last_tip: Array, first: Array, second: Array) -> TipMotion:
    """The motion of the tip by the outward recursion of Newton and Euler, at all states at once.

    J. Y. S. Luh, M. W. Walker, R. P. C. Paul, "On-line computational scheme for mechanical manipulators",
    J. Dyn. Sys. Meas. Control 102(2), 1980. The base is at rest.

    Args:
        joints: The K moving joints of a chain of L frames.
        frames: (N, L, 4, 4) poses of the frames in the world.
        T_last_tip: (4, 4) pose of the tool frame in the last one.
        first: (N, n) first derivatives of the joints.
        second: (N, n) second derivatives of the joints.
    """
    tips = frames[:, -1] @ T_last_tip
    moved = frames[:, joints.frames]
    # Components first, (3, K, N), so that numpy runs along the states.
    z = _components(np.matmul(moved[..., :3, :3], joints.axes[..., None])[..., 0])
    points = np.concatenate([moved[..., :3, 3], tips[:, None, :3, 3]], axis=1)
    arms = _components(np.diff(points, axis=1))  # from each joint to the next, turning with the first
    by_first, by_second = (z * np.ascontiguousarray(d.T)[joints.indices] for d in (first, second))
    slides = joints.is_prismatic[:, None]
    turn, turning = np.where(slides, 0.0, by_first), np.where(slides, 0.0, by_second)
    omega = np.cumsum(turn, axis=1)
    carried = _cross(omega - turn, by_first)  # what each joint's own motion gains from those before it
    alpha = np.cumsum(turning + np.where(slides, 0.0, carried), axis=1)
    swing = _cross(omega, arms)
    pull = _cross(alpha, arms) + _cross(omega, swing)
    velocity = swing + np.where(slides, by_first, 0.0)
    acceleration = pull + np.where(slides, by_second + 2.0 * carried, 0.0)
    return TipMotion(tips, velocity.sum(axis=1).T, omega[:, -1].T, acceleration.sum(axis=1).T, alpha[:, -1].T)


def _components(vectors: Array) -> Array:
    """(3, K, N) of vectors (N, K, 3)."""
    return np.ascontiguousarray(vectors.T)


def _cross(a: Array, b: Array) -> Array:
    """Cross products of two arrays (3, ...) of vectors; on these shapes much faster than numpy's own."""
    out = np.empty_like(a)
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        np.multiply(a[j], b[k], out=out[i])
        out[i] -= a[k] * b[j]
    return out
