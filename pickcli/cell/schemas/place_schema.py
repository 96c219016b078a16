"""Schema of the carriers that a cell lists under ``places``: grids, boxes, tables, conveyors, bodies."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from pickcli.cell.schemas.pose_schema import BoundsModel, Name, PoseModel
from pickcli.files.schema import Angles, Coordinate, FileModel, Size, Text, Thickness, Vector

MAX_PLACES = 100
MAX_LINES = 32  # rows or columns of a grid
MAX_BODIES = 200
LEVEL_TOLERANCE = 1e-9  # rad of roll and pitch, rounding only
ORIGIN = (0.0, 0.0, 0.0)
Sizes = Annotated[tuple[Size, ...], Len(3, 3)]
Scale = Annotated[tuple[Annotated[float, Field(ge=1e-4, le=1e4)], ...], Len(3, 3)]


class CarrierDisplacementModel(FileModel):
    """Displacement bounds of a carrier, either way."""

    x: Annotated[float, Field(ge=0, le=0.5)] = Field(0.0, description="m, 0 to 0.5")
    y: Annotated[float, Field(ge=0, le=0.5)] = Field(0.0, description="m, 0 to 0.5")
    yaw: Annotated[float, Field(ge=0, le=0.5)] = Field(0.0, description="rad, 0 to 0.5")


class CarrierModel(FileModel):
    """Fields of all kinds of carriers."""

    T_world_place: PoseModel = Field(description="where it nominally stands, upright")
    displacement: CarrierDisplacementModel = Field(
        CarrierDisplacementModel(), description="how far it may stand from there"
    )

    @field_validator("T_world_place")
    @classmethod
    def _upright(cls, T: PoseModel) -> PoseModel:
        if max(abs(T.rpy[0]), abs(T.rpy[1])) > LEVEL_TOLERANCE:
            raise ValueError(
                f"expected roll and pitch of 0, got {T.rpy[0]:g} and {T.rpy[1]:g} rad; it stands "
                "upright, only its yaw is free (a sloped floor: floor_slope of a grid)"
            )
        return T


class LipModel(FileModel):
    """A bar along the front edge of each board of a grid."""

    height: Thickness = Field(description="m over the board")
    depth: Thickness = Field(description="m along x, from the front face inwards")


class GridModel(CarrierModel):
    """A shelf of rows and columns."""

    kind: Literal["grid"] = Field(description="grid")
    rows: Annotated[tuple[Size, ...], Len(1, MAX_LINES)] = Field(
        description="m, clear heights from the top, at the front"
    )
    columns: Annotated[tuple[Size, ...], Len(1, MAX_LINES)] = Field(
        description="m, clear widths from the left"
    )
    depth: Size = Field(description="m, front face to back wall")
    board_thickness: Thickness = Field(description="m, of every board")
    wall_thickness: Thickness | None = Field(
        None, description="m, of sides, dividers and back; board_thickness unless stated"
    )
    lip: LipModel | None = Field(
        None, description="a bar along the front edge of each board, if there is one"
    )
    floor_slope: Annotated[float, Field(ge=0, lt=0.7)] = Field(
        0.0, description="rad, how steeply boards drop to the back"
    )
    names: Annotated[tuple[tuple[Name, ...], ...], Len(1, MAX_LINES)] | None = Field(
        None, description="names of the places, a list for each row; NAME_1_1 and so on unless stated"
    )

    @model_validator(mode="after")
    def _matching(self) -> GridModel:
        if self.names is not None and [len(row) for row in self.names] != [len(self.columns)] * len(
            self.rows
        ):
            wanted = f"{len(self.rows)} lists of {len(self.columns)} names"
            got = ", ".join(str(len(row)) for row in self.names)
            raise ValueError(
                f"expected {wanted}, got lists of {got}; one for each row, a name for each column"
            )
        if self.lip is not None and not self.lip.height < min(self.rows):
            raise ValueError(
                f"expected a lip lower than its row, {min(self.rows):g} m; got {self.lip.height:g}"
            )
        if self.lip is not None and not self.lip.depth < self.depth:
            raise ValueError(
                f"expected a lip less deep than the shelf, {self.depth:g} m; got {self.lip.depth:g}"
            )
        return self


class BoxModel(CarrierModel):
    """A box open above, such as a crate or carton."""

    kind: Literal["box"] = Field(description="box")
    inner: Sizes = Field(description="m, clear inside [x, y, z], z from the inner floor to the rim")
    wall_thickness: Thickness = Field(description="m, of walls and floor")


class TableModel(CarrierModel):
    """A table top without walls."""

    kind: Literal["table"] = Field(description="table")
    size: Sizes = Field(description="m, of the top [x, y, thickness]")
    height: Size = Field(0.5, description="m over the top, in which items count as on it")


class BeltSpeedModel(FileModel):
    """Speeds of a conveyor along its +x."""

    nominal: Annotated[float, Field(ge=0, le=5)] = Field(description="m/s, 0 to 5")
    max: Annotated[float, Field(gt=0, le=5)] = Field(description="m/s, up to 5")
    max_acceleration: Annotated[float, Field(gt=0, le=50)] = Field(description="m/s2, either way")

    @model_validator(mode="after")
    def _nominal_within_max(self) -> BeltSpeedModel:
        if self.nominal > self.max:
            raise ValueError(f"expected nominal up to max, {self.max:g} m/s; got {self.nominal:g}")
        return self


class EncoderModel(FileModel):
    """The encoder of a conveyor."""

    resolution: Annotated[float, Field(gt=0, le=0.01)] = Field(description="m of travel per count")
    latency: Annotated[float, Field(ge=0, le=0.1)] = Field(description="s by which a reading is old")


class ConveyorModel(CarrierModel):
    """A flat belt that carries items along its +x."""

    kind: Literal["conveyor"] = Field(description="conveyor")
    length: Annotated[float, Field(gt=0, le=30)] = Field(description="m, infeed to outfeed, along x")
    width: Size = Field(description="m, along y")
    thickness: Thickness = Field(description="m, of the frame below the running surface")
    height: Size = Field(0.5, description="m over the running surface, in which items count as on it")
    speed: BeltSpeedModel = Field(description="nominal speed and bounds")
    encoder: EncoderModel = Field(description="how its travel is measured")
    window: Annotated[tuple[Coordinate, ...], Len(2, 2)] = Field(
        description="m from the infeed, [first, last] between which items may be picked"
    )

    @field_validator("displacement")
    @classmethod
    def _bolted(cls, displacement: CarrierDisplacementModel) -> CarrierDisplacementModel:
        if (displacement.x, displacement.y, displacement.yaw) != (0.0, 0.0, 0.0):
            raise ValueError("expected none, got some; a conveyor is calibrated, state its pose")
        return displacement

    @model_validator(mode="after")
    def _window_on_it(self) -> ConveyorModel:
        first, last = self.window
        if not 0.0 <= first < last <= self.length:
            raise ValueError(
                f"expected a window within 0 to {self.length:g} m of travel, got {first:g} to {last:g}"
            )
        return self


class PartModel(FileModel):
    """One user-defined body: a box, a cylinder or a mesh."""

    name: Name = Field(description="a name of its own")
    box: Sizes | None = Field(None, description="m, a box [x, y, z]")
    cylinder: Annotated[tuple[Size, ...], Len(2, 2)] | None = Field(
        None, description="m, an upright cylinder [radius, length]"
    )
    mesh: Text | None = Field(None, description="path of an STL, OBJ or COLLADA file in the cell's folder")
    scale: Scale = Field((1.0, 1.0, 1.0), description="factors of a mesh along x, y and z")
    xyz: Vector = Field(ORIGIN, description="a position [x, y, z] in m, of the middle of box or cylinder")
    rpy: Angles = Field(ORIGIN, description="angles [roll, pitch, yaw] in rad")

    @model_validator(mode="after")
    def _one_shape(self) -> PartModel:
        stated = [key for key in ("box", "cylinder", "mesh") if getattr(self, key) is not None]
        if len(stated) != 1:
            got = " and ".join(stated) or "nothing"
            raise ValueError(f"expected one of box, cylinder or mesh, got {got}; a body has one shape")
        return self


class BodiesModel(CarrierModel):
    """A place between user-defined bodies."""

    kind: Literal["bodies"] = Field(description="bodies")
    bodies: Annotated[tuple[PartModel, ...], Len(1, MAX_BODIES)] = Field(description="its bodies")
    room: BoundsModel = Field(description="its free room, z from the floor to ceiling or rim")
    access: Literal["front", "above"] = Field(description="front (along +x) or above (down)")
    lip: Annotated[float, Field(ge=0, le=10)] = Field(
        0.0, description="m over the floor at which the mouth at the front begins"
    )
    walls: bool = Field(True, description="false where nothing keeps items in that are let go from above")
    support: Annotated[tuple[Name, ...], Len(1, MAX_BODIES)] = Field(
        description="names of the bodies that carry items"
    )

    @model_validator(mode="after")
    def _lip_below_top(self) -> BodiesModel:
        height: Coordinate = self.room.upper[2] - self.room.lower[2]
        if not self.lip < height:
            raise ValueError(f"expected a lip lower than the room, {height:g} m; got {self.lip:g}")
        return self


PlaceModel: TypeAlias = Annotated[
    GridModel | BoxModel | TableModel | ConveyorModel | BodiesModel, Field(discriminator="kind")
]
