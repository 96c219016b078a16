"""How far the pod may stand from its place, and the volume that each part of it can sweep there.

The organisers of the challenge shifted the shelf before a trial (KTH, section I). What is computed once per
cell is proven against the swept volume where that is possible: then it holds wherever the pod stands.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from itertools import product
from math import acos, degrees

import numpy as np

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose

# How far a pose, which is never exact, may be beyond a bound, m or rad: far less than the clearance.
_TOLERANCE = 1e-6

_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


class PodPoses(StrEnum):
    """The poses of the pod for which something holds."""

    NOMINAL = "nominal"  # exactly where the cell says
    DISPLACED = "displaced"  # anywhere within its bounds


@dataclass(frozen=True)
class PodValidity:
    """For which pods something that is stored was proven.

    Attributes:
        pod_poses: The poses of the pod for which it was proven.
        why_nominal: Why it holds for the pod in its place alone, "" if it holds for any.
    """

    pod_poses: PodPoses = PodPoses.NOMINAL
    why_nominal: str = ""


ANY_POD = PodValidity(PodPoses.DISPLACED)
NOMINAL_POD = PodValidity()


@dataclass(frozen=True)
class Displacement:
    """Bounds of where the pod stands, in the frame of the nominal pod. It stands on the floor, upright.

    Attributes:
        x: m, how far its frame may be off, either way.
        y: m, how far its frame may be off, either way.
        yaw: rad, how far it may be turned about its own z, either way.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0

    def allows(self, T_nominal_pod: Array) -> bool:
        """Whether a pod stands within the bounds.

        Args:
            T_nominal_pod: (4, 4) its pose, seen from its nominal place.

        Returns:
            True if it does.
        """
        x, y, z = T_nominal_pod[:3, 3]
        roll_pitch = float(np.abs(T_nominal_pod[:3, 2] - [0.0, 0.0, 1.0]).max())
        off = (abs(x) - self.x, abs(y) - self.y, abs(z), roll_pitch, abs(yaw_of(T_nominal_pod)) - self.yaw)
        return bool(max(off) <= _TOLERANCE)

    def bound(self, radius: float) -> float:
        """How far a point of the pod can be moved.

        Args:
            radius: m from the pod's z axis to the point.

        Returns:
            m.
        """
        return float(np.hypot(self.x, self.y)) + self.yaw * radius

    def swept(self, body: Body) -> Body:
        """The smallest box along a body's own axes that holds it wherever the pod stands.

        Exact for boxes: how far the sweep reaches along an axis is how far the farthest of the corners gets,
        each of which moves on an arc about the pod's z and then by x and y.

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
        """(A,) m, how far along each of the axes (A, 3) any displaced copy of the points (P, 3) gets."""
        across = np.hypot(*points[:, :2].T)[:, None] * np.hypot(*axes[:, :2].T)
        between = np.arctan2(points[:, 1], points[:, 0])[:, None] - np.arctan2(axes[:, 1], axes[:, 0])
        between = np.abs(np.arctan2(np.sin(between), np.cos(between)))
        turned = across * np.cos(np.maximum(between - self.yaw, 0.0)) + points[:, 2:] * axes[:, 2]
        return np.asarray(turned.max(axis=0) + np.abs(axes[:, :2]) @ [self.x, self.y])


UNMOVED = Displacement()  # it always stands in its place


def displaced(T_world_pod: Array, x: float, y: float, yaw: float) -> Array:
    """Pose of a pod that is moved and turned from its place.

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
    """How far a pod is turned about z.

    Args:
        T_nominal_pod: (4, 4) its pose, seen from its nominal place.

    Returns:
        rad.
    """
    return float(np.arctan2(T_nominal_pod[1, 0], T_nominal_pod[0, 0]))


def pod_stand(T_nominal_pod: Array) -> str:
    """Where a pod stands, in words: mm and degrees, seen from its place.

    Args:
        T_nominal_pod: (4, 4) its pose, seen from its nominal place.

    Returns:
        The words.
    """
    x, y, z = 1e3 * T_nominal_pod[:3, 3]
    text = f"{x:+.1f} mm in x, {y:+.1f} mm in y, {degrees(yaw_of(T_nominal_pod)):+.2f} degrees off its place"
    tilt = degrees(acos(min(T_nominal_pod[2, 2], 1.0)))
    return text + (f", raised by {z:.1f} mm and tilted by {tilt:.2f} degrees" if abs(z) + tilt > 1e-3 else "")
