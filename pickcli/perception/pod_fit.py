"""The pod fitted to a depth picture: it is rendered, and moved until the picture shows the same.

Registration by projection (Blais and Levine 1995) with distances from planes (Chen and Medioni 1992): each
pixel is compared with the surface that its own ray meets. So only sides that face the camera count, of thin
walls and lips the right one, and where the pod hides a part of itself nothing is compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array, inverse, pose, rotation_from_vector
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.perception.surface_view import FloatPicture

ON_IT = 0.01  # m from the surface, within which a pixel is said to show it
SIGMAS = 3.0  # of a depth, that the scale of its cost is at least
THROUGH = 3.0  # scales behind the surface, from which it was seen through
THROUGH_COST = 10.0  # of a pixel that sees through the pod, which cannot be; items before it cost 1 at most
FIXED = 1e-6  # m and rad, tolerance of what cannot be displaced
CAMERA_DAMPING = 1e4  # m^-2 and rad^-2: a direction in which nothing is seen stays as stated within 10 mm
SETTLED = 2e-5  # m and rad, step after which a fit ends


@dataclass(frozen=True, eq=False)
class PodFit:
    """How well the pod at one offset agrees with a picture.

    Attributes:
        offset: (3,) x, y in m and yaw in rad, in the frame of the guess.
        step: (3,) the last step that led there, m, m and rad in the frame of the pod.
        cost: Mean of the pixels that should show the pod, from 0 to ``THROUGH_COST``.
        information: (3, 3) second derivatives of the cost, were it summed and quadratic: of x, y and yaw in
            the frame of the pod, in units of a pixel that is off by its scale.
        by_camera: (3, 6) motion of the pod in its own frame by the motion of the camera that takes the
            picture: 3 shifts in m, and 3 turns about its centre in rad.
        n_telling: (2,) how many pixels tell where it is along x and along y: surfaces across count by the
            squared cosine of their normals, items not at all.
        n_pixels: Number of pixels that should show the pod, and have a depth.
        explained: Share of them that is within 10 mm of its surface.
        through: Share of them in which something behind it was measured.
    """

    offset: Array
    step: Array
    cost: float
    information: Array
    by_camera: Array
    n_telling: Array
    n_pixels: int
    explained: float
    through: float


@dataclass(frozen=True, eq=False)
class CameraFit:
    """Where a camera is, as a picture of the pod shows it.

    Attributes:
        T_pod_camera: (4, 4) its pose in the frame of the pod.
        information: (6, 6) second derivatives of the cost, were it summed and quadratic: of 3 shifts and 3
            turns in the frame of the camera, in units of a pixel that is off by its scale.
    """

    T_pod_camera: Array
    information: Array


@dataclass(frozen=True, eq=False)
class ThinnedPicture:
    """Every n-th pixel of a depth picture, along rows and columns: neighbours err alike.

    Attributes:
        camera: Intrinsics, of the pixels that are left.
        T_world_camera: (4, 4) its pose.
        depth: (height, width) m, NaN where nothing was measured.
        spread: (height, width) m, standard deviation of the depth.
    """

    camera: PinholeCamera
    T_world_camera: Array
    depth: FloatPicture
    spread: Array

    @classmethod
    def of(cls, picture: DepthPicture, noise: DepthModel, most: int) -> ThinnedPicture:
        """Thin a picture out.

        Args:
            picture: The picture.
            noise: How its depth is measured.
            most: Number of pixels that may be left.

        Returns:
            The rest.
        """
        full = picture.camera
        n = max(1, int(np.ceil(np.sqrt(full.width * full.height / most))))
        depth = picture.depth[::n, ::n]
        rows, columns = depth.shape
        camera = PinholeCamera(full.fx / n, full.fy / n, full.cx / n, full.cy / n, columns, rows)
        return cls(camera, picture.T_world_camera, depth, noise.spread(depth.astype(np.float64), full.fx))

    @cached_property
    def rays(self) -> Array:
        """(height, width, 3) rays at depth 1."""
        return self.camera.rays

    @property
    def points(self) -> Array:
        """(N, 3) measured points, m in the world."""
        is_there = np.isfinite(self.depth)
        points = self.rays[is_there] * self.depth[is_there][:, None]
        return np.asarray(points @ self.T_world_camera[:3, :3].T + self.T_world_camera[:3, 3])


@dataclass(frozen=True, eq=False)
class PodFitter:
    """Fits the pod of a cell.

    Attributes:
        pod: Its solids, in its own frame.
        T_world_guess: (4, 4) where the pod may stand.
        tolerance: (3,) m, m and rad by which it may be off.
    """

    pod: RenderedScene
    T_world_guess: Array
    tolerance: Array

    @classmethod
    def of(cls, cell: Cell, T_world_guess: Array) -> PodFitter:
        """Take the solids of a cell's pod.

        Args:
            cell: The cell.
            T_world_guess: (4, 4) where the pod may stand.

        Returns:
            The fitter.
        """
        solids = (
            RenderedSolid(OwnerKind.CARRIER, "pod", body.shape, body.T_parent_shape)
            for body in cell.pod.bodies
        )
        free = cell.pod.displacement
        return cls(RenderedScene(tuple(solids)), T_world_guess, np.array([free.x, free.y, free.yaw]))

    def fitted(self, picture: ThinnedPicture, offset: Array, scale: float, most_steps: int) -> PodFit:
        """Minimise the cost of Geman and McClure of distances from the rendered surface.

        Args:
            picture: The picture.
            offset: (3,) where to begin, in the frame of the guess.
            scale: m, distance that costs a quarter; of noisy depths it is more.
            most_steps: Largest number of Gauss-Newton steps.

        Returns:
            The fit; its cost is that before the last step.
        """
        for _ in range(most_steps):
            fit = self._stepped(picture, offset, scale)
            offset = fit.offset
            if np.abs(fit.step).max() < SETTLED:
                break
        return fit

    def cost(self, picture: ThinnedPicture, offset: Array, scale: float) -> float:
        """Compute the cost at an offset.

        Args:
            picture: The picture.
            offset: (3,) in the frame of the guess.
            scale: m, distance that costs a quarter; of noisy depths it is more.

        Returns:
            Mean of the pixels that should show the pod.
        """
        seen = self._compared(picture, self._T_pod_camera(picture, offset), scale)
        return float(seen.costs.sum() / max(len(seen.distances), 1))

    def camera_fitted(
        self, picture: ThinnedPicture, offset: Array, scale: float, most_steps: int
    ) -> CameraFit:
        """Move the camera in all six directions until the picture shows the pod at an offset best.

        Args:
            picture: The picture, with the stated pose of its camera.
            offset: (3,) of the pod, in the frame of the guess.
            scale: m, distance that costs a quarter; of noisy depths it is more.
            most_steps: Largest number of Gauss-Newton steps.

        Returns:
            The fit; its information is that before the last step.
        """
        T = self._T_pod_camera(picture, offset)
        for _ in range(most_steps):
            seen = self._compared(picture, T, scale)
            J = np.hstack([seen.normals, np.cross(seen.points, seen.normals)])
            weighted = J * (seen.weights / seen.variances)[:, None]
            information = weighted.T @ J + CAMERA_DAMPING * np.eye(6)
            step = np.asarray(-np.linalg.solve(information, weighted.T @ seen.distances))
            T = T @ pose(step[:3], R=rotation_from_vector(step[3:]))
            if np.abs(step).max() < SETTLED:
                break
        return CameraFit(T, information)

    def _T_pod_camera(self, picture: ThinnedPicture, offset: Array) -> Array:
        return inverse(displaced(self.T_world_guess, *offset)) @ picture.T_world_camera

    def _compared(self, picture: ThinnedPicture, T: Array, scale: float) -> _Comparison:
        """The picture beside what it would show of the pod from a pose of the camera in its frame."""
        camera = picture.camera
        depth, _, normals = self.pod.kernel.cast_rays(camera.intrinsics, camera.size, T)
        is_shown = np.isfinite(depth) & np.isfinite(picture.depth)
        rays, n = picture.rays[is_shown], normals[is_shown].astype(np.float64)
        measured = picture.depth[is_shown].astype(np.float64)
        facing = np.einsum("ni,ni->n", n, rays)  # below 0
        d = facing * (measured - depth[is_shown])
        variance = scale**2 + (SIGMAS * picture.spread[is_shown] * facing) ** 2
        return _Comparison(T, rays * measured[:, None], n, d, variance)

    def _stepped(self, picture: ThinnedPicture, offset: Array, scale: float) -> PodFit:
        """The fit at an offset, moved by a step."""
        seen = self._compared(picture, self._T_pod_camera(picture, offset), scale)
        T, d, variance = seen.T_pod_camera, seen.distances, seen.variances
        n, beam = seen.normals @ T[:3, :3].T, seen.points @ T[:3, :3].T
        at = beam + T[:3, 3]
        # A pod that moves one way sees the points move the other way.
        J = -np.column_stack([n[:, 0], n[:, 1], n[:, 1] * at[:, 0] - n[:, 0] * at[:, 1]])
        weights = seen.weights
        weighted = J * (weights / variance)[:, None]
        information = weighted.T @ J + np.diag(np.maximum(self.tolerance, FIXED) ** -2.0)
        step = np.asarray(-np.linalg.solve(information, weighted.T @ d))
        by_camera = np.asarray(-np.linalg.solve(information, weighted.T @ np.hstack([n, np.cross(beam, n)])))
        c, s = np.cos(offset[2]), np.sin(offset[2])
        moved = offset + np.array([c * step[0] - s * step[1], s * step[0] + c * step[1], step[2]])
        n_pixels, n_telling = max(len(d), 1), weights @ n[:, :2] ** 2
        return PodFit(
            moved, step, float(seen.costs.sum() / n_pixels), information, by_camera, n_telling, len(d),
            float((np.abs(d) <= ON_IT).sum() / n_pixels), float(seen.is_through.sum() / n_pixels),
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Comparison:
    """Pixels that should show the pod, and have a depth.

    T_pod_camera: (4, 4). points: (N, 3) m, measured, in the camera's frame.
    normals: (N, 3) of the surface, in that frame. distances: (N,) m from its plane, negative behind it
    variances: (N,) m^2, squares of the scales of the distances
    """

    T_pod_camera: Array
    points: Array
    normals: Array
    distances: Array
    variances: Array

    @cached_property
    def off(self) -> Array:
        """(N,) squares of distances by their scales."""
        return self.distances**2 / self.variances

    @cached_property
    def is_through(self) -> NDArray[np.bool_]:
        """(N,) whether something behind the pod was measured."""
        return (self.distances < 0.0) & (self.off > THROUGH**2)

    @property
    def weights(self) -> Array:
        """(N,) of each pixel in a Gauss-Newton step."""
        return 1.0 / (1.0 + self.off) ** 2

    @property
    def costs(self) -> Array:
        """(N,) cost of each pixel."""
        return np.where(self.is_through, THROUGH_COST, self.off / (1.0 + self.off))
