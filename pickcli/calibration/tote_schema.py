"""Schema of files of a located tote. See docs/formats/tote.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.files.schema import FileModel, Text, Vector
from pickcli.scene.scene_schema import MAX_POD_YAW, CellReference, ScenePoseModel

_Metres = Annotated[float, Field(ge=0, le=0.1)]
_Radians = Annotated[float, Field(ge=0, le=MAX_POD_YAW)]


class ToteErrorModel(FileModel):
    """Bounds of the error of the tote's pose in its own frame, each either way."""

    x: _Metres = Field(description="m, 0 to 0.1")
    y: _Metres = Field(description="m, 0 to 0.1")
    z: _Metres = Field(description="m, 0 to 0.1")
    yaw: _Radians = Field(description=f"rad, 0 to {MAX_POD_YAW}")
    roll: _Radians | None = Field(default=None, description=f"rad, 0 to {MAX_POD_YAW}")
    pitch: _Radians | None = Field(default=None, description=f"rad, 0 to {MAX_POD_YAW}")


class TouchModel(FileModel):
    """One touch."""

    name: Text = Field(description="its number and the face that was touched")
    point: Vector = Field(description="a point [x, y, z] in m in the world")
    deviation: float = Field(ge=0, description="m")
    bias: float = Field(ge=0, description="m")
    residual: float = Field(description="m")
    force: float = Field(ge=0, description="N")


class LocatedToteModel(FileModel):
    """A whole file of a located tote."""

    format: Literal["apc tote"] = Field(description="'apc tote'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: CellReference = Field(description="the cell's name and fingerprint")
    pose: ScenePoseModel = Field(description="where the middle of its inner floor is")
    error: ToteErrorModel = Field(description="bounds of the error of that pose")
    covariance: Annotated[tuple[Annotated[tuple[float, ...], Len(4, 6)], ...], Len(4, 6)] = Field(
        description="the covariance of x, y, z, yaw and, if they are estimated, roll and pitch"
    )
    touches: Annotated[tuple[TouchModel, ...], Len(1, 20)] = Field(description="the touches")
    duration: float = Field(ge=0, description="s")
    seed: int = Field(ge=0, lt=2**63, description="the seed it was made with")
