"""How well a configuration can move its tool."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array


def yoshikawa(J: Array, length: float = 0.5) -> float:
    """Yoshikawa's manipulability sqrt(det(J J^T)) of a Jacobian (6, n): 0 in a singular configuration.

    It is the volume of the ellipsoid of tool velocities that joint velocities of norm 1 reach. ``length``
    in m (about the reach of the wrist) makes the rows of rotation comparable with those of translation.
    Source: T. Yoshikawa, Manipulability of Robotic Mechanisms, IJRR 4(2), 1985.
    """
    scaled = J * np.array([1.0, 1.0, 1.0, length, length, length])[:, None]
    return float(np.sqrt(max(np.linalg.det(scaled @ scaled.T), 0.0)))
