"""Schema of recordings. See docs/formats/recording.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.files.schema import FileModel, Text

_Row3 = Annotated[tuple[Annotated[float, Field(ge=-1e5, le=1e5)], ...], Len(3, 3)]
_Row4 = Annotated[tuple[Annotated[float, Field(ge=-100, le=100)], ...], Len(4, 4)]
_Pixels = Annotated[int, Field(ge=16, le=8192)]


class RecordingModel(FileModel):
    """A file of a recording."""

    format: Literal["apc recording"] = Field(description='"apc recording"')
    version: Literal[1] = Field(description="1")
    cell: Text = Field(description="the name of a cell")
    camera: Text = Field(description="the name of a camera")
    sensor: Text = Field(description="the name of its model")
    at: Text = Field(description="a configuration of the cell, or joint positions with commas")
    size: Annotated[tuple[_Pixels, ...], Len(2, 2)] = Field(description="width and height, px")
    K: Annotated[tuple[_Row3, ...], Len(3, 3)] = Field(description="a camera matrix, px")
    T_world_camera: Annotated[tuple[_Row4, ...], Len(4, 4)] = Field(
        description="a pose in the world, 4 rows of 4"
    )
    colour: Text = Field(description="a file name")
    depth: Text = Field(description="a file name")
    depth_step: float = Field(ge=1e-6, le=0.01, description="m, of one step of the depth")
