"""Schema of files of recorded grasps: names, types and ranges. See docs/formats/grasps.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.files.schema import FileModel, Text
from pickcli.scene.scene_schema import ScenePoseModel

MOST_GRASPS = 1000


class RecordedGraspModel(FileModel):
    """One grasp."""

    name: Text = Field(description="an item's name")
    year: int = Field(description="2015 or 2016")
    tool_state: Text = Field(description="name of a state of the tool")
    pregrasp: ScenePoseModel = Field(description="pose of the tool frame in the item's")
    grasp: ScenePoseModel = Field(description="pose of the tool frame in the item's")
    postgrasp: ScenePoseModel = Field(description="pose of the tool frame in the item's at the grasp")
    source: str = Field("", max_length=500, description="where it is from")


class RecordedGraspsModel(FileModel):
    """A whole file of grasps."""

    format: Literal["apc grasps"] = Field(description="'apc grasps'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: Text = Field(description="name of the cell whose tool the poses are of")
    grasps: Annotated[tuple[RecordedGraspModel, ...], Len(1, MOST_GRASPS)] = Field(description="the grasps")
