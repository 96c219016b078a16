"""Schema of files of perceived items. See docs/formats/perceived.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.files.schema import FileModel, Text, Vector
from pickcli.perception.items.room_sight import LEAST_SEEN
from pickcli.perception.textures.sift_views import SiftViews
from pickcli.scene.scene_schema import NoiseModel

_Quaternion = Annotated[tuple[Annotated[float, Field(ge=-2, le=2)], ...], Len(4, 4)]
_Count = Annotated[int, Field(ge=0)]


class PerceivedPoseModel(FileModel):
    """A pose in the world."""

    position: Vector = Field(description="a position [x, y, z] in m")
    quaternion: _Quaternion = Field(description="a unit quaternion [x, y, z, w]")


class SupportModel(FileModel):
    """How much of the picture speaks for a pose."""

    expected: _Count = Field(description="a number of pixels")
    shown: _Count = Field(description="a number of pixels")
    supported: _Count = Field(description="a number of pixels")
    through: _Count = Field(description="a number of pixels")
    before: _Count = Field(description="a number of pixels")
    gain: float = Field(description="nats")
    margin: float = Field(description="nats")
    colour: float = Field(description="nats")
    own_colour: float = Field(1.0, ge=0, le=1, description="a share")
    position_spread: float = Field(ge=0, description="m")
    angle_spread: float = Field(ge=0, description="rad")
    surface_spread: float = Field(ge=0, description="m")


class RouteModel(FileModel):
    """By what an item was looked for."""

    views: SiftViews | None = Field(description='"all-views", "each-view" or null')
    why: Annotated[str, Field(max_length=200)] = Field(description='why its print was not looked for, or ""')
    twins: Annotated[tuple[Text, ...], Len(0, 300)] = Field(description="a list of names of items")


class PerceivedItemModel(FileModel):
    """The answer for one listed item."""

    id: Text = Field(description="a name of its own")
    name: Text = Field(description="an item's name")
    year: int = Field(description="2015 or 2016")
    pose: PerceivedPoseModel | None = Field(description="a pose in the world, or null")
    found_by: Literal["shape", "print"] = Field("shape", description='"shape" or "print"')
    confidence: float = Field(ge=0, le=1, description="a probability")
    refusal: Annotated[str, Field(max_length=200)] = Field(description='why the pose is not used, or ""')
    bound: NoiseModel | None = Field(description="bounds of the error of the pose, or null")
    support: SupportModel | None = Field(description="counts of pixels, or null")
    route: RouteModel | None = Field(None, description="by what it was looked for, or null")


class UnexplainedModel(FileModel):
    """Points that no answer explains, in the frame of the place."""

    pixels: _Count = Field(description="a number of pixels")
    low: Vector = Field(description="a corner [x, y, z] in m")
    high: Vector = Field(description="a corner [x, y, z] in m")


_Box = tuple[Vector, Vector]


class PlaceErrorModel(FileModel):
    """Bounds of the error of a place's pose on the floor, each either way."""

    x: float = Field(ge=0, le=0.1, description="m")
    y: float = Field(ge=0, le=0.1, description="m")
    yaw: float = Field(ge=0, le=0.05, description="rad")


class PerceivedPlaceModel(FileModel):
    """The answers for one place."""

    place: Text = Field(description="the name of a place")
    pose: PerceivedPoseModel = Field(description="a pose in the world")
    seen: float = Field(ge=LEAST_SEEN, le=1, description="a share of its room")
    items: Annotated[tuple[PerceivedItemModel, ...], Len(0, 300)] = Field(description="a list of answers")
    unexplained: Annotated[tuple[UnexplainedModel, ...], Len(0, 1000)] = Field(description="a list of parts")
    unknown: Annotated[tuple[_Box, ...], Len(0, 5000)] = Field(
        description="boxes, each by its lower and its upper corner in the frame of the place"
    )
    unrecognised: Annotated[tuple[_Box, ...], Len(0, 5000)] = Field(
        default=(), description="boxes alike, in which something is that nobody recognised, or may be"
    )
    error: PlaceErrorModel = Field(description="bounds of the error of the pose")


class LocatedPodErrorModel(FileModel):
    """Bounds of the error of the pose of a located pod: no picture tells it exactly."""

    x: float = Field(gt=0, le=0.1, description="m, above 0")
    y: float = Field(gt=0, le=0.1, description="m, above 0")
    yaw: float = Field(gt=0, le=0.05, description="rad, above 0")


class LocatedPodModel(FileModel):
    """Where the pod stands, as a picture says."""

    pose: PerceivedPoseModel = Field(description="a pose in the world")
    error: LocatedPodErrorModel = Field(description="bounds of the error of the pose")
    front_error: float = Field(gt=0, le=0.2, description="m, above 0")
    explained: float = Field(ge=0, le=1, description="a share")
    pixels: int = Field(ge=1, description="a number of pixels, above 0")
    start: Literal["legs", "boxes"] | None = Field(None, description='"legs" or "boxes"')


class PerceptionVersionsModel(FileModel):
    """What shaped the bytes of the answers."""

    versions: Annotated[dict[Text, Text], Len(0, 100)] = Field(description="versions of packages by name")


class PerceivedModel(FileModel):
    """A file of perceived items."""

    format: Literal["apc perceived"] = Field(description='"apc perceived"')
    version: Literal[1] = Field(description="1")
    cell: Text = Field(description="the name of a cell")
    camera: Text = Field(description="the name of a camera")
    sensor: Text = Field(description="the name of its model")
    camera_pose: PerceivedPoseModel = Field(description="a pose in the world")
    also_from: Annotated[tuple[PerceivedPoseModel, ...], Len(0, 100)] = Field(
        default=(), description="poses of the camera in further pictures"
    )
    places: Annotated[tuple[PerceivedPlaceModel, ...], Len(0, 100)] = Field(description="a list of places")
    pod: LocatedPodModel | None = Field(None, description="where the pod stands, if it was located")
    made_from: PerceptionVersionsModel | None = Field(None, description="what it was made from")
