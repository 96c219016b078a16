"""What may stand in a scene file: names, types and ranges. See docs/formats/scene.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.cell.validate import FileModel, NotNegative, Number, Vector

Quaternion = Annotated[tuple[Number, ...], Len(4, 4)]


class PoseModel(FileModel):
    """A pose in the world."""

    position: Vector = Field(description="a position [x, y, z] in m")
    quaternion: Quaternion = Field(description="a unit quaternion [x, y, z, w]")


class CellReference(FileModel):
    """The cell that the scene belongs to."""

    name: str = Field(min_length=1, description="the cell's name")
    fingerprint: str = Field(pattern=r"^[0-9a-f]{64}$", description="the cell's fingerprint, 64 hex digits")


class NoiseModel(FileModel):
    """Bounds of the error of the item poses."""

    position: NotNegative = Field(description="m")
    angle: Annotated[float, Field(ge=0, le=3.2, allow_inf_nan=False)] = Field(description="rad")


class PlacedItemModel(PoseModel):
    """One instance of an item."""

    id: str = Field(min_length=1, description="a name of its own in this scene")
    name: str = Field(min_length=1, description="an item's name")
    year: int = Field(description="2015 or 2016")
    location: str = Field(min_length=1, description="a bin's name, or 'tote'")


class SceneModel(FileModel):
    """A whole scene file."""

    format: Literal["apc scene"] = Field(description="'apc scene'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: CellReference = Field(description="the cell's name and fingerprint")
    T_world_pod: PoseModel = Field(description="where the pod stands now")
    noise: NoiseModel = Field(description="bounds of the error of the item poses")
    seed: int = Field(ge=0, description="the seed it was made with")
    items: tuple[PlacedItemModel, ...] = Field(description="the items")
