"""SE(3) as plain 4x4 arrays, and the only place where quaternion order appears.

Conventions: ``T_a_b`` maps coordinates in frame b to frame a, so ``T_a_b @ T_b_c == T_a_c``.
Quaternions are (x, y, z, w), as in ROS. Roll, pitch, yaw are fixed-axis x-y-z, as in URDF.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


def rotation_rpy(roll: float | Array, pitch: float | Array, yaw: float | Array) -> Array:
    """Rotation matrix (3, 3) of fixed-axis roll, pitch, yaw in rad (URDF's convention); (3, 3, n) of n."""
    cr, sr, cp, sp, cy, sy = (
        np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw),
    )  # fmt: skip
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def rotation_axis_angle(axis: Sequence[float] | Array, angle: float) -> Array:
    """Rotation matrix (3, 3) about a unit axis (3,) by an angle in rad (Rodrigues)."""
    x, y, z = (float(a) for a in axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K))


def pose(
    xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
    rpy: Sequence[float] | Array | None = None,
    R: Array | None = None,
) -> Array:
    """Pose (4, 4) from a position in m and either rpy in rad or a rotation matrix (3, 3)."""
    T = np.eye(4)
    T[:3, 3] = xyz
    if R is not None:
        T[:3, :3] = R
    elif rpy is not None:
        T[:3, :3] = rotation_rpy(*rpy)
    return T


def inverse(T: Array) -> Array:
    """Inverse of a pose (4, 4), exact for rigid transforms."""
    out = np.eye(4)
    out[:3, :3] = T[:3, :3].T
    out[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return out


def to_quaternion(R: Array) -> Array:
    """Unit quaternion (x, y, z, w) with w >= 0 of a rotation matrix (3, 3)."""
    m = R[:3, :3]
    # The largest of the four squared components is found first: no division by a small number.
    squares = np.array(
        [
            1.0 + m[0, 0] - m[1, 1] - m[2, 2],
            1.0 - m[0, 0] + m[1, 1] - m[2, 2],
            1.0 - m[0, 0] - m[1, 1] + m[2, 2],
            1.0 + m[0, 0] + m[1, 1] + m[2, 2],
        ]
    )
    i = int(np.argmax(squares))
    if i == 3:
        q = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1], squares[3]])
    elif i == 0:
        q = np.array([squares[0], m[0, 1] + m[1, 0], m[0, 2] + m[2, 0], m[2, 1] - m[1, 2]])
    elif i == 1:
        q = np.array([m[0, 1] + m[1, 0], squares[1], m[1, 2] + m[2, 1], m[0, 2] - m[2, 0]])
    else:
        q = np.array([m[0, 2] + m[2, 0], m[1, 2] + m[2, 1], squares[2], m[1, 0] - m[0, 1]])
    q /= np.linalg.norm(q)
    return q if q[3] >= 0.0 else -q


def from_quaternion(q: Sequence[float] | Array) -> Array:
    """Rotation matrix (3, 3) of a quaternion (x, y, z, w); it is normalised first."""
    x, y, z, w = np.asarray(q, dtype=float) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_vector(R: Array) -> Array:
    """Rotation vector (3,) in rad (axis times angle, angle in [0, pi]) of a rotation matrix."""
    x, y, z, w = to_quaternion(R)
    v = np.array([x, y, z])
    sine = float(np.linalg.norm(v))
    if sine < 1e-12:
        return 2.0 * v
    return np.asarray(v * (2.0 * np.arctan2(sine, w) / sine))


def rotation_angle(R: Array) -> float:
    """Angle in rad, in [0, pi], of a rotation matrix (3, 3)."""
    return float(np.linalg.norm(rotation_vector(R)))


def perpendiculars(normal: Array) -> tuple[Array, Array]:
    """Two unit vectors (3,) that make a right-handed frame u, v, normal with a unit vector (3,)."""
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = np.cross(normal, helper)
    u /= np.linalg.norm(u)
    return u, np.cross(normal, u)


def transform_points(T: Array, points: Array) -> Array:
    """Points (N, 3) mapped by a pose (4, 4)."""
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def is_pose(T: Array, tolerance: float = 1e-6) -> bool:
    """Whether T is a finite (4, 4) rigid transform."""
    T = np.asarray(T)
    return bool(
        T.shape == (4, 4)
        and np.all(np.isfinite(T))
        and np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=tolerance)
        and np.linalg.det(T[:3, :3]) > 0.0
        and np.allclose(T[3], [0, 0, 0, 1])
    )
