"""Where the pod stands, from one depth picture: its solids fitted to all measured points.

Team KTH (paper 000, section III-A) finds the two front legs in a slice of the cloud of a camera at the chest.
Our pod has no legs, and all of it says more than two of its edges: items in it are outliers of a robust fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.perception.depth_picture import DepthPicture

COARSE, FINE = 600, 2500  # points of the first fits, and of the last one
LEAST_POINTS = 400
PIXEL_STEP = 4  # of the picture, in both directions: neighbours err alike
MARGIN = 0.08  # m around the pod, at all poses of its tolerance, in which points count
LEAST_EXPLAINED = 0.35  # share of the points that must lie on the pod within ``ON_IT``
ON_IT = 0.01  # m
# m by which the coarse fit may be off: thin walls, dividers and lips have two sides
SIDESTEPS = np.array(
    [[0, 0, 0], [0.012, 0, 0], [-0.012, 0, 0], [0, 0.006, 0], [0, -0.006, 0], [0, 0.012, 0], [0, -0.012, 0]]
)
SETTLED = 2e-5  # m and rad, step after which a fit ends


@dataclass(frozen=True, eq=False)
class PodEstimate:
    """The pod as seen in one picture.

    Attributes:
        T_world_pod: (4, 4) its pose. It stands upright on the floor, so only x, y and yaw are estimated.
        explained: Share of the points around the pod that lie on it within 10 mm; the others are items.
        n_points: Number of points in the last fit.
    """

    T_world_pod: Array
    explained: float
    n_points: int


def locate_pod(picture: DepthPicture, cell: Cell, T_world_guess: Array | None = None) -> PodEstimate:
    """Estimate the pose of the pod from a depth picture.

    The cost of Geman and McClure over the distances of the points from the nearest of the pod's boxes is
    minimised by Gauss-Newton steps, first with a wide scale, that draws the pod from anywhere in its
    tolerance, then with narrower ones. The error of the camera's own pose adds to that of the result.

    Args:
        picture: The picture, with the pose of its camera.
        cell: A cell with a pod.
        T_world_guess: (4, 4) where the pod may stand, within its tolerance; None for its nominal pose.

    Returns:
        The estimate. The same picture gives the same bytes.

    Raises:
        InputError: The cell has no pod, too few points are around it, or they do not look like it.
    """
    if not cell.pod.bins:
        raise InputError(f"cell {cell.name}: has no pod to be located")
    T_guess = cell.T_world_pod if T_world_guess is None else T_world_guess
    solids = _PodSolids.of(cell)
    points = solids.around(picture, T_guess)
    if len(points) < LEAST_POINTS:
        few = f"only {len(points)} points are measured around it, at least {LEAST_POINTS} are needed"
        raise InputError(f"pod not located: {few}; look at it from 0.7 to 3 m")
    eye, first, last = picture.T_world_camera[:3, 3], _thinned(points, COARSE), _thinned(points, FINE)
    coarse, _ = solids.fitted(first, None, T_guess, np.zeros(3), 0.04, 12)
    near = (solids.fitted(first, None, T_guess, coarse + step, 0.012, 5)[0] for step in SIDESTEPS)
    beside = (solids.fitted(first, eye, T_guess, start, 0.005, 4) for start in near)
    offset, _ = min(beside, key=lambda found: found[1])
    offset, _ = solids.fitted(last, eye, T_guess, offset, 0.005, 6)
    T_world_pod = displaced(T_guess, *offset)
    distances, _ = solids.distances(_in_frame(last, T_world_pod))
    explained = float((np.abs(distances) <= ON_IT).mean())
    if explained < LEAST_EXPLAINED:
        found = f"only {100 * explained:.0f} % of the points around it lie on it where it fits best"
        raise InputError(f"pod not located: {found}; does it stand within its tolerance, and is this it?")
    return PodEstimate(T_world_pod, explained, len(last))


@dataclass(frozen=True, eq=False)
class _PodSolids:
    """Boxes of the pod in its frame.

    half: (B, 3) m. T: (B, 4, 4). low, high: (3,) m of the box around them. reach: m, tolerance and margin
    """

    half: Array
    T: Array
    low: Array
    high: Array
    reach: float

    @classmethod
    def of(cls, cell: Cell) -> _PodSolids:
        bodies, free = cell.pod.bodies, cell.pod.displacement
        half = np.array([body.shape.extents / 2 for body in bodies])
        T = np.array([body.T_parent_shape for body in bodies])
        reach = np.array([body.shape.reach(body.T_parent_shape[:3, :3]) for body in bodies])
        low, high = (T[:, :3, 3] - reach).min(axis=0), (T[:, :3, 3] + reach).max(axis=0)
        turned = free.yaw * float(np.hypot(high[0], high[1]))
        return cls(half, T, low, high, MARGIN + float(np.hypot(free.x, free.y)) + turned)

    def around(self, picture: DepthPicture, T_world_pod: Array) -> Array:
        """Return (N, 3) measured points around the pod, m in the world."""
        depth = picture.depth[::PIXEL_STEP, ::PIXEL_STEP]
        is_there = np.isfinite(depth)
        rays = picture.camera.rays[::PIXEL_STEP, ::PIXEL_STEP][is_there]
        T = picture.T_world_camera
        points = rays * depth[is_there].astype(np.float64)[:, None] @ T[:3, :3].T + T[:3, 3]
        at = _in_frame(points, T_world_pod)
        is_near = ((at >= self.low - self.reach) & (at <= self.high + self.reach)).all(axis=1)
        return np.asarray(points[is_near])

    def distances(self, points: Array) -> tuple[Array, Array]:
        """Return (N,) distances in m from the nearest box, negative inside, and (N, 3) their gradients."""
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
        return d, np.einsum("nij,nj->ni", self.T[k, :3, :3], gradients)

    def _local(self, points: Array) -> tuple[Array, Array, Array]:
        """Return x, y and z, (N, B) each, of points (N, 3) in the frames of the boxes."""
        axes = self.T[:, :3, :3].transpose(1, 0, 2).reshape(3, -1)  # of all boxes side by side
        offsets = np.einsum("bi,bij->bj", self.T[:, :3, 3], self.T[:, :3, :3])
        local = points @ axes - offsets.ravel()
        return local[:, 0::3], local[:, 1::3], local[:, 2::3]

    def fitted(
        self,
        points: Array,
        eye: Array | None,
        T_world_guess: Array,
        start: Array,
        scale: float,
        most_steps: int,
    ) -> tuple[Array, float]:
        """Minimise the cost over x, y and yaw (3,) in the frame of the guess; return them, and the cost.

        A camera at eye (3,), unless that is None, sees only sides that face it: points on others are not
        explained.
        """
        offset, cost = start, 1.0
        for _ in range(most_steps):
            at = _in_frame(points, displaced(T_world_guess, *offset))
            d, gradients = self.distances(at)
            c, s = np.cos(offset[2]), np.sin(offset[2])
            gx, gy = gradients[:, 0], gradients[:, 1]
            # A pod that moves one way sees the points move the other way.
            J = np.stack([s * gy - c * gx, -s * gx - c * gy, gx * at[:, 1] - gy * at[:, 0]], axis=1)
            is_seen = np.ones(len(at), dtype=bool)
            if eye is not None:
                to_eye = _in_frame(eye[None], displaced(T_world_guess, *offset)) - at
                is_seen = np.einsum("ni,ni->n", gradients, to_eye) > 0.0
            weights = np.where(is_seen, (scale**2 / (scale**2 + d**2)) ** 2, 0.0)
            cost = float(np.where(is_seen, d**2 / (scale**2 + d**2), 1.0).mean())
            normal = (J * weights[:, None]).T @ J + 1e-9 * np.eye(3)
            step = -np.linalg.solve(normal, (J * weights[:, None]).T @ d)
            offset = offset + step
            if np.abs(step).max() < SETTLED:
                break
        return offset, cost


def _in_frame(points: Array, T_world_frame: Array) -> Array:
    T = inverse(T_world_frame)
    return np.asarray(points @ T[:3, :3].T + T[:3, 3])


def _thinned(points: Array, n_most: int) -> Array:
    """Return at most so many points, evenly over the picture."""
    return np.asarray(points[np.linspace(0, len(points) - 1, min(n_most, len(points))).astype(int)])
