"""Schema of tools in a cell file: suction cups and parallel grippers. See docs/formats/cell.md."""

from __future__ import annotations

from typing import Annotated, Any

from annotated_types import Len
from pydantic import Discriminator, Field, Tag, field_validator

from pickcli.cell.schemas.pose_schema import Name, PoseModel
from pickcli.files.schema import Angle, FileModel, Force, Thickness

MAX_STATES = 32
TOOL_KINDS = ("suction", "gripper")
FilePath = Annotated[str, Field(min_length=1, max_length=500, pattern=r"^[^\x00-\x1f\x7f-\x9f]*$")]
Width = Annotated[float, Field(ge=0, le=0.5)]


class ToolModel(FileModel):
    """Fields of all kinds of tools."""

    kind: str = Field("suction", description="suction or gripper")
    urdf: FilePath | None = Field(None, description="the tool's own URDF, where the robot's has no tool")
    T_flange_tool: PoseModel | None = Field(None, description="where its root link is mounted on the flange")
    flange_link: Name = Field(description="the arm's last own link")

    @field_validator("kind")
    @classmethod
    def _known(cls, kind: str) -> str:
        if kind not in TOOL_KINDS:
            raise ValueError(f"expected {' or '.join(TOOL_KINDS)}, got {kind!r}; correct it")
        return kind


class GripperModel(ToolModel):
    """A parallel gripper."""

    kind: str = Field(description="gripper: these are the keys of one")
    hand_link: Name = Field(description="the link fixed to the flange, which carries the fingers")
    T_hand_tip: PoseModel = Field(
        description="the middle between the pads in the hand's frame: z out of the hand, y as they close"
    )
    fingers: Annotated[tuple[Name, ...], Len(2, 2)] = Field(description="the links of the two fingers")
    states: Annotated[dict[Name, Width], Len(2, MAX_STATES)] = Field(
        description="widths between the pads by state in m, the usual one first"
    )
    pad_size: Annotated[tuple[Thickness, ...], Len(2, 2)] = Field(
        description="m, sides of a pad along x and z of the tool frame"
    )
    pad_gap: Width = Field(0.0, description="m between the pads where both finger joints stand at 0")
    force: Force = Field(description="N with which each pad presses")
    friction: Annotated[float, Field(gt=0, le=2)] = Field(description="friction between pads and items")
    closing_speed: Annotated[float, Field(gt=0, le=2)] = Field(description="m/s at which the width changes")
    contact_speed: Annotated[float, Field(gt=0, le=2)] = Field(description="m/s, fastest final approach")

    @property
    def lance_link(self) -> str:
        """Name of the link fixed to the flange."""
        return self.hand_link

    @property
    def last_link(self) -> str:
        """Name of the link between the pads, which the cell adds to the robot."""
        return f"{self.hand_link}_tip"


class SuctionModel(ToolModel):
    """A suction tool."""

    lance_link: Name = Field(description="the link fixed to the flange")
    cup_link: Name = Field(description="the cup, the chain's last link")
    joint: Name | None = Field(None, description="the joint that changes the tool's state, if one does")
    states: Annotated[dict[Name, Angle], Len(1, MAX_STATES)] | None = Field(
        None, description="positions of that joint by state in rad, or in m if it is prismatic"
    )
    cup_length: Thickness = Field(description="m, origin of its link to the tip of the uncompressed cup")
    cup_radius: Thickness = Field(description="m")
    cup_stroke: Thickness = Field(description="m, how far the bellows compress")
    cup_stiffness: Force = Field(1000.0, description="N/m of the relaxed bellows along the cup's axis")
    cup_tilt: float = Field(ge=0.0, le=0.35, description="rad, how far from square on a face the lip seals")
    max_pull: Force = Field(description="N")
    max_shear: Force = Field(description="N")
    max_moment: Force = Field(description="Nm of bending about the cup")
    max_twist: Force | None = Field(
        None, description="Nm about the cup's axis; two thirds of max_shear times cup_radius unless stated"
    )
    contact_speed: Annotated[float, Field(gt=0, le=2)] = Field(description="m/s, fastest final approach")
    take_up: Thickness = Field(0.0015, description="m of a lift in which the sealed cup takes a weight up")
    take_up_speed: Annotated[float, Field(gt=0, le=2)] = Field(
        0.012, description="m/s, fastest in that stretch where the weight bends the cup"
    )
    seal_time: Annotated[float, Field(ge=0, le=10)] = Field(
        0.25, description="s at rest on an item before it is moved, 0 to 10"
    )

    @property
    def last_link(self) -> str:
        """Name of the last link of the chain."""
        return self.cup_link


def is_of_gripper(tool: Any) -> bool:
    """Whether the values of a tool are those of a gripper; without a known kind, whether it has fingers.

    Args:
        tool: Values of the file, possibly malformed, or a model of a tool.

    Returns:
        True for a gripper.
    """
    kind = tool.get("kind") if isinstance(tool, dict) else getattr(tool, "kind", None)
    return kind == "gripper" or (kind not in TOOL_KINDS and isinstance(tool, dict) and "fingers" in tool)


def _kind_of_tool(tool: Any) -> str:
    return "[gripper]" if is_of_gripper(tool) else "[suction]"


# Discriminated by kind, so that mistakes refer to that kind only.
AnyTool = Annotated[
    Annotated[SuctionModel, Tag("[suction]")] | Annotated[GripperModel, Tag("[gripper]")],
    Discriminator(_kind_of_tool),
]
