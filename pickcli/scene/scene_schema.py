"""Schema of scene files: names, types and ranges. See docs/formats/scene.md."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from pickcli.cell.schemas.place_schema import MAX_PLACES
from pickcli.files.file_warnings import refuse_unknown_kinds
from pickcli.files.schema import FileModel, Text, Vector
from pickcli.scene.scene_warnings import WARNINGS

Quaternion = Annotated[tuple[Annotated[float, Field(ge=-2, le=2)], ...], Len(4, 4)]
Hash = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]
MAX_ITEMS = 300
MAX_UNKNOWN = 5000  # boxes in one place
# Largest yaw error of a pod. Every wall is swept by it: of twelve targets, seven were planned with up to 0.05
# rad (as many as with 0), five with 0.08, and none with 0.2.
MAX_POD_YAW = 0.05  # rad
POD_YAW = f"rad, 0 to {MAX_POD_YAW}: with more, its walls take the room that picks need"


class ScenePoseModel(FileModel):
    """A pose in the world."""

    position: Vector = Field(description="a position [x, y, z] in m")
    quaternion: Quaternion = Field(description="a unit quaternion [x, y, z, w]")


class CellReference(FileModel):
    """Reference to the scene's cell."""

    name: Annotated[str, Field(max_length=100, pattern=r"^[A-Za-z][A-Za-z0-9_]*$")] = Field(
        description="the cell's name (one under data/cells; of another cell say where it is with --cell)"
    )
    fingerprint: str = Field(pattern=r"^[0-9a-f]{64}$", description="the cell's fingerprint, 64 hex digits")
    devices: Hash | None = Field(default=None, description="hash of its devices, 64 hex digits")
    tool: Hash | None = Field(default=None, description="hash of its tool's load limits, 64 hex digits")
    motors: Hash | None = Field(default=None, description="hash of its motors' efforts and what they move")


class NoiseModel(FileModel):
    """Bounds of the error of item poses."""

    position: Annotated[float, Field(ge=0, le=0.1)] = Field(description="m")
    angle: Annotated[float, Field(ge=0, le=3.2, allow_inf_nan=False)] = Field(description="rad")
    displacement: Annotated[float, Field(ge=0, le=0.5)] | None = Field(
        default=None, description="m, of any point of the surface"
    )

    @model_validator(mode="after")
    def _is_consistent(self) -> NoiseModel:
        if self.displacement is not None and self.displacement < self.position:
            raise ValueError(
                "expected a displacement of at least position: no point of a surface may be off by less than "
                "all that its middle may be; write the bound of the farthest point, or leave it out"
            )
        return self


class PodErrorModel(FileModel):
    """Bounds of the error of a carrier's pose on the floor, each either way."""

    x: Annotated[float, Field(ge=0, le=0.1)] = Field(default=0.0, description="m")
    y: Annotated[float, Field(ge=0, le=0.1)] = Field(default=0.0, description="m")
    yaw: Annotated[float, Field(ge=0, le=MAX_POD_YAW)] = Field(default=0.0, description=POD_YAW)


class CarrierPoseModel(ScenePoseModel):
    """Current pose of a carrier that the cell lists under ``places``."""

    error: PodErrorModel = Field(default=PodErrorModel(), description="bounds of the error of this pose")


class PlacedItemModel(ScenePoseModel):
    """One instance of an item."""

    id: Text = Field(description="a name of its own in this scene")
    name: Text = Field(description="an item's name")
    year: int = Field(description="2015 or 2016")
    location: Text = Field(description="name of a place: of a bin, or 'tote'")
    noise: NoiseModel | None = Field(default=None, description="bounds of the error of this pose")


class HeldModel(ScenePoseModel):
    """The held item, with the pose of its centre in the tool frame."""

    id: Text = Field(description="a name of its own in this scene, or that of the item where it was seen")
    name: Text = Field(description="an item's name")
    year: int = Field(description="2015 or 2016")
    noise: NoiseModel | None = Field(default=None, description="bounds of the error of this pose")


class CloudModel(ScenePoseModel):
    """A point cloud, with the pose of the frame of its points."""

    file: Text = Field(description="a NPY, NPZ or PLY file, from the folder of the scene")
    radius: Annotated[float, Field(ge=0.0005, le=0.1)] = Field(
        description="m, 0.0005 to 0.1, around each point that counts as solid"
    )
    error: Annotated[float, Field(ge=0, le=0.1)] = Field(default=0.0, description="m that a point may be off")


class UnknownSpaceModel(ScenePoseModel):
    """Space of a place of which nothing is known, with the pose of the place as it was seen."""

    place: Text = Field(description="name of a place: of a bin, or 'tote'")
    boxes: Annotated[tuple[tuple[Vector, Vector], ...], Len(0, MAX_UNKNOWN)] = Field(
        description="boxes, each by its lower and its upper corner [x, y, z] in m in the frame of the place"
    )
    unrecognised: Annotated[tuple[tuple[Vector, Vector], ...], Len(0, MAX_UNKNOWN)] = Field(
        default=(), description="boxes alike, in which something is that nobody recognised, or may be"
    )

    @model_validator(mode="after")
    def _has_boxes(self) -> UnknownSpaceModel:
        if not self.boxes and not self.unrecognised:
            raise ValueError("has no boxes; leave it out")
        return self


class SceneModel(FileModel):
    """A whole scene file."""

    format: Literal["apc scene"] = Field(description="'apc scene'")
    version: Literal[1] = Field(description="1, the only version there is")
    cell: CellReference = Field(description="the cell's name and fingerprint")
    T_world_pod: ScenePoseModel | None = Field(
        default=None, description="where the pod stands now, if the cell has one"
    )
    pod_error: PodErrorModel = Field(
        default=PodErrorModel(), description="bounds of the error of the pod's pose"
    )
    places: Annotated[dict[Text, CarrierPoseModel], Len(0, MAX_PLACES)] = Field(
        default={}, description="where places stand, by name, that do not stand where the cell says"
    )
    noise: NoiseModel = Field(description="bounds of the error of poses of items without bounds of their own")
    seed: int = Field(ge=0, lt=2**63, description="the seed it was made with")
    held: HeldModel | None = Field(default=None, description="what is in the cup")
    cloud: CloudModel | None = Field(default=None, description="what a sensor saw besides all this")
    unknown: Annotated[tuple[UnknownSpaceModel, ...], Len(0, MAX_PLACES)] = Field(
        default=(), description="space of which nothing is known, by place"
    )
    items: Annotated[tuple[PlacedItemModel, ...], Len(0, MAX_ITEMS)] = Field(description="the items")
    accepted_warnings: Annotated[tuple[Text, ...], Len(0, MAX_ITEMS)] = Field(
        default=(), description="warnings that are meant, as KIND or KIND:SUBJECT"
    )

    @field_validator("accepted_warnings")
    @classmethod
    def _known_kinds(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        refuse_unknown_kinds(names, WARNINGS)
        return names
