"""A rough pose of the pod to start from: its boxes drawn to measured points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.geometry import Array, inverse, transform_points

MARGIN = 0.08  # m around the pod, at all poses of its tolerance, in which points count
_N_POINTS = 400  # evenly over the picture
_SCALE, _MOST_STEPS = 0.04, 8  # m, of the cost; it draws the pod from anywhere in its tolerance
_SETTLED = 1e-4  # m and rad, step after which it ends


@dataclass(frozen=True, eq=False)
class PodBoxes:
    """Boxes of the pod in its frame.

    Attributes:
        half: (B, 3) m, halves of their sides.
        T_pod_box: (B, 4, 4) their poses.
        low: (3,) m, lower corner of the box around all.
        high: (3,) m, its upper corner.
        reach: m around it, in which points may be the pod's: its tolerance and a margin.
        tolerance: (3,) m, m and rad, the largest displacement in x, y and yaw.
    """

    half: Array
    T_pod_box: Array
    low: Array
    high: Array
    reach: float
    tolerance: Array

    @classmethod
    def of(cls, cell: Cell) -> PodBoxes:
        """Take the boxes of a cell's pod.

        Args:
            cell: The cell.

        Returns:
            The boxes.
        """
        bodies, free = cell.pod.bodies, cell.pod.displacement
        half = np.array([body.shape.extents / 2 for body in bodies])
        T = np.array([body.T_parent_shape for body in bodies])
        reach = np.array([body.shape.reach(body.T_parent_shape[:3, :3]) for body in bodies])
        low, high = (T[:, :3, 3] - reach).min(axis=0), (T[:, :3, 3] + reach).max(axis=0)
        turned = free.yaw * float(np.hypot(high[0], high[1]))
        around = MARGIN + float(np.hypot(free.x, free.y)) + turned
        return cls(half, T, low, high, around, np.array([free.x, free.y, free.yaw]))

    def around(self, points: Array, T_world_pod: Array) -> Array:
        """Select the points that may be the pod's.

        Args:
            points: (N, 3) m in the world.
            T_world_pod: (4, 4) where the pod may stand, within its tolerance.

        Returns:
            (M, 3) those around it.
        """
        at = transform_points(inverse(T_world_pod), points)
        is_near = ((at >= self.low - self.reach) & (at <= self.high + self.reach)).all(axis=1)
        return np.asarray(points[is_near])

    def drawn(self, points: Array, T_world_guess: Array) -> Array:
        """Draw the pod to points by Gauss-Newton steps on the cost of Geman and McClure.

        Args:
            points: (N, 3) m in the world.
            T_world_guess: (4, 4) where the pod may stand, within its tolerance.

        Returns:
            (3,) offset in x, y and yaw in the frame of the guess, within the tolerance. Dividers are thin and
            alike: y may be that of the wrong side of one, or of another.
        """
        points = points[np.linspace(0, len(points) - 1, min(_N_POINTS, len(points))).astype(int)]
        offset = np.zeros(3)
        for _ in range(_MOST_STEPS):
            at = transform_points(inverse(displaced(T_world_guess, *offset)), points)
            d, gradients = self.distances(at)
            c, s = np.cos(offset[2]), np.sin(offset[2])
            gx, gy = gradients[:, 0], gradients[:, 1]
            # A pod that moves one way sees the points move the other way.
            J = np.stack([s * gy - c * gx, -s * gx - c * gy, gx * at[:, 1] - gy * at[:, 0]], axis=1)
            weighted = J * ((_SCALE**2 / (_SCALE**2 + d**2)) ** 2)[:, None]
            step = -np.linalg.solve(weighted.T @ J + 1e-9 * np.eye(3), weighted.T @ d)
            offset = offset + step
            if np.abs(step).max() < _SETTLED:
                break
        return np.clip(offset, -self.tolerance, self.tolerance)

    def distances(self, points: Array) -> tuple[Array, Array]:
        """Compute the distances of points from the nearest box.

        Args:
            points: (N, 3) m in the frame of the pod.

        Returns:
            (N,) m, negative inside, and (N, 3) their gradients.
        """
        local = self._local(points)
        beyond = [np.abs(each) - half for each, half in zip(local, self.half.T, strict=True)]
        squares = sum(np.maximum(each, 0.0) ** 2 for each in beyond)
        inside = np.maximum(np.maximum(beyond[0], beyond[1]), beyond[2])
        distances = np.where(squares > 0.0, np.sqrt(squares), inside)
        rows, k = np.arange(len(points)), np.argmin(np.abs(distances), axis=1)
        nearest = np.stack([each[rows, k] for each in beyond], axis=1)
        sides = np.sign(np.stack([each[rows, k] for each in local], axis=1))
        d = distances[rows, k]
        outside = np.maximum(nearest, 0.0) / np.maximum(d, 1e-12)[:, None]
        face = np.eye(3)[np.argmax(nearest, axis=1)]
        gradients = sides * np.where((d > 0.0)[:, None], outside, face)
        return d, np.einsum("nij,nj->ni", self.T_pod_box[k, :3, :3], gradients)

    def _local(self, points: Array) -> tuple[Array, Array, Array]:
        """Return x, y and z, (N, B) each, of points (N, 3) in the frames of the boxes."""
        axes = self.T_pod_box[:, :3, :3].transpose(1, 0, 2).reshape(3, -1)  # of all boxes side by side
        offsets = np.einsum("bi,bij->bj", self.T_pod_box[:, :3, 3], self.T_pod_box[:, :3, :3])
        local = points @ axes - offsets.ravel()
        return local[:, 0::3], local[:, 1::3], local[:, 2::3]
