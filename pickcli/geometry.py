"""SE(3) as plain 4x4 arrays; quaternion order is only relevant in this module.

Conventions: ``T_a_b`` maps coordinates in frame b to frame a, so ``T_a_b @ T_b_c == T_a_c``.
Quaternions are (x, y, z, w), as in ROS. Roll, pitch, yaw are fixed-axis x-y-z, as in URDF.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]

GRAVITY = 9.81  # m/s^2, against the world's z
_SAME_DIRECTION = 1e-12  # sine of the angle between two directions that count as equal
_IDENTITY = np.eye(4)
_LOCKED = 1e-9  # cosine of a pitch at which roll and yaw turn about the same axis


def rotation_rpy(roll: float | Array, pitch: float | Array, yaw: float | Array) -> Array:
    """Compute the rotation matrix of fixed-axis roll, pitch and yaw (URDF's convention).

    Args:
        roll: rad about x; an array (n,) for n rotations.
        pitch: rad about y.
        yaw: rad about z.

    Returns:
        (3, 3), or (3, 3, n) of n rotations.
    """
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


def to_rpy(R: Array) -> Array:
    """Compute fixed-axis roll, pitch and yaw of a rotation matrix (URDF's convention).

    Args:
        R: (3, 3); if the pitch is a quarter turn, roll and yaw are ambiguous and the yaw is 0.

    Returns:
        (3,) rad.
    """
    level = np.hypot(R[0, 0], R[1, 0])  # cosine of the pitch
    pitch = np.arctan2(-R[2, 0], level)
    if level < _LOCKED:
        return np.array([np.arctan2(-R[1, 2], R[1, 1]), pitch, 0.0])
    return np.array([np.arctan2(R[2, 1], R[2, 2]), pitch, np.arctan2(R[1, 0], R[0, 0])])


def least_turn(a: Array, b: Array) -> Array:
    """Compute the rotation by the least angle that takes one direction to another.

    Args:
        a: (3,) unit vector.
        b: (3,) unit vector.

    Returns:
        (3, 3), ``least_turn(a, b) @ a == b``; about any perpendicular axis if b is opposite to a.
    """
    axis, cosine = np.cross(a, b), float(a @ b)
    sine = float(np.linalg.norm(axis))
    if sine < _SAME_DIRECTION:
        return np.eye(3) if cosine > 0.0 else rotation_axis_angle(perpendiculars(a)[0], float(np.pi))
    return rotation_axis_angle(axis / sine, float(np.arctan2(sine, cosine)))


def levelled(R: Array) -> Array:
    """Turn an orientation by the least angle that makes its most vertical axis vertical.

    Args:
        R: (3, 3) orientation in a frame whose z points up.

    Returns:
        (3, 3) the turned orientation.
    """
    axis = int(np.argmax(np.abs(R[2])))
    return least_turn(R[:, axis], np.sign(R[2, axis]) * np.array([0.0, 0.0, 1.0])) @ R


def rotation_axis_angle(axis: Sequence[float] | Array, angle: float) -> Array:
    """Compute the rotation matrix about an axis (Rodrigues).

    Args:
        axis: (3,) unit vector.
        angle: rad.

    Returns:
        (3, 3).
    """
    x, y, z = (float(a) for a in axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * (K @ K))


def pose(
    xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
    rpy: Sequence[float] | Array | None = None,
    R: Array | None = None,
) -> Array:
    """Build a pose from a position and an orientation.

    Args:
        xyz: (3,) m.
        rpy: (3,) rad, fixed-axis roll, pitch, yaw.
        R: (3, 3) rotation matrix, instead of ``rpy``.

    Returns:
        (4, 4).
    """
    T = _IDENTITY.copy()
    T[:3, 3] = xyz
    if R is not None:
        T[:3, :3] = R
    elif rpy is not None:
        T[:3, :3] = rotation_rpy(*rpy)
    return T


def inverse(T: Array) -> Array:
    """Invert a pose, exact for rigid transforms.

    Args:
        T: (4, 4).

    Returns:
        (4, 4).
    """
    out = _IDENTITY.copy()
    out[:3, :3] = T[:3, :3].T
    out[:3, 3] = -T[:3, :3].T @ T[:3, 3]
    return out


def to_quaternion(R: Array) -> Array:
    """Compute the unit quaternion of a rotation matrix.

    Args:
        R: (3, 3).

    Returns:
        (x, y, z, w) with w >= 0.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = R[:3, :3].tolist()
    # The largest of the four squared components is found first, to avoid division by a small number.
    squares = [1.0 + xx - yy - zz, 1.0 - xx + yy - zz, 1.0 - xx - yy + zz, 1.0 + xx + yy + zz]
    i = squares.index(max(squares))
    if i == 3:
        q = np.array([zy - yz, xz - zx, yx - xy, squares[3]])
    elif i == 0:
        q = np.array([squares[0], xy + yx, xz + zx, zy - yz])
    elif i == 1:
        q = np.array([xy + yx, squares[1], yz + zy, xz - zx])
    else:
        q = np.array([xz + zx, yz + zy, squares[2], yx - xy])
    q /= length(q)
    return q if q[3] >= 0.0 else -q


def from_quaternion(q: Sequence[float] | Array) -> Array:
    """Compute the rotation matrix of a quaternion.

    Args:
        q: (x, y, z, w); it is normalised first.

    Returns:
        (3, 3).
    """
    q = np.asarray(q, dtype=float)
    x, y, z, w = (q / length(q)).tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def rotation_vector(R: Array) -> Array:
    """Compute the rotation vector of a rotation matrix: axis times angle.

    Args:
        R: (3, 3).

    Returns:
        (3,) rad; its length, the angle, is in [0, pi].
    """
    x, y, z, w = to_quaternion(R)
    v = np.array([x, y, z])
    sine = length(v)
    if sine < 1e-12:
        return 2.0 * v
    return np.asarray(v * (2.0 * np.arctan2(sine, w) / sine))


def rotation_from_vector(v: Array) -> Array:
    """Compute the rotation matrix of a rotation vector.

    Args:
        v: (3,) rad, axis times angle; of any length.

    Returns:
        (3, 3).
    """
    angle = length(v)
    return np.eye(3) if angle == 0.0 else rotation_axis_angle(v / angle, angle)


def rotation_angle(R: Array) -> float:
    """Compute the angle of a rotation matrix.

    Args:
        R: (3, 3).

    Returns:
        rad, in [0, pi].
    """
    return float(np.linalg.norm(rotation_vector(R)))


def length(v: Array) -> float:
    """Compute the Euclidean length of one vector, without the overhead of ``np.linalg.norm``.

    Args:
        v: (n,).

    Returns:
        The length, exactly equal to that of ``np.linalg.norm``.
    """
    return math.sqrt(v.dot(v))


def perpendiculars(normal: Array) -> tuple[Array, Array]:
    """Return two unit vectors that complete a right-handed frame.

    Args:
        normal: (3,) unit vector.

    Returns:
        u and v, (3,) each: u, v, normal are a right-handed frame.
    """
    helper = np.eye(3)[int(np.argmin(np.abs(normal)))]
    u = cross(normal, helper)
    u /= np.linalg.norm(u)
    return u, cross(normal, u)


def cross(a: Array, b: Array) -> Array:
    """Compute the cross product of two vectors, without the overhead of ``np.cross``.

    Args:
        a: (3,).
        b: (3,).

    Returns:
        (3,).
    """
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def skew(v: Array) -> Array:
    """Return the matrix by which a cross product is a product.

    Args:
        v: (3,).

    Returns:
        (3, 3) matrix S with S w = v x w.
    """
    x, y, z = v
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def transform_points(T: Array, points: Array) -> Array:
    """Map points by a pose.

    Args:
        T: (4, 4) pose ``T_a_b``.
        points: (N, 3) in frame b.

    Returns:
        (N, 3) in frame a.
    """
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def is_pose(T: Array, tolerance: float = 1e-6) -> bool:
    """Whether an array is a finite rigid transform.

    Args:
        T: The array.
        tolerance: Tolerance of the entries of R R^T.

    Returns:
        True if it is.
    """
    T = np.asarray(T)
    return bool(
        T.shape == (4, 4)
        and np.all(np.isfinite(T))
        and np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=tolerance)
        and np.linalg.det(T[:3, :3]) > 0.0
        and np.allclose(T[3], [0, 0, 0, 1])
    )
