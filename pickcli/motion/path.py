"""Geometry without time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class JointPath:
    """A polyline in joint space: straight edges between consecutive configurations."""

    joint_names: tuple[str, ...]
    waypoints: Array  # (N, n), N >= 1

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
        """The same geometry, backwards."""
        return JointPath(self.joint_names, self.waypoints[::-1].copy())
