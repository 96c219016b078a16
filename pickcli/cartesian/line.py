"""Straight lines in SE(3)."""

from __future__ import annotations

import math

import numpy as np

from pickcli.geometry import Array, length, rotation_vector

POSE_DISTANCE = 0.008  # m between two poses for inverse kinematics
ANGLE_STEP = np.radians(2.0)


def line(T_a: Array, T_b: Array, step: float = POSE_DISTANCE) -> Array:
    """Sample the straight line between two poses, with rotation about one fixed axis.

    Args:
        T_a: (4, 4) pose at the start.
        T_b: (4, 4) pose at the end.
        step: m, largest distance between neighbouring poses; none turns farther than 2 degrees either.

    Returns:
        (P, 4, 4) poses, both ends included, P at least 2.
    """
    # np.linalg.norm, np.linspace and np.tile are slower.
    distance, is_turned = length(T_b[:3, 3] - T_a[:3, 3]), (T_a[:3, :3] != T_b[:3, :3]).any()
    turn = rotation_vector(T_a[:3, :3].T @ T_b[:3, :3]) if is_turned else np.zeros(3)
    angle = length(turn)
    n = max(1, math.ceil(max(distance / step, angle / ANGLE_STEP)))
    poses = np.repeat(T_a[None], n + 1, axis=0)
    s = np.arange(n + 1)[:, None] / n
    poses[:, :3, 3] = (1.0 - s) * T_a[:3, 3] + s * T_b[:3, 3]
    if angle > 1e-9:
        poses[:, :3, :3] = T_a[:3, :3] @ _rotations(turn / angle, s * angle)
    return poses


def _rotations(axis: Array, angles: Array) -> Array:
    """Return rotations (P, 3, 3) about a unit axis by angles (P, 1) in rad (Rodrigues)."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angles)[:, None] * K + (1.0 - np.cos(angles))[:, None] * (K @ K))


def shifted(T: Array, along: Array) -> Array:
    """Move poses, keeping their orientations.

    Args:
        T: (..., 4, 4) poses.
        along: (..., 3) m, in the axes of the poses' parent frame.

    Returns:
        (..., 4, 4) the moved poses.
    """
    out = T.copy()
    out[..., :3, 3] += along
    return out
