"""Clouds: what a sensor saw of the surroundings, as points."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from pathlib import Path

from pickcli.geometry import Array, transform_points


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

    @cached_property
    def points(self) -> Array:
        """(N, 3) m, in the world."""
        return transform_points(self.T_world_sensor, self.measured)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the points as they were measured, hexadecimal digits."""
        return sha256(self.measured.tobytes()).hexdigest()
