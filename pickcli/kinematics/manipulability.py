"""Manipulability of the tool in a configuration."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array


def yoshikawa(J: Array, length: float = 0.5) -> float:
    """Compute Yoshikawa's manipulability sqrt(det(J J^T)) of a Jacobian.

    It is the volume of the ellipsoid of tool velocities that joint velocities of norm 1 reach. Source: T.
    Yoshikawa, Manipulability of Robotic Mechanisms, IJRR 4(2), 1985.

    Args:
        J: (6, n) rows of translation in m, then of rotation in rad, per unit of joint rate.
        length: m, about the reach of the wrist; it makes rotation comparable with translation.

    Returns:
        The measure, 0 in a singular configuration.
    """
    scaled = J * np.array([1.0, 1.0, 1.0, length, length, length])[:, None]
    return float(np.sqrt(max(np.linalg.det(scaled @ scaled.T), 0.0)))
