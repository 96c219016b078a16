"""A horizontal slice of what a depth camera measured, as a laser scanner at its place would scan it.

Team KTH (paper 000, section III-A) makes such a scan of the cloud of a camera at the waist, to find the legs
of the shelf in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture

MOST_PIXELS = 320_000  # of larger pictures every n-th pixel along rows and columns is taken
FINEST = float(np.radians(90.0 / 1000))  # rad, bearings of KTH's scan
STRAY = 0.1  # share of the nearest returns of a bearing that is taken for stray
THICKNESS = 0.025  # m behind the nearest return, in which others are of the same thing
JUMP = 0.03  # m between the ranges of neighbouring bearings, from which on they show different things
GAP = 2  # bearings without a return within a thing


@dataclass(frozen=True)
class ScannedThing:
    """Neighbouring bearings of a scan, at ranges without a jump.

    Attributes:
        bearing: rad, mean of its returns.
        extent: rad, from its first to its last bearing.
        range: m, median.
        n_returns: Number of pixels that show it.
        is_whole: Whether nothing before it, right beside it, may hide a part of it.
    """

    bearing: float
    extent: float
    range: float
    n_returns: int
    is_whole: bool

    @property
    def width(self) -> float:
        """Width across the rays, m."""
        return self.extent * self.range

    @property
    def point(self) -> Array:
        """(2,) its middle, m from the camera; x is at bearing 0."""
        return self.range * np.array([np.cos(self.bearing), np.sin(self.bearing)])


@dataclass(frozen=True, eq=False)
class PlanarScan:
    """What is nearest at each bearing, seen from the camera.

    Attributes:
        step: rad between bearings.
        things: What was scanned, by bearing.
    """

    step: float
    things: tuple[ScannedThing, ...]

    @classmethod
    def of(cls, picture: DepthPicture, T_camera_slice: Array, low: float, high: float) -> PlanarScan:
        """Scan a slice of what a picture shows.

        Args:
            picture: The picture.
            T_camera_slice: (4, 4) frame of the slice in that of the camera: bearings are about its z from its
                x.
            low: m along its z, where the slice begins.
            high: m along its z, where the slice ends.

        Returns:
            The scan; bearings and ranges are from the camera.
        """
        camera = picture.camera
        n = max(1, int(np.ceil(np.sqrt(camera.width * camera.height / MOST_PIXELS))))
        u, v = np.arange(0, camera.width, n), np.arange(0, camera.height, n)
        rays = np.array([(u - camera.cx) / camera.fx, np.zeros(len(u)), np.ones(len(u))])
        depth, down = picture.depth[::n, ::n].astype(np.float64), (v - camera.cy) / camera.fy
        R = T_camera_slice[:3, :3].T
        eye = -R @ T_camera_slice[:3, 3]
        height = eye[2] + depth * ((R[2] @ rays)[None] + (R[2, 1] * down)[:, None])
        rows, columns = np.nonzero((height >= low) & (height <= high))
        beams = (rays[:, columns] + np.array([[0.0], [1.0], [0.0]]) * down[rows]) * depth[rows, columns]
        x, y = (R @ beams)[:2]
        step = max(FINEST, n / camera.fx)
        return cls(step, tuple(_things(np.arctan2(y, x), np.hypot(x, y), step)))


def _things(bearings: Array, ranges: Array, step: float) -> list[ScannedThing]:
    """What returns (N,) at bearings, rad, and ranges, m, are of."""
    if not len(bearings):
        return []
    bins = np.floor(bearings / step).astype(int)
    order = np.lexsort((ranges, bins))
    bearings, ranges, bins = bearings[order], ranges[order], bins[order]
    numbers, first, counts = np.unique(bins, return_index=True, return_counts=True)
    nearest = ranges[first + (STRAY * counts).astype(int)]
    of_bin = np.repeat(np.arange(len(numbers)), counts)
    is_of_it = np.abs(ranges - nearest[of_bin]) <= THICKNESS
    bounds = np.nonzero((np.diff(numbers) > GAP + 1) | (np.abs(np.diff(nearest)) > JUMP))[0] + 1
    firsts, lasts = np.r_[0, bounds], np.r_[bounds, len(numbers)] - 1
    things = []
    for i, j in zip(firsts, lasts, strict=True):
        shows = is_of_it & (of_bin >= i) & (of_bin <= j)
        things.append(_thing(numbers, nearest, int(i), int(j), step, bearings[shows], ranges[shows]))
    return things


def _thing(
    numbers: NDArray[np.int_], nearest: Array, i: int, j: int, step: float, bearings: Array, ranges: Array
) -> ScannedThing:
    """The thing at bins i to j, whose returns (M,) are given."""
    hides = [
        0 <= beside < len(numbers)
        and abs(numbers[beside] - numbers[at]) <= GAP + 1
        and nearest[beside] < nearest[at]
        for at, beside in ((i, i - 1), (j, j + 1))
    ]
    extent = float(numbers[j] - numbers[i] + 1) * step
    return ScannedThing(
        float(bearings.mean()), extent, float(np.median(ranges)), len(ranges), is_whole=not any(hides)
    )
