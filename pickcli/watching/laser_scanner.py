"""A laser scanner low at an end of the truck: its figures, and what it measures in one plane."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array


@dataclass(frozen=True)
class LaserScanner:
    """Figures of the scanner. Those of data/watches say where each comes from.

    Attributes:
        forward: m of the scanner before the axle.
        above: m of its plane above the floor.
        angle: rad that a scan covers, half on either side of where it looks.
        resolution: rad between two beams.
        farthest: m that are measured.
        noise: m, standard deviation of ranges.
        period: s between two scans.
        scans: How many scans in a row see something in the field before a brake is requested.
        delay: s from the last of them to the request.
        looks_back: Whether the middle of a scan is along -x of the truck, for drives backwards.
    """

    forward: float
    above: float
    angle: float
    resolution: float
    farthest: float
    noise: float
    period: float
    scans: int
    delay: float
    looks_back: bool = False

    @property
    def longest_response(self) -> float:
        """Time (s) from something entering the field to the request, at most, if every scan sees it."""
        return self.scans * self.period + self.delay

    @cached_property
    def angles(self) -> Array:
        """(B,) rad of the beams to the truck's x."""
        n = int(self.angle / self.resolution / 2)
        middle = np.pi if self.looks_back else 0.0
        return middle + np.arange(-n, n + 1, dtype=float) * self.resolution

    @cached_property
    def directions(self) -> Array:
        """(B, 2) unit vectors of the beams in the frame of the truck."""
        return np.column_stack([np.cos(self.angles), np.sin(self.angles)])

    def ranges(self, pose: Array, segments: Array, discs: Array) -> Array:
        """Return what a scan would measure without noise.

        Args:
            pose: (3,) m, m, rad of the truck.
            segments: (S, 2, 2) m: ends of what stands straight in the plane.
            discs: (D, 3) m: middles and radii of what is round.

        Returns:
            (B,) m, ``farthest`` where nothing is nearer.
        """
        c, s = np.cos(pose[2]), np.sin(pose[2])
        R = np.array([[c, s], [-s, c]])  # row vectors of the truck to those of the floor
        origin, beams = pose[:2] + self.forward * R[0], self.directions @ R
        found = np.full(len(beams), self.farthest)
        if len(segments):
            np.minimum(found, _to_segments(origin, beams, segments), out=found)
        if len(discs):
            np.minimum(found, _to_discs(origin, beams, discs), out=found)
        return found

    def measured(self, ranges: Array, rng: np.random.Generator) -> Array:
        """Add noise to a scan.

        Args:
            ranges: (B,) m without noise.
            rng: Source of the noise.

        Returns:
            (B,) m; what is not measured stays ``farthest``.
        """
        noisy = np.maximum(ranges + self.noise * rng.standard_normal(len(ranges)), 0.0)
        return np.where(ranges < self.farthest, noisy, self.farthest)

    def points(self, ranges: Array) -> Array:
        """Return where ranges end.

        Args:
            ranges: (B,) m.

        Returns:
            (B, 2) m in the frame of the truck.
        """
        places: Array = ranges[:, None] * self.directions
        places[:, 0] += self.forward
        return places


def _to_segments(origin: Array, beams: Array, segments: Array) -> Array:
    """(B,) m along beams to the nearest segment, infinite where none is met."""
    begin, along = segments[:, 0] - origin, segments[:, 1] - segments[:, 0]
    cross = beams[:, None, 0] * along[None, :, 1] - beams[:, None, 1] * along[None, :, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (begin[:, 0] * along[:, 1] - begin[:, 1] * along[:, 0]) / cross
        share = (begin[None, :, 0] * beams[:, None, 1] - begin[None, :, 1] * beams[:, None, 0]) / cross
    is_met = (distance > 0) & (share >= 0) & (share <= 1)
    nearest: Array = np.where(is_met, distance, np.inf).min(axis=1)
    return nearest


def _to_discs(origin: Array, beams: Array, discs: Array) -> Array:
    """(B,) m along beams to the nearest disc, infinite where none is met."""
    off = discs[:, :2] - origin
    along = beams @ off.T
    inside = discs[:, 2] ** 2 - ((off**2).sum(axis=1) - along**2)
    distance = along - np.sqrt(np.maximum(inside, 0.0))
    nearest: Array = np.where((inside > 0) & (distance > 0), distance, np.inf).min(axis=1)
    return nearest
