"""Reads hands, such as those under data/hands. See docs/formats/hand.md."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field, model_validator

from pickcli.cell.data_path import data_file
from pickcli.cell.schemas.pose_schema import Name
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.files.file_kind import HAND
from pickcli.files.schema import FileModel, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import pose
from pickcli.hand.belt_hand import (
    BeltHand,
    Belts,
    ClosingDrive,
    GraspControl,
    GraspObject,
    HandFingers,
    Palm,
    Wrist,
)

MOST_PARTS = 16
Length = Annotated[float, Field(ge=0.001, le=1)]  # m
Mass = Annotated[float, Field(ge=0.01, le=100)]  # kg
Friction = Annotated[float, Field(ge=0, le=2)]
Duration = Annotated[float, Field(ge=0.01, le=60)]  # s
Current = Annotated[float, Field(gt=0, le=100)]  # A


class HandFingersModel(FileModel):
    """Two fingers of two phalanges."""

    base: Length = Field(description="m between the proximal joints")
    proximal: Length = Field(description="m from the proximal joint to the hinge")
    distal: Length = Field(description="m from the hinge to the tip")
    height: Length = Field(description="m of the pads")
    thickness: Length = Field(description="m from the pad outwards")
    hinge_radius: Length = Field(description="m of the hinge, which no belt covers")
    hinge_relief: Annotated[float, Field(ge=0, le=0.1)] = Field(
        description="m by which it stands out beyond straight pads"
    )
    mass: Mass = Field(description="kg of one phalanx")
    widest: Annotated[float, Field(ge=0.05, le=1.2)] = Field(description="rad, outwards, of open fingers")
    most_bent: Annotated[float, Field(ge=0.05, le=2)] = Field(description="rad, inwards, of a hinge")

    @model_validator(mode="after")
    def _is_sound(self) -> HandFingersModel:
        if self.hinge_relief >= self.hinge_radius:
            raise ValueError(
                f"expected a hinge_relief below the hinge_radius of {self.hinge_radius:g} m, "
                f"got {self.hinge_relief:g}; lower it"
            )
        if min(self.proximal, self.distal) <= 3 * self.hinge_radius:
            raise ValueError(
                f"expected phalanges longer than 3 hinge_radius, {3 * self.hinge_radius:g} m, "
                f"got {min(self.proximal, self.distal):g}; state longer ones or a thinner hinge"
            )
        return self


class PalmModel(FileModel):
    """The palm."""

    depth: Length = Field(description="m along the approach")
    width: Length = Field(description="m from finger to finger")
    height: Length = Field(description="m")
    mass: Mass = Field(description="kg")
    friction: Friction = Field(description="coefficient of palm and hinges")


class ClosingDriveModel(FileModel):
    """The motor that closes both fingers."""

    torque_constant: Annotated[float, Field(ge=0.001, le=100)] = Field(description="Nm at the fingers per A")
    speed: Annotated[float, Field(ge=0.05, le=5)] = Field(description="rad/s")
    inertia: Annotated[float, Field(ge=0.005, le=10)] = Field(description="kg m^2, reflected to the fingers")
    stiffness: Annotated[float, Field(ge=1, le=60)] = Field(description="Nm/rad to each finger")
    damping: Annotated[float, Field(ge=0, le=0.5)] = Field(description="Nm s/rad")
    hinge_ratio: Annotated[float, Field(ge=0.01, le=1)] = Field(
        description="torque on the hinge over that on the proximal joint"
    )
    spring: Annotated[float, Field(ge=0, le=10)] = Field(description="Nm that hold a finger straight")


class BeltsModel(FileModel):
    """The belts."""

    speed: Annotated[float, Field(ge=0.001, le=1)] = Field(description="m/s")
    force: Annotated[float, Field(ge=0, le=1000)] = Field(description="N of one belt's motor")
    friction: Friction = Field(description="coefficient of belts")
    mass: Annotated[float, Field(ge=0.05, le=10)] = Field(
        description="kg of belt and motor, reflected to the belt"
    )
    stiffness: Annotated[float, Field(ge=100, le=5000)] = Field(
        description="N/m of the surface along the pad"
    )
    damping: Annotated[float, Field(ge=0, le=10)] = Field(description="Ns/m")


class WristModel(FileModel):
    """The wrist's impedance."""

    mass: Mass = Field(description="kg of the arm as felt at the hand")
    inertia: Annotated[float, Field(ge=0.005, le=10)] = Field(description="kg m^2 about every axis")
    stiff: Annotated[float, Field(ge=10, le=10000)] = Field(description="N/m while the arm moves")
    level: Annotated[float, Field(ge=1, le=10000)] = Field(
        description="N/m in the horizontal plane during a grasp"
    )
    turning: Annotated[float, Field(ge=1, le=200)] = Field(description="Nm/rad")
    damping: Annotated[float, Field(ge=0.1, le=1)] = Field(description="share of the critical damping")
    most_force: Annotated[float, Field(gt=0, le=10000)] = Field(description="N; beyond it the arm stops")
    most_torque: Annotated[float, Field(gt=0, le=10000)] = Field(description="Nm; beyond it the arm stops")


class GraspControlModel(FileModel):
    """How a grasp is executed."""

    reach: Length = Field(description="m from the palm to the middle of a single object")
    cluster_reach: Length = Field(
        description="m from the palm to the middle of the nearest object of a cluster"
    )
    standing: Annotated[float, Field(gt=0, le=1)] = Field(description="rad/s below which the encoder stands")
    standing_time: Duration = Field(description="s until it counts")
    two_objects: Annotated[float, Field(ge=-1.2, le=1.2)] = Field(
        description="rad; fingers that stand farther open hold two objects"
    )
    separation: Duration = Field(description="s of belts in opposite directions, at most")
    pull_in: Duration = Field(description="s of pulling in, at most")
    firm: Duration = Field(description="s of the higher current before the lift")
    lift: Annotated[float, Field(ge=0.01, le=1)] = Field(description="m")
    lift_time: Duration = Field(description="s")
    hold: Duration = Field(description="s")


class ObjectPartModel(FileModel):
    """A solid of an object, upright."""

    box: Annotated[tuple[Length, ...], Len(3, 3)] | None = Field(None, description="m, full extents")
    cylinder: Annotated[tuple[Length, ...], Len(2, 2)] | None = Field(None, description="m, radius, height")
    z: Annotated[float, Field(ge=0, le=1)] | None = Field(
        None, description="m of its centre; by default it stands on the floor"
    )

    @model_validator(mode="after")
    def _is_one(self) -> ObjectPartModel:
        if (self.box is None) == (self.cylinder is None):
            raise ValueError("expected a box or a cylinder; state one of them")
        return self

    @property
    def body(self) -> Body:
        """The part as a value."""
        if self.box is not None:
            shape = Shape(ShapeKind.BOX, self.box)
        else:
            shape = Shape(ShapeKind.CYLINDER, self.cylinder or ())
        height = float(shape.extents[2])
        return Body("part", shape, pose((0.0, 0.0, height / 2 if self.z is None else self.z)))


class GraspObjectModel(FileModel):
    """An object that is grasped."""

    mass: Mass = Field(description="kg")
    low_current: Current = Field(description="A, with which fingers close on it")
    high_current: Current = Field(description="A, with which they hold it")
    parts: Annotated[tuple[ObjectPartModel, ...], Len(1, MOST_PARTS)] = Field(description="its solids")

    @model_validator(mode="after")
    def _is_sound(self) -> GraspObjectModel:
        if self.high_current < self.low_current:
            raise ValueError(
                f"expected a high_current of at least the low_current of {self.low_current:g} A, "
                f"got {self.high_current:g}; exchange them"
            )
        bottoms = [float(p.body.T_parent_shape[2, 3] - p.body.shape.extents[2] / 2) for p in self.parts]
        if abs(min(bottoms)) > 1e-9:
            raise ValueError(
                f"expected a lowest part that stands on z = 0, got {min(bottoms):g} m; change its z"
            )
        return self


class HandModel(FileModel):
    """A whole file of a hand."""

    format: Literal["apc hand"] = Field(description="'apc hand'")
    version: Literal[1] = Field(description="1, the only version there is")
    name: Name = Field(description="the hand's name")
    fingers: HandFingersModel = Field(description="the fingers")
    palm: PalmModel = Field(description="the palm")
    drive: ClosingDriveModel = Field(description="the motor that closes them")
    belts: BeltsModel = Field(description="the belts")
    wrist: WristModel = Field(description="the wrist's impedance")
    control: GraspControlModel = Field(description="the execution of grasps")
    objects: Annotated[dict[Name, GraspObjectModel], Len(1, 100)] = Field(description="objects by name")

    @property
    def hand(self) -> BeltHand:
        """The hand as a value."""
        return BeltHand(
            self.name, HandFingers(**dict(self.fingers)), Palm(**dict(self.palm)),
            ClosingDrive(**dict(self.drive)), Belts(**dict(self.belts)), Wrist(**dict(self.wrist)),
            GraspControl(**dict(self.control)),
            {
                name: GraspObject(
                    name, each.mass, tuple(part.body for part in each.parts),
                    each.low_current, each.high_current,
                )
                for name, each in self.objects.items()
            },
        )  # fmt: skip


def read_hand(path: Path) -> BeltHand:
    """Read the file of a hand.

    Args:
        path: The file.

    Returns:
        The hand.

    Raises:
        InputError: With every mistake and its position.
    """
    return validate(read_yaml(path, HAND), HandModel).hand


def hand_file(name: str) -> Path:
    """Return the file of a hand.

    Args:
        name: A name under data/hands, or a path.

    Returns:
        The file.

    Raises:
        UnknownNameError: No hand has that name.
    """
    return data_file("hand", "hands", name)
