"""Schema of cell files: names, types and ranges. See docs/formats/cell.md."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

from annotated_types import Len
from pydantic import Field, field_validator, model_validator

from pickcli.cell.checks.cell_warnings import CELL_WARNINGS
from pickcli.cell.device import DeviceKind
from pickcli.cell.schemas.place_schema import MAX_PLACES, PlaceModel
from pickcli.cell.schemas.pose_schema import BoundsModel as BoundsModel
from pickcli.cell.schemas.pose_schema import Name
from pickcli.cell.schemas.pose_schema import PoseModel as PoseModel
from pickcli.cell.schemas.tool_schema import AnyTool, FilePath, GripperModel, SuctionModel, is_of_gripper
from pickcli.files.file_warnings import refuse_unknown_kinds
from pickcli.files.schema import (
    FileModel,
    Force,
    Number,
    Seconds,
    Size,
    Text,
    Thickness,
    not_blank,
)

MAX_OBSTACLES = 2000
MAX_PAIRS = 2000
MAX_CONFIGURATIONS = 1000
MAX_LINKS = 500
MAX_CAMERAS = 50
Part = TypeVar("Part")
LimitOf = Annotated[float, Field(gt=0, allow_inf_nan=False)]
FROM_MAKER: dict[str, Any] = {"advice": "state what the controller allows: its manual or its maker says"}
Joints = Annotated[tuple[Text, ...], Len(1, 32)]
MAX_ARMS = 8


def _not_nothing(part: Part) -> Part:
    if part is None:
        raise ValueError("expected its figures, got nothing; add them, or leave the key out")
    return part


class RobotModel(FileModel):
    """The robot: URDF, base pose, planned joints."""

    urdf: FilePath | None = Field(None, description="the URDF's path, where there is one robot")
    srdf: FilePath | None = Field(
        None, description="the SRDF's path: its disabled collisions are allowed pairs"
    )
    packages: Annotated[dict[Text, FilePath], Len(0, 100)] = Field(
        {}, description="folders by the name that package:// calls them in the URDF"
    )
    T_world_base: PoseModel | None = Field(None, description="where the root link stands")
    joints: Joints = Field((), description="the planned joints, base outwards, where there is one arm")
    tip: Text | None = Field(None, description="the last link of the chain, where the cell has no tool")
    posture: Annotated[dict[Text, Number], Len(0, MAX_LINKS)] = Field(
        {}, description="where the URDF's other joints stand, in rad or m"
    )
    without: Annotated[tuple[Text, ...], Len(0, MAX_LINKS)] = Field(
        (), description="links of the URDF that are not there, with all that hangs on them"
    )
    unshaped: Annotated[tuple[Text, ...], Len(0, MAX_LINKS)] = Field(
        (), description="links that need no collision shape"
    )
    joint_limits: FilePath | None = Field(
        None, description="a ROS joint_limits.yaml, from this file's folder"
    )
    motor_forces: dict[Text, Force] = Field(description="N or Nm by joint, the most that its motor exerts")


class PlacedRobotModel(FileModel):
    """One of several robots: URDF, name prefix, base pose."""

    urdf: FilePath = Field(description="the URDF's path, from this file's folder")
    srdf: FilePath | None = Field(
        None, description="the SRDF's path: its disabled collisions are allowed pairs"
    )
    prefix: Annotated[str, Field(max_length=50, pattern=r"^[A-Za-z0-9_]*$")] = Field(
        "", description="what the cell puts before the names of its links and joints"
    )
    T_world_base: PoseModel = Field(description="where its root link stands")


class JointLimitModel(FileModel):
    """Limits of one joint by the keys of ROS's joint_limits.yaml. All three limits must be stated."""

    min_position: Number | None = Field(None, description="m or rad, narrows the URDF's")
    max_position: Number | None = Field(None, description="m or rad, narrows the URDF's")
    has_velocity_limits: Literal[True] = Field(description="true (no limit is assumed)")
    max_velocity: LimitOf = Field(
        description="a velocity limit in m/s or rad/s", json_schema_extra=FROM_MAKER
    )
    has_acceleration_limits: Literal[True] = Field(description="true (no limit is assumed)")
    max_acceleration: LimitOf = Field(
        description="an acceleration limit in m/s2 or rad/s2", json_schema_extra=FROM_MAKER
    )
    has_jerk_limits: Literal[True] = Field(description="true (no limit is assumed)")
    max_jerk: LimitOf = Field(description="a jerk limit in m/s3 or rad/s3", json_schema_extra=FROM_MAKER)

    @field_validator("min_position", "max_position", mode="before")
    @classmethod
    def _not_forgotten(cls, position: object) -> object:
        return not_blank(position, "m or rad")


class ArmModel(FileModel):
    """One of several arms, or of several tools on one flange: joints, tool and parking configuration."""

    joints: Joints = Field(description="the arm's joints, base outwards")
    tip: Text | None = Field(None, description="the last link of its chain, where it has no tool")
    tool: AnyTool | None = Field(None, description="the tool, if one is mounted")
    parked: Name = Field(description="the configuration in which it stands while another arm moves")
    preference: Annotated[int, Field(ge=1, le=100)] = Field(
        1, description="1 to 100: among arms that can do a thing, the one with the least does it"
    )

    @field_validator("tool")
    @classmethod
    def _not_empty(cls, part: Part) -> Part:
        return _not_nothing(part)


class RowModel(FileModel):
    """One row of bins; heights are above the floor of the hall, at the front of the row."""

    bins: Annotated[tuple[Name, ...], Len(3, 3)] = Field(description="three bin names, left to right")
    lip_top: Size = Field(description="m, top of the bottom lip")
    hanging_lip: Size = Field(description="m, lower edge of the lip of the board above")
    floor_front: Size = Field(description="m, floor just behind the lip")
    ceiling_front: Size = Field(description="m, ceiling just behind the hanging lip")

    @model_validator(mode="after")
    def _ordered(self) -> RowModel:
        heights = (self.floor_front, self.lip_top, self.hanging_lip, self.ceiling_front)
        if list(heights) != sorted(set(heights)):
            raise ValueError(
                "expected floor_front < lip_top < hanging_lip < ceiling_front, "
                f"got {', '.join(map(str, heights))}; correct them"
            )
        return self


class DisplacementModel(FileModel):
    """Displacement bounds of the pod, either way."""

    x: Annotated[float, Field(ge=0, le=0.5)] = Field(0.05, description="m, 0 to 0.5")
    y: Annotated[float, Field(ge=0, le=0.5)] = Field(0.05, description="m, 0 to 0.5")
    yaw: Annotated[float, Field(ge=0, le=0.5)] = Field(0.05235987755982989, description="rad, 0 to 0.5")


class LegsModel(FileModel):
    """The pod's four legs, alike, at the corners of its outside; between them the underside is open."""

    width: Thickness = Field(description="m along y, from the outside inwards")
    depth: Thickness = Field(description="m along x, from the front face and from the back inwards")
    height: Size | None = Field(
        None, description="m, from the floor to where the pod begins; its lowest board if left out"
    )

    @field_validator("height", mode="before")
    @classmethod
    def _not_forgotten(cls, height: object) -> object:
        return not_blank(height, "m")


class PodModel(FileModel):
    """Dimensions of the shelf in the pod frame."""

    T_world_pod: PoseModel = Field(description="where the pod nominally stands")
    displacement: DisplacementModel = Field(
        DisplacementModel(), description="how far it may stand from there"
    )
    width: Size = Field(description="m, outside, along y")
    depth: Size = Field(description="m, outside, along x")
    height: Size = Field(description="m, outside")
    back_wall: Size = Field(description="m, x of the back wall's face")
    side_wall: Size = Field(description="m, |y| of the side walls' insides")
    post: Size = Field(description="m, |y| of the front posts' inner edges")
    post_depth: Thickness = Field(description="m along x")
    divider: Size = Field(description="m, |y| of the dividers' faces towards the middle")
    divider_thickness: Thickness = Field(description="m")
    divider_from: Annotated[float, Field(ge=0, le=10)] = Field(description="m, x where the dividers begin")
    lip_depth: Thickness = Field(description="m along x, front face to the lip's back")
    hanging_lip_depth: Thickness = Field(description="m along x, front face to the hanging lip's back")
    board_thickness: Thickness = Field(description="m")
    floor_slope: Annotated[float, Field(gt=0, lt=0.7)] = Field(description="rad, how steeply the floor drops")
    floor_drop: Thickness = Field(description="m, from just behind the lip to the flat part")
    legs: LegsModel | None = Field(
        None, description="legs under the lowest board; without, solid to the floor"
    )
    rows: Annotated[tuple[RowModel, ...], Len(1, 32)] = Field(description="the rows, from the top")

    @field_validator("legs")
    @classmethod
    def _not_empty(cls, part: Part) -> Part:
        return _not_nothing(part)


class ToteModel(FileModel):
    """The tote, world frame."""

    inner: BoundsModel = Field(description="the clear inside, inner floor to rim")
    wall_thickness: Thickness = Field(description="m")
    flange: BoundsModel = Field(description="the outer edge of the rim")


class ObstacleModel(BoundsModel):
    """A stationary box, in the world frame."""

    name: Name = Field(description="a name of its own")


class DeviceModel(FileModel):
    """A switched device."""

    kind: DeviceKind = Field(description="pump, valve, sensor, tool_actuator or gripper")
    lead: Seconds = Field(description="s from the command to its full effect")
    actions: Annotated[tuple[Text, ...], Len(1, 16)] = Field(description='quoted words, e.g. ["on", "off"]')
    arm: Name | None = Field(None, description="the arm that it belongs to, where the cell has several")
    flow: Annotated[float, Field(ge=1, le=1e5)] | None = Field(
        None, description="l/min of free air that a pump draws, 1 to 100000"
    )

    @model_validator(mode="after")
    def _flow_of_a_pump(self) -> DeviceModel:
        if self.flow is not None and self.kind is not DeviceKind.PUMP:
            raise ValueError(f"expected flow of a pump only, got {self.kind.value}; remove it")
        return self


class MountErrorModel(FileModel):
    """Bounds of the error of a camera's pose."""

    position: Annotated[float, Field(ge=0, le=0.1)] = Field(description="m, 0 to 0.1")
    angle: Annotated[float, Field(ge=0, le=0.2)] = Field(description="rad, 0 to 0.2")


class CameraModel(FileModel):
    """A camera at its place."""

    model: FilePath = Field(
        description="a name under data/sensors, or the path of a file in the cell's folder"
    )
    link: Text | None = Field(
        None, description="the link that it is mounted on, if it is not fixed in the world"
    )
    T_parent_camera: PoseModel = Field(
        description="its pose in the link or the world: x right, y down, z along the optical axis"
    )
    error: MountErrorModel = Field(description="bounds of the error of that pose")


class AllowedPairModel(FileModel):
    """Two bodies that are exempt from collision checks against each other."""

    a: Text = Field(description="a link's name")
    b: Text = Field(description="a link's or an obstacle's name")
    reason: Annotated[str, Field(min_length=10, max_length=1000)] = Field(
        description="why they may touch, in a sentence"
    )
    verified: bool = Field(False, description="true if only planning leaves them out, not the verifier")


class ConfigurationModel(FileModel):
    """A configuration with a name."""

    name: Name = Field(description="a name of its own")
    kind: Literal["home", "bin", "camera", "tote", "drop", "midway", "yardstick"] = Field(
        description="home, bin, camera, tote, drop, midway or yardstick"
    )
    arm: Name | None = Field(None, description="the arm that it is of, where the cell has several")
    tool_state: Name | None = Field(None, description="a state of the tool, the first one by default")
    q: Annotated[tuple[Number, ...], Len(0, 32)] = Field(
        description="one number per planned joint, in their order"
    )


class CellModel(FileModel):
    """A whole cell file."""

    format: Literal["apc cell"] = Field(description="'apc cell'")
    version: Literal[2] = Field(description="2, the only version that is read")
    name: Name = Field(description="the cell's name")
    robot: RobotModel = Field(description="the robot, or what all of several have in common")
    robots: Annotated[dict[Name, PlacedRobotModel], Len(0, MAX_ARMS)] = Field(
        {}, description="the robots by name, where there are several"
    )
    joint_limits: dict[Text, JointLimitModel] = Field(description="limits by planned joint")
    speed_scale: Annotated[float, Field(gt=0, le=1)] = Field(description="a factor in (0, 1]")
    clearance: Annotated[float, Field(ge=0, le=0.1)] = Field(description="m")
    max_tool_speed: Annotated[float, Field(ge=0.01, le=10)] | None = Field(
        None, description="m/s of the tool's tip, 0.01 to 10; none if left out"
    )
    arms: Annotated[dict[Name, ArmModel], Len(0, MAX_ARMS)] = Field(
        {}, description="the arms by name, where there are several"
    )
    tool: SuctionModel | GripperModel | None = Field(None, description="the tool, if one is mounted")
    pod: PodModel | None = Field(None, description="the shelf, if there is one")
    tote: ToteModel | None = Field(None, description="the tote, if there is one")
    places: Annotated[dict[Name, PlaceModel], Len(0, MAX_PLACES)] = Field(
        {}, description="shelves by a grid, boxes, tables and places of bodies, by name"
    )
    obstacles: Annotated[tuple[ObstacleModel, ...], Len(0, MAX_OBSTACLES)] = Field(
        description="boxes that stand still"
    )
    devices: dict[Name, DeviceModel] = Field(description="devices by name")
    sensors: Annotated[dict[Name, CameraModel], Len(0, MAX_CAMERAS)] = Field(
        {}, description="cameras by name"
    )
    allowed_pairs: Annotated[tuple[AllowedPairModel, ...], Len(0, MAX_PAIRS)] = Field(
        description="pairs that may touch"
    )
    configurations: Annotated[tuple[ConfigurationModel, ...], Len(0, MAX_CONFIGURATIONS)] = Field(
        description="named configurations"
    )
    accepted_warnings: Annotated[tuple[Text, ...], Len(0, MAX_CONFIGURATIONS)] = Field(
        (), description="warnings that are meant, as KIND or KIND:SUBJECT"
    )

    @field_validator("accepted_warnings")
    @classmethod
    def _known_kinds(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        refuse_unknown_kinds(names, CELL_WARNINGS)
        return names

    @field_validator("max_tool_speed", mode="before")
    @classmethod
    def _not_forgotten(cls, speed: object) -> object:
        return not_blank(speed, "m/s")

    @field_validator("tool", "pod", "tote")
    @classmethod
    def _not_empty(cls, part: Part) -> Part:
        return _not_nothing(part)

    @property
    def tip(self) -> str:
        """Name of the last link of the chain: the tool's last link, or ``robot.tip`` without a tool."""
        return self.robot.tip or "" if self.tool is None else self.tool.last_link

    @property
    def tool_joint(self) -> str | None:
        """Name of the chain's joint that moves the tool; None without one."""
        return self.tool.joint if isinstance(self.tool, SuctionModel) else None


class SuctionCellModel(CellModel):
    """A cell file with a suction tool or without a tool."""

    tool: SuctionModel | None = Field(None, description="the tool, if one is mounted")


class GripperCellModel(CellModel):
    """A cell file with a parallel gripper."""

    tool: GripperModel | None = Field(None, description="the tool, if one is mounted")


def cell_model(data: Any) -> type[CellModel]:
    """Choose the model of a cell file by the kind of its tool, so that mistakes refer to that kind only.

    Args:
        data: Values of the file, possibly malformed.

    Returns:
        The model.
    """
    tool = data.get("tool") if isinstance(data, dict) else None
    return GripperCellModel if is_of_gripper(tool) else SuctionCellModel
