"""Clouds: what a sensor saw of the surroundings, as points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

import numpy as np

from pickcli.errors import InputError
from pickcli.geometry import Array, transform_points

FAR = 100.0  # m from the origin of their frame; beyond it points are in another unit
AROUND = 15.0  # m from there; where half of the points are beyond it, they are too


@dataclass(frozen=True, eq=False)
class Cloud:
    """Points that nothing may touch.

    Attributes:
        file: Where they were read from.
        T_world_sensor: (4, 4) pose of the frame that the file has them in.
        measured: (N, 3) m, in that frame.
        radius: m around each that counts as solid: of what lies between two neighbouring points.
        error: m that any of them may be off.
    """

    file: Path
    T_world_sensor: Array
    measured: Array
    radius: float
    error: float

    def __post_init__(self) -> None:
        """Refuse what are no points around a robot. Raises InputError."""
        if self.measured.ndim != 2 or self.measured.shape[1] != 3 or not len(self.measured):
            raise InputError(f"{self.file}: expected points of shape (N, 3), got {self.measured.shape}")
        is_finite = np.isfinite(self.measured).all(axis=1)
        if not is_finite.all():
            raise InputError(f"{self.file}: {int((~is_finite).sum())} points are not finite; leave them out")
        amounts = np.abs(self.measured).max(axis=1)
        if (farthest := float(amounts.max())) > FAR:
            raise InputError(
                f"{self.file}: reaches {farthest:.4g} m far, expected {FAR:g} at most; lengths are in m, not "
                "mm"
            )
        if (middle := float(np.median(amounts))) > AROUND:
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
        """SHA-256 of the points as they were measured, hexadecimal digits."""
        return sha256(self.measured.tobytes()).hexdigest()
