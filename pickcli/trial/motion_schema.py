"""Schema of a trial's recorded motion, including checks of array shapes and bounds."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from pickcli.files.packed_array import unpacked
from pickcli.files.schema import FileModel
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind

MAX_TIME = 1e5  # s; a trial takes about a thousand
MAX_JOINT = 1e3  # rad or m
MAX_PRESSURE = 1e6  # Pa
MAX_SHARE = 1e3  # of a limit
MAX_ROWS = 10_000_000

Name = Annotated[str, Field(max_length=200)]
Time = Annotated[float, Field(ge=0.0, le=MAX_TIME)]
Kind = Annotated[SegmentKind, Field(strict=False)]


class PackedModel(FileModel):
    """An array as written by ``packed``."""

    type: Literal["i1", "i2", "i4"]
    shape: Annotated[tuple[Annotated[int, Field(ge=0, le=MAX_ROWS)], ...], Field(min_length=1, max_length=2)]
    unit: Annotated[float, Field(gt=0.0, le=1e6)]
    data: str

    def rows(self, n_columns: int, most: float) -> Array:
        """Return the rows as an array.

        Args:
            n_columns: Required number of columns.
            most: Bound of absolute values.

        Returns:
            (N, n_columns).

        Raises:
            ValueError: The shape is wrong, the number of elements is inconsistent, or a value is too large.
        """
        values = unpacked(self.model_dump())
        if values.ndim != 2 or values.shape[1] != n_columns:
            raise ValueError(f"an array of shape {values.shape}, expected (N, {n_columns})")
        return _bounded(values, most)

    def times(self) -> Array:
        """Return the array as times.

        Returns:
            (N,) s.

        Raises:
            ValueError: It has more than one axis, or decreases.
        """
        values = unpacked(self.model_dump())
        if values.ndim != 1:
            raise ValueError(f"times of shape {values.shape}, expected (N,)")
        if (np.diff(values, prepend=0.0) < 0.0).any():
            raise ValueError("times that fall")
        return _bounded(values, MAX_TIME)


def _bounded(values: Array, most: float) -> Array:
    if (np.abs(values) > most).any():
        raise ValueError(f"a value of {np.abs(values).max():.3g}, at most {most:g} is read")
    return values


class VacuumModel(FileModel):
    """Pressure (Pa) below ambient in the cup, over time."""

    times: PackedModel
    values: PackedModel


class ItemTrackModel(FileModel):
    """Poses of an item over time."""

    id: Name
    times: PackedModel
    poses: PackedModel


class ExecutionModel(FileModel):
    """An execution; segments are kind, start, end, tool state, held item, and names that may be touched."""

    query: Annotated[str, Field(max_length=1000)]
    arm: Name
    t_start: Time
    t_end: Time
    times: PackedModel
    segments: tuple[tuple[Kind, Time, Time, Name, Name | None, tuple[Name, ...]], ...]
    shares: tuple[PackedModel, ...]


class MotionModel(FileModel):
    """The whole file."""

    format: Literal["apc motion"]
    version: Literal[1]
    arms: Annotated[tuple[Name, ...], Field(max_length=100)] = ()
    joints: Annotated[tuple[Name, ...], Field(min_length=1, max_length=100)]
    times: PackedModel
    positions: PackedModel
    vacuum: VacuumModel
    items: tuple[ItemTrackModel, ...]
    executions: tuple[ExecutionModel, ...]
    record: Annotated[str, Field(max_length=64)] = ""
