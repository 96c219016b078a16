"""Point clouds: sensor measurements of the surroundings, as obstacles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

import numpy as np

from pickcli.errors import InputError
from pickcli.geometry import Array, transform_points

MAX_RANGE = 100.0  # m from the sensor; farther points are in another unit
MAX_MEDIAN_RANGE = 15.0  # m from the sensor; if half of the points are farther, all are in another unit


@dataclass(frozen=True, eq=False)
class Cloud:
    """A point cloud, whose points are obstacles.

    Attributes:
        file: The file it was read from.
        T_world_sensor: (4, 4) pose of the sensor frame.
        measured: (N, 3) m, in the sensor frame.
        radius: m around each point that counts as solid, to close the space between neighbouring points.
        error: m, bound of the position error of every point.
    """

    file: Path
    T_world_sensor: Array
    measured: Array
    radius: float
    error: float

    def __post_init__(self) -> None:
        """Validate the points. Raises InputError if they cannot be around a robot."""
        if self.measured.ndim != 2 or self.measured.shape[1] != 3 or not len(self.measured):
            raise InputError(f"{self.file}: expected points of shape (N, 3), got {self.measured.shape}")
        is_finite = np.isfinite(self.measured).all(axis=1)
        if not is_finite.all():
            raise InputError(f"{self.file}: {int((~is_finite).sum())} points are not finite; leave them out")
        amounts = np.abs(self.measured).max(axis=1)
        if (farthest := float(amounts.max())) > MAX_RANGE:
            raise InputError(
                f"{self.file}: reaches {farthest:.4g} m far, expected {MAX_RANGE:g} at most; lengths are in "
                "m, not mm"
            )
        if (middle := float(np.median(amounts))) > MAX_MEDIAN_RANGE:
            raise InputError(
                f"{self.file}: half of the points are over {middle:.4g} m from the sensor, no robot reaches "
                "there; lengths are in m, not mm"
            )

    @cached_property
    def points(self) -> Array:
        """(N, 3) m, in the world."""
        return transform_points(self.T_world_sensor, self.measured)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the measured points, as hexadecimal digits."""
        return sha256(self.measured.tobytes()).hexdigest()
