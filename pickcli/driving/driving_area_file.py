"""Reads driving areas. See docs/formats/drive.md."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.driving.driving_area import WALLS, DrivingArea, FloorBox
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.tricycle import Tricycle
from pickcli.files.file_kind import DRIVING_AREA
from pickcli.files.schema import Angle, Coordinate, FileModel, Size, Text, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array

MOST_BOXES = 200
MOST_SIDE = 40.0  # m of the rectangle
DEFAULTS = Tricycle()
Point = Annotated[tuple[Coordinate, ...], Len(2, 2)]
Side = Annotated[float, Field(ge=0.01, le=50)]  # m


class WallsModel(FileModel):
    """The rectangle that the truck stays in."""

    low: Point = Field(description="m, lower corner")
    high: Point = Field(description="m, upper corner")


class FloorBoxModel(FileModel):
    """A box seen from above."""

    name: Text = Field(description="name in messages")
    centre: Point = Field(description="m")
    size: Annotated[tuple[Side, ...], Len(2, 2)] = Field(description="m along its own x and y")
    yaw: Angle = Field(0.0, description="rad")

    @property
    def box(self) -> FloorBox:
        """The box as a value."""
        (x, y), (length, width) = self.centre, self.size
        return FloorBox(self.name, (x, y), (length, width), self.yaw)


class TruckPoseModel(FileModel):
    """A pose of the truck: of the middle of its axle, x towards the steered wheel."""

    position: Point = Field(description="m")
    yaw: Angle = Field(description="rad")


class GoalModel(TruckPoseModel):
    """The pose at the end."""

    straight: Annotated[float, Field(ge=-5, le=5)] = Field(
        0.0, description="m of the straight last part, negative backwards"
    )


class TruckModel(FileModel):
    """Figures of the truck. What is not stated is as of APPLE's."""

    wheel_base: Annotated[float, Field(ge=0.3, le=3)] = Field(DEFAULTS.wheel_base, description="m")
    front: Size = Field(DEFAULTS.front, description="m from the axle to the front end")
    back: Size = Field(DEFAULTS.back, description="m from the axle to the rear end")
    width: Size = Field(DEFAULTS.width, description="m")
    steering: Annotated[float, Field(ge=0.3, le=1.55)] = Field(
        DEFAULTS.steering, description="rad either way, at most"
    )
    steering_rate: Annotated[float, Field(ge=0.05, le=10)] = Field(
        DEFAULTS.steering_rate, description="rad/s, at most"
    )
    speed: Annotated[float, Field(ge=0.05, le=5)] = Field(
        DEFAULTS.speed, description="m/s of the steered wheel, at most"
    )
    acceleration: Annotated[float, Field(ge=0.05, le=5)] = Field(
        DEFAULTS.acceleration, description="m/s^2 of the steered wheel, at most"
    )
    centripetal: Annotated[float, Field(ge=0.05, le=5)] = Field(
        DEFAULTS.centripetal, description="m/s^2, at most"
    )


class DrivingAreaModel(FileModel):
    """A whole file."""

    format: Literal["apc driving area"] = Field(description="'apc driving area'")
    version: Literal[1] = Field(description="1, the only version there is")
    walls: WallsModel = Field(description="the rectangle that the truck stays in")
    boxes: Annotated[tuple[FloorBoxModel, ...], Len(0, MOST_BOXES)] = Field(
        (), description="what stands in it"
    )
    start: TruckPoseModel = Field(description="pose of the truck at the start")
    goal: GoalModel = Field(description="its pose at the end")
    margin: Annotated[float, Field(ge=0, le=0.5)] = Field(
        DrivingArea.margin, description="m that a plan keeps from walls and boxes"
    )
    truck: TruckModel = Field(TruckModel(), description="figures of the truck")

    @property
    def area(self) -> DrivingArea:
        """The area as a value."""
        low, high = self.walls.low, self.walls.high
        start, goal = (np.array([*pose.position, pose.yaw]) for pose in (self.start, self.goal))
        return DrivingArea(
            (low[0], low[1]), (high[0], high[1]), tuple(each.box for each in self.boxes), start, goal,
            self.goal.straight, self.margin, Tricycle(**dict(self.truck)),
        )  # fmt: skip


def read_driving_area(path: Path) -> DrivingArea:
    """Read a driving area.

    Args:
        path: The file, YAML or JSON.

    Returns:
        The area.

    Raises:
        InputError: With every mistake and its position: a start or goal nearer to something than the margin,
            walls without room, and all that the format forbids.
    """
    source = read_yaml(path, DRIVING_AREA)
    model = validate(source, DrivingAreaModel)
    sides = np.array(model.walls.high) - np.array(model.walls.low)
    if sides.min() <= 0:
        source.add(("walls",), "low is not below high in x and y; exchange them")
    elif sides.max() > MOST_SIDE:
        source.add(("walls",), f"{sides.max():g} m from wall to wall, at most {MOST_SIDE:g} m are planned in")
    source.check()
    area = model.area
    for name, pose in (("start", area.start), ("goal", area.goal)):
        _refuse_near(source, area, name, pose)
    source.check()
    return area


def _refuse_near(source: Source, area: DrivingArea, name: str, pose: Array) -> None:
    """Note a pose of the truck that does not keep the margin."""
    found = clearances(area, pose[None])[0]
    nearest = int(found.argmin())
    least, of = float(found[nearest]), WALLS if nearest == 0 else area.boxes[nearest - 1].name
    if least <= 0:
        where = "is not within" if nearest == 0 else "overlaps"
        source.add((name,), f"the truck at the {name} {where} {of}; move one of them")
    elif least < area.margin:
        keep = f"keep the margin of {area.margin:g} m, or state a smaller one"
        source.add((name,), f"the truck at the {name} is {least:.3f} m from {of}; {keep}")
