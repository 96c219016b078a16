"""Straight lines in SE(3)."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array, interpolate, rotation_angle

STEP = 0.008  # m between two poses handed to inverse kinematics
ANGLE_STEP = np.radians(2.0)


def line(T_a: Array, T_b: Array, step: float = STEP) -> Array:
    """Poses (P, 4, 4) on the straight line between two poses, both ends included, P >= 2."""
    distance = float(np.linalg.norm(T_b[:3, 3] - T_a[:3, 3]))
    angle = rotation_angle(T_a[:3, :3].T @ T_b[:3, :3])
    n = max(1, int(np.ceil(max(distance / step, angle / ANGLE_STEP))))
    poses = np.tile(T_a, (n + 1, 1, 1))
    s = np.linspace(0.0, 1.0, n + 1)[:, None]
    poses[:, :3, 3] = (1.0 - s) * T_a[:3, 3] + s * T_b[:3, 3]
    if angle > 1e-9:
        poses[:, :3, :3] = [interpolate(T_a, T_b, i / n)[:3, :3] for i in range(n + 1)]
    return poses


def shifted(T: Array, along: Array) -> Array:
    """The pose moved by a vector (3,) of the world, orientation kept."""
    out = T.copy()
    out[:3, 3] += along
    return out
