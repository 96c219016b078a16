"""Task space regions: continuous sets of tool poses relative to an object.

Source: KTH, section IV-B, after Berenson, Srinivasa and Kuffner, "Task Space Regions" (IJRR 2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array, inverse, pose, rotation_rpy


@dataclass(frozen=True, eq=False)
class TaskSpaceRegion:
    """All poses ``T_object_region @ D @ T_region_tool`` with the displacement D inside the bounds.

    bounds: (6, 2), least and greatest x, y, z in m and roll, pitch, yaw in rad of D.
    """

    T_object_region: Array  # (4, 4)
    T_region_tool: Array  # (4, 4)
    bounds: Array  # (6, 2)

    def sample(self, rng: np.random.Generator, n: int) -> Array:
        """n tool poses (n, 4, 4) in the object frame, uniform in the six displacements."""
        low, high = self.bounds[:, 0], self.bounds[:, 1]
        d = low + (high - low) * rng.random((n, 6))
        D = np.tile(np.eye(4), (n, 1, 1))
        D[:, :3, :3] = np.moveaxis(rotation_rpy(*d[:, 3:].T), -1, 0)
        D[:, :3, 3] = d[:, :3]
        return np.asarray(self.T_object_region @ D @ self.T_region_tool)

    def centre(self) -> Array:
        """The tool pose (4, 4) in the middle of the bounds."""
        return self.pose_at(self.bounds.mean(axis=1))

    def pose_at(self, displacement: Array) -> Array:
        """The tool pose (4, 4) at a displacement (6,)."""
        D = pose(displacement[:3], rpy=displacement[3:])
        return np.asarray(self.T_object_region @ D @ self.T_region_tool)

    def displacement(self, T_object_tool: Array) -> Array:
        """The displacement (6,) that leads to a tool pose; angles in (-pi, pi]."""
        D = inverse(self.T_object_region) @ T_object_tool @ inverse(self.T_region_tool)
        roll = np.arctan2(D[2, 1], D[2, 2])
        pitch = np.arctan2(-D[2, 0], np.hypot(D[2, 1], D[2, 2]))
        yaw = np.arctan2(D[1, 0], D[0, 0])
        return np.array([*D[:3, 3], roll, pitch, yaw])

    def distance(self, T_object_tool: Array) -> float:
        """How far a tool pose is outside the bounds: norm over m and rad, 0 inside."""
        d = self.displacement(T_object_tool)
        outside = np.maximum(0.0, np.maximum(self.bounds[:, 0] - d, d - self.bounds[:, 1]))
        return float(np.linalg.norm(outside))

    def contains(self, T_object_tool: Array, tolerance: float = 1e-9) -> bool:
        """Whether a tool pose is in the region."""
        return self.distance(T_object_tool) <= tolerance
