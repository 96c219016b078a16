"""Schema of stream files: names, types and ranges. See docs/formats/stream.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.files.schema import FileModel, Text
from pickcli.scene.scene_schema import CellReference, NoiseModel, ScenePoseModel

MAX_RIDING = 3_000  # of random items some 0.75 MB; a file may have 1 MB
MAX_TIME = 1e6  # s


class RidingItemModel(ScenePoseModel):
    """One item, with its pose in the frame of the belt."""

    id: Text = Field(description="a name of its own in this stream")
    name: Text = Field(description="an item's name")
    year: int = Field(description="2015 or 2016")
    stamp: Annotated[float, Field(ge=0)] = Field(description="s at which the pose holds")
    noise: NoiseModel | None = Field(default=None, description="bounds of the error of this pose")


class StreamModel(FileModel):
    """A whole stream file."""

    format: Literal["apc stream"] = Field(description="'apc stream'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: CellReference = Field(description="the cell's name and fingerprint")
    conveyor: Text = Field(description="name of a conveyor of the cell")
    speed: Annotated[float, Field(ge=0, le=5)] = Field(description="m/s of the belt along its +x")
    speed_error: Annotated[float, Field(ge=0, le=1)] = Field(0.0, description="m/s, bound of its error")
    noise: NoiseModel = Field(description="bounds of the error of poses")
    one_by_one: bool = Field(
        False, description="whether each item is set on the belt, which stands, when the one before is gone"
    )
    seed: Annotated[int, Field(ge=0, lt=2**63)] = Field(0, description="the seed it was made with")
    items: Annotated[tuple[RidingItemModel, ...], Len(0, MAX_RIDING)] = Field(
        description="the items, by their stamps"
    )
