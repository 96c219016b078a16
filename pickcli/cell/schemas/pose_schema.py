"""Common schema parts of a cell file: names, poses and axis-aligned boxes."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pickcli.files.schema import Angles, FileModel, Vector
from pickcli.geometry import Array, pose

Name = Annotated[str, Field(min_length=1, max_length=100, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]


class PoseModel(FileModel):
    """A pose: position and fixed-axis roll, pitch, yaw."""

    xyz: Vector = Field(description="a position [x, y, z] in m")
    rpy: Angles = Field(description="angles [roll, pitch, yaw] in rad")

    @property
    def T(self) -> Array:
        """The pose as a matrix (4, 4)."""
        x, y, z = self.xyz
        return pose((x, y, z), rpy=self.rpy)


class BoundsModel(FileModel):
    """An axis-aligned box between two corners."""

    lower: Vector = Field(description="the lower corner [x, y, z] in m")
    upper: Vector = Field(description="the upper corner [x, y, z] in m")

    @model_validator(mode="after")
    def _ordered(self) -> BoundsModel:
        if not all(lo < up for lo, up in zip(self.lower, self.upper, strict=True)):
            raise ValueError(f"expected lower under upper, got {self.lower} and {self.upper}; swap them")
        return self
