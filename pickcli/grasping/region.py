"""Task space regions: continuous sets of tool poses relative to an object.

Source: KTH, section IV-B, after Berenson, Srinivasa and Kuffner, "Task Space Regions" (IJRR 2011).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array, inverse, rotation_rpy


@dataclass(frozen=True, eq=False)
class TaskSpaceRegion:
    """All poses ``T_object_region @ D @ T_region_tool`` with the displacement D inside the bounds.

    Attributes:
        T_object_region: (4, 4) frame of the region in the object's.
        T_region_tool: (4, 4) tool frame in the region's at displacement 0.
        bounds: (6, 2) least and greatest x, y, z in m and roll, pitch, yaw in rad of D.
    """

    T_object_region: Array
    T_region_tool: Array
    bounds: Array

    def sample(self, rng: np.random.Generator, n: int) -> Array:
        """Sample tool poses, uniform in the six displacements.

        Args:
            rng: Source of the samples.
            n: Number of poses.

        Returns:
            (n, 4, 4) tool poses in the object frame.
        """
        low, high = self.bounds[:, 0], self.bounds[:, 1]
        return self.poses_at(low + (high - low) * rng.random((n, 6)))

    def centre(self) -> Array:
        """Return the tool pose in the middle of the bounds.

        Returns:
            (4, 4) tool pose in the object frame.
        """
        return np.asarray(self.poses_at(self.bounds.mean(axis=1)[None])[0])

    def poses_at(self, displacements: Array) -> Array:
        """Return the tool poses at displacements.

        Args:
            displacements: (N, 6) x, y, z in m and roll, pitch, yaw in rad.

        Returns:
            (N, 4, 4) tool poses in the object frame.
        """
        D = np.tile(np.eye(4), (len(displacements), 1, 1))
        D[:, :3, :3] = np.moveaxis(rotation_rpy(*displacements[:, 3:].T), -1, 0)
        D[:, :3, 3] = displacements[:, :3]
        return np.asarray(self.T_object_region @ D @ self.T_region_tool)

    def displacement(self, T_object_tool: Array) -> Array:
        """Return the displacement that leads to a tool pose.

        Args:
            T_object_tool: (4, 4) tool pose in the object frame.

        Returns:
            (6,) x, y, z in m and roll, pitch, yaw in rad, in (-pi, pi].
        """
        D = inverse(self.T_object_region) @ T_object_tool @ inverse(self.T_region_tool)
        roll = np.arctan2(D[2, 1], D[2, 2])
        pitch = np.arctan2(-D[2, 0], np.hypot(D[2, 1], D[2, 2]))
        yaw = np.arctan2(D[1, 0], D[0, 0])
        return np.array([*D[:3, 3], roll, pitch, yaw])

    def distance(self, T_object_tool: Array) -> float:
        """Return how far a tool pose is outside the bounds.

        Args:
            T_object_tool: (4, 4) tool pose in the object frame.

        Returns:
            Euclidean norm over m and rad, 0 inside.
        """
        d = self.displacement(T_object_tool)
        outside = np.maximum(0.0, np.maximum(self.bounds[:, 0] - d, d - self.bounds[:, 1]))
        return float(np.linalg.norm(outside))

    def contains(self, T_object_tool: Array, tolerance: float = 1e-9) -> bool:
        """Whether a tool pose is in the region.

        Args:
            T_object_tool: (4, 4) tool pose in the object frame.
            tolerance: Distance outside that still counts as inside, norm over m and rad.

        Returns:
            True if it is.
        """
        return self.distance(T_object_tool) <= tolerance
