"""The front of a pallet fitted to a depth picture: each pixel shows the front, or something behind it.

A pixel whose ray meets a runner or the edge of the deck should have its depth; one whose ray goes into a
pocket or past the pallet should not. The first tells distance and direction of the front, the second where
it is along itself: at its edges, where the answers change. Robust squares of both (Geman and McClure 1985)
are least at the pose that is wanted; the method is Powell's dogleg in scipy's form for bounds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.geometry import Array, rotation_from_vector
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pallets.front_pixels import FrontPixels
from pickcli.perception.pallets.pallet_shape import PalletShape

SIGMAS = 3.0  # of a depth, that its scale is at least
LEAST_HEIGHT = 0.03  # m above the floor, below which what is behind a pocket is near its front
TOP = 0.01  # m below the deck, from which on it may be the load that is seen
BESIDE = 0.04  # m beside the front that count as seen past it
BEFORE = 3.0  # scales before the front, from which on something hides it
NOTHING = 0.7  # residual of a pixel that should show the front and in which nothing was measured
EDGE = 1.0  # px that edges are blurred
REACH = np.array([0.15, 0.15, 0.2])  # m, m and rad that a fit may go
DIFFERENCE = 1e-5  # m and rad, to differentiate
LEAST_INFORMATION = 1e-6  # 1 / m^2 and 1 / rad^2, of a direction in which nothing is seen
MOST_STEPS = 15
TOLERANCE = 1e-5  # of the pose and of the cost, below which a fit ends


@dataclass(frozen=True)
class FitStage:
    """How finely a fit looks.

    Attributes:
        scale: m, of distances from the front.
        blur: m that edges are blurred, besides that of pixels.
        n_pixels: At most.
    """

    scale: float
    blur: float
    n_pixels: int


FIRST = (FitStage(0.03, 0.03, 1_000),)
LAST = (FitStage(0.012, 0.01, 2_500), FitStage(0.004, 0.002, 8_000))


@dataclass(frozen=True, eq=False)
class FrontSight:
    """Where rays meet the plane of a front, and what was measured there.

    Attributes:
        y: (N,) m along the front from its middle.
        z: (N,) m above the floor.
        depth: (N,) m from the camera to the plane, along the optical axis.
        behind: (N,) m from the plane to what was measured, negative before it, infinite where nothing was.
        spread: (N,) m, standard deviation of these.
    """

    y: Array
    z: Array
    depth: Array
    behind: Array
    spread: Array

    @classmethod
    def of(cls, pixels: FrontPixels, shape: PalletShape, pose: Array) -> FrontSight:
        """Meet the front of a pallet.

        Args:
            pixels: The pixels.
            shape: The pallet.
            pose: (3,) m, m, rad where it stands.

        Returns:
            What is seen of it.
        """
        x, y, yaw = pose
        c, s = np.cos(yaw), np.sin(yaw)
        facing = pixels.rays[:, 0] * c + pixels.rays[:, 1] * s
        facing = np.minimum(facing, -1e-6)  # below 0, but where it is seen from behind
        from_plane = (pixels.centre[0] - x) * c + (pixels.centre[1] - y) * s - shape.length / 2
        depth = -from_plane / facing
        along = (pixels.centre[1] - y) * c - (pixels.centre[0] - x) * s
        aside = along + depth * (pixels.rays[:, 1] * c - pixels.rays[:, 0] * s)
        height = pixels.centre[2] + depth * pixels.rays[:, 2]
        return cls(aside, height, depth, (depth - pixels.depth) * facing, -pixels.spread * facing)


@dataclass(frozen=True, eq=False)
class FrontResiduals:
    """Two residuals of each pixel: it is off the front and should not be, it is on it and should not be."""

    pixels: FrontPixels
    shape: PalletShape
    stage: FitStage

    @classmethod
    def of(
        cls, pixels: FrontPixels, shape: PalletShape, pose: Array, stage: FitStage
    ) -> FrontResiduals | None:
        """Take the pixels that tell where a front is.

        Args:
            pixels: Pixels around it.
            shape: The pallet.
            pose: (3,) m, m, rad where it may stand.
            stage: How finely it is looked at.

        Returns:
            Their residuals; None if no pixel tells anything.
        """
        seen = FrontSight.of(pixels, shape, pose)
        scales = np.hypot(stage.scale, SIGMAS * seen.spread)
        tells = (
            (seen.depth > 0.0) & (np.abs(seen.y) < shape.width / 2 + BESIDE) & (seen.z > LEAST_HEIGHT)
            & (seen.z < shape.height - TOP) & (seen.behind > -BEFORE * scales)
        )  # fmt: skip
        if not tells.any():
            return None
        kept = FrontPixels(
            pixels.centre, pixels.rays[tells], pixels.depth[tells], pixels.spread[tells], pixels.pixel
        )
        return cls(kept, shape, stage)

    def __call__(self, pose: Array) -> Array:
        """(2 N,) residuals at a pose."""
        seen = FrontSight.of(self.pixels, self.shape, pose)
        scales = np.hypot(self.stage.scale, SIGMAS * seen.spread)
        edges = self.stage.blur + EDGE * self.pixels.pixel * seen.depth
        share = np.clip(self._share(seen, edges), 1e-9, 1.0 - 1e-9)
        is_there = np.isfinite(seen.behind)
        gap = np.where(is_there, seen.behind, 0.0) / scales
        root = np.sqrt(1.0 + gap**2)
        off = np.where(is_there, gap / root, NOTHING)
        on = np.where(is_there, 1.0 / root, 0.0)
        return np.concatenate([np.sqrt(share) * off, np.sqrt(1.0 - share) * on])

    def _share(self, seen: FrontSight, edges: Array) -> Array:
        """(N,) how sure a ray meets the front: from 0 to 1 over edges."""
        half = self.shape.width / 2
        inside = _step((seen.y + half) / edges) * _step((half - seen.y) / edges)
        empty = np.zeros_like(inside)
        for right, left in self.shape.pockets:
            empty += _step((seen.y - right) / edges) * _step((left - seen.y) / edges)
        empty = empty * _step((self.shape.opening - seen.z) / edges)
        return np.asarray(inside * (1.0 - empty))

    def moved(self, step: Array) -> FrontResiduals:
        """Return the residuals, were the camera elsewhere.

        Args:
            step: (6,) m and rad: shift of the camera, and its turn about its centre.

        Returns:
            They.
        """
        rays = self.pixels.rays @ rotation_from_vector(step[3:]).T
        return replace(self, pixels=replace(self.pixels, centre=self.pixels.centre + step[:3], rays=rays))


@dataclass(frozen=True, eq=False)
class FrontFit:
    """The pallet where its front agrees best with a picture.

    Attributes:
        pose: (3,) m, m, rad of the pallet in the frame on the floor.
        residuals: Of the pixels, by the pose.
    """

    pose: Array
    residuals: FrontResiduals

    @cached_property
    def cost(self) -> float:
        """Sum of squares of the two residuals of a pixel, in the mean: from 0 to 1."""
        return float(2 * (self.residuals(self.pose) ** 2).mean())

    @cached_property
    def _slopes(self) -> Array:
        """(2 N, 3) of the residuals by x, y and yaw in the frame of the pallet."""
        c, s = np.cos(self.pose[2]), np.sin(self.pose[2])
        own = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]) * DIFFERENCE
        changes = [self.residuals(self.pose + step) - self.residuals(self.pose - step) for step in own]
        return np.column_stack(changes) / (2 * DIFFERENCE)

    @cached_property
    def information(self) -> Array:
        """(3, 3) half the second derivatives of the sum of squares: of x, y and yaw in the pallet's frame."""
        return np.asarray(self._slopes.T @ self._slopes + LEAST_INFORMATION * np.eye(3))

    @cached_property
    def by_camera(self) -> Array:
        """(3, 6) motion of the pallet in its frame by that of the camera that takes the picture.

        Those are 3 shifts in m, and 3 turns about its centre in rad, in the frame on the floor.
        """
        moved = [
            self.residuals.moved(step)(self.pose) - self.residuals.moved(-step)(self.pose)
            for step in DIFFERENCE * np.eye(6)
        ]
        slopes = np.column_stack(moved) / (2 * DIFFERENCE)
        return np.asarray(-np.linalg.solve(self.information, self._slopes.T @ slopes))


def approached(
    picture: DepthPicture, noise: DepthModel, shape: PalletShape, pose: Array, stages: tuple[FitStage, ...]
) -> FrontFit | None:
    """Fit a pallet from a pose nearby.

    Args:
        picture: The picture; its world is the frame on the floor.
        noise: How its depth is measured.
        shape: The pallet.
        pose: (3,) m, m, rad to begin at.
        stages: How, one after the other.

    Returns:
        The fit; None if the front is not in the picture.
    """
    residuals: FrontResiduals | None = None
    for stage in stages:
        pixels = FrontPixels.of(picture, noise, front_corners(shape, pose), stage.n_pixels)
        residuals = None if pixels is None else FrontResiduals.of(pixels, shape, pose, stage)
        if residuals is None:
            return None
        found = least_squares(
            residuals, pose, method="dogbox", x_scale=REACH, bounds=(pose - REACH, pose + REACH),
            xtol=TOLERANCE, ftol=TOLERANCE, gtol=None, max_nfev=MOST_STEPS,
        )  # fmt: skip
        pose = found.x
    return None if residuals is None else FrontFit(pose, residuals)


def front_corners(shape: PalletShape, pose: Array, beside: float = BESIDE) -> Array:
    """Return corners of the front of a pallet.

    Args:
        shape: The pallet.
        pose: (3,) m, m, rad where it stands.
        beside: m beside of it that are taken in.

    Returns:
        (4, 3) m in the frame on the floor.
    """
    c, s, half = np.cos(pose[2]), np.sin(pose[2]), shape.width / 2 + beside
    x, y = pose[:2] + np.array([c, s]) * shape.length / 2
    return np.array([(x - s * v, y + c * v, z) for v in (-half, half) for z in (0.0, shape.height)])


def _step(x: Array) -> Array:
    """A smooth step from 0 to 1."""
    return np.asarray(0.5 * (1.0 + np.tanh(0.85 * x)))
