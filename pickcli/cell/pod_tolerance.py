"""Displacement bounds of the pod, and the volumes that its parts sweep within them.

The organisers of the challenge shifted the shelf before a trial (KTH, section I). Motions precomputed for a
cell are proven against the swept volumes if possible, and then hold for every allowed pose of the pod.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import product
from math import acos, degrees

import numpy as np

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose

# Tolerance of poses beyond a bound, m or rad; far less than the clearance.
_TOLERANCE = 1e-6

_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


class PodPoses(StrEnum):
    """The poses of the pod for which something holds."""

    NOMINAL = "nominal"  # exactly the pose in the cell file
    DISPLACED = "displaced"  # any pose within its displacement bounds


@dataclass(frozen=True)
class PodValidity:
    """The pod poses for which a stored motion was proven.

    Attributes:
        pod_poses: The poses of the pod for which it was proven.
        why_nominal: Why it holds only for the nominal pose, "" if it holds for all.
    """

    pod_poses: PodPoses = PodPoses.NOMINAL
    why_nominal: str = ""


ANY_POD = PodValidity(PodPoses.DISPLACED)
NOMINAL_POD = PodValidity()


@dataclass(frozen=True)
class Displacement:
    """Displacement bounds of the pod, in the frame of the nominal pod. The pod stands upright on the floor.

    Attributes:
        x: m, largest offset along x, either way.
        y: m, largest offset along y, either way.
        yaw: rad, largest rotation about its own z, either way.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def allows(self, T_nominal_pod: Array) -> bool:
        """Whether a pose of the pod is within the bounds.

        Args:
            T_nominal_pod: (4, 4) pose of the pod in the frame of the nominal one.

        Returns:
            True if it is.
        """
        x, y, z = T_nominal_pod[:3, 3]
        roll_pitch = float(np.abs(T_nominal_pod[:3, 2] - [0.0, 0.0, 1.0]).max())
        off = (abs(x) - self.x, abs(y) - self.y, abs(z), roll_pitch, abs(yaw_of(T_nominal_pod)) - self.yaw)
        return bool(max(off) <= _TOLERANCE)

    def bound(self, radius: float) -> float:
        """Bound the displacement of a point of the pod.

        Args:
            radius: m from the pod's z axis to the point.

        Returns:
            m.
        """
        return float(np.hypot(self.x, self.y)) + self.yaw * radius

    def swept(self, body: Body) -> Body:
        """Compute the smallest box along a body's own axes that contains it for every allowed displacement.

        Exact for boxes: the extent of the sweep along an axis is that of its farthest corner, which moves on
        an arc about the pod's z axis and then by x and y.

        Args:
            body: A body in the frame of the nominal pod.

        Returns:
            The box, in that frame.
        """
        R = body.T_parent_shape[:3, :3]
        corners = body.T_parent_shape[:3, 3] + (_CORNERS * body.shape.extents / 2) @ R.T
        high, low = self._reach(corners, R.T), -self._reach(corners, -R.T)
        size = tuple(float(v) for v in high - low)
        return Body(body.name, Shape(ShapeKind.BOX, size), pose(R @ ((high + low) / 2), R=R))

    def _reach(self, points: Array, axes: Array) -> Array:
        """Largest coordinate (A,), m, of all displaced copies of points (P, 3) along axes (A, 3)."""
        across = np.hypot(*points[:, :2].T)[:, None] * np.hypot(*axes[:, :2].T)
        between = np.arctan2(points[:, 1], points[:, 0])[:, None] - np.arctan2(axes[:, 1], axes[:, 0])
        between = np.abs(np.arctan2(np.sin(between), np.cos(between)))
        turned = across * np.cos(np.maximum(between - self.yaw, 0.0)) + points[:, 2:] * axes[:, 2]
        return np.asarray(turned.max(axis=0) + np.abs(axes[:, :2]) @ [self.x, self.y])


UNMOVED = Displacement()  # carriers that cannot be displaced


def displaced(T_world_pod: Array, x: float, y: float, yaw: float) -> Array:
    """Compute the pose of a displaced pod.

    Args:
        T_world_pod: (4, 4) nominal pose.
        x: m.
        y: m.
        yaw: rad.

    Returns:
        (4, 4) ``T_world_pod``.
    """
    return np.asarray(T_world_pod @ pose((x, y, 0.0), rpy=(0.0, 0.0, yaw)))


def yaw_of(T_nominal_pod: Array) -> float:
    """Compute the yaw of a pod.

    Args:
        T_nominal_pod: (4, 4) pose of the pod in the frame of the nominal one.

    Returns:
        rad.
    """
    return float(np.arctan2(T_nominal_pod[1, 0], T_nominal_pod[0, 0]))


def pod_stand(T_nominal_pod: Array) -> str:
    """Describe the displacement of a pod in mm and degrees.

    Args:
        T_nominal_pod: (4, 4) pose of the pod in the frame of the nominal one.

    Returns:
        The text.
    """
    x, y, z = 1e3 * T_nominal_pod[:3, 3]
    yaw = degrees(yaw_of(T_nominal_pod))
    text = f"{x:+z.1f} mm in x, {y:+z.1f} mm in y, {yaw:+z.2f} degrees off its place"
    tilt = degrees(acos(min(T_nominal_pod[2, 2], 1.0)))
    return text + (f", raised by {z:.1f} mm and tilted by {tilt:.2f} degrees" if abs(z) + tilt > 1e-3 else "")
