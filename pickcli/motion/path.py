"""Paths: geometry without time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class JointPath:
    """A polyline in joint space: straight edges between consecutive configurations.

    Attributes:
        joint_names: Names of the n joints.
        waypoints: (N, n) configurations, N >= 1.
    """

    joint_names: tuple[str, ...]
    waypoints: Array

    @property
    def length(self) -> float:
        """Sum of the Euclidean lengths of the edges (mixed m and rad)."""
        return float(np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1).sum())

    @property
    def start(self) -> Array:
        """First configuration (n,)."""
        return np.asarray(self.waypoints[0])

    @property
    def end(self) -> Array:
        """Last configuration (n,)."""
        return np.asarray(self.waypoints[-1])

    def reversed(self) -> JointPath:
        """Turn the path around.

        Returns:
            The path with its waypoints reversed.
        """
        return JointPath(self.joint_names, self.waypoints[::-1].copy())
