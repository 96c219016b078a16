"""Reads driving areas. See docs/formats/drive.md."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.checks.references import refer
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file, sensor_names
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.driving.driving_area import WALLS, DrivingArea, FloorBox, StatedPallet
from pickcli.driving.forks import Forks
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import entered_pose, straight_length
from pickcli.driving.tricycle import Tricycle
from pickcli.driving.truck_camera import TruckCamera
from pickcli.files.file_kind import DRIVING_AREA
from pickcli.files.schema import Angle, Coordinate, FileModel, Size, Text, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array
from pickcli.perception.pallets.pallet_shape import PALLETS, PalletShape

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
    height: Size = Field(FloorBox.height, description="m, as cameras see it")

    @property
    def box(self) -> FloorBox:
        """The box as a value."""
        (x, y), (length, width) = self.centre, self.size
        return FloorBox(self.name, (x, y), (length, width), self.yaw, self.height)


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


class ForksModel(FileModel):
    """The forks of the truck, lowered."""

    length: Annotated[float, Field(ge=0.2, le=3)] = Field(Forks.length, description="m from heels to tips")
    aside: Annotated[float, Field(ge=0.05, le=1)] = Field(
        Forks.aside, description="m from the middle of the truck to the middle of each"
    )
    width: Annotated[float, Field(ge=0.02, le=0.5)] = Field(Forks.width, description="m of each")
    height: Annotated[float, Field(ge=0.02, le=0.3)] = Field(
        Forks.height, description="m of their upper sides above the floor"
    )


class TruckMountErrorModel(FileModel):
    """Bounds of the error of a camera's pose on the truck."""

    position: Annotated[float, Field(ge=0, le=0.05)] = Field(TruckCamera.error.position, description="m")
    angle: Annotated[float, Field(ge=0, le=0.1)] = Field(TruckCamera.error.angle, description="rad")


class TruckCameraModel(FileModel):
    """A camera of depth on the truck, which looks along its forks."""

    sensor: Text = Field("carmine", description="a name under data/sensors, or a file beside this one")
    position: Annotated[tuple[Coordinate, ...], Len(3, 3)] = Field(
        TruckCamera.position, description="m in the frame of the truck, z above the floor"
    )
    pitch: Annotated[float, Field(ge=-1.5, le=1.5)] = Field(
        TruckCamera.pitch, description="rad by which it looks down"
    )
    error: TruckMountErrorModel = Field(
        TruckMountErrorModel(), description="bounds of the error of that pose"
    )


Off = Annotated[float, Field(ge=-0.5, le=0.5)]  # m or rad


class StatedPalletModel(FileModel):
    """A pallet that is expected."""

    position: Point = Field(description="m, of its middle")
    yaw: Angle = Field(description="rad, of the direction out of the side into which the forks go")
    kind: Literal["full", "half"] = Field("full", description="full for 1.2 x 0.8 m, half for 0.6 x 0.8 m")
    block_height: Annotated[float, Field(ge=0.05, le=0.2)] = Field(
        PalletShape.block_height, description="m of its blocks; 0.114 for a pallet of 0.18 m"
    )
    load: Annotated[float, Field(ge=0, le=2.5)] = Field(0.0, description="m, height of its load")
    tolerance: Annotated[tuple[Annotated[float, Field(gt=0, le=0.5)], ...], Len(3, 3)] = Field(
        (0.1, 0.1, 0.1), description="m, m, rad that the real one may be off along its own axes"
    )
    off: Annotated[tuple[Off, ...], Len(3, 3)] = Field(
        (0.0, 0.0, 0.0), description="m, m, rad that the real one is off, in simulation"
    )
    there: bool = Field(True, description="whether there is a real one, in simulation")

    @property
    def pallet(self) -> StatedPallet:
        """The pallet as a value."""
        shape = replace(PALLETS[self.kind], block_height=self.block_height)
        at = np.array([*self.position, self.yaw])
        return StatedPallet(shape, at, self.load, np.array(self.tolerance), np.array(self.off), self.there)


class DrivingAreaModel(FileModel):
    """A whole file."""

    format: Literal["apc driving area"] = Field(description="'apc driving area'")
    version: Literal[1] = Field(description="1, the only version there is")
    walls: WallsModel = Field(description="the rectangle that the truck stays in")
    boxes: Annotated[tuple[FloorBoxModel, ...], Len(0, MOST_BOXES)] = Field(
        (), description="what stands in it"
    )
    start: TruckPoseModel = Field(description="pose of the truck at the start")
    goal: GoalModel | None = Field(
        None, description="its pose at the end; without it the drive ends in the pallet"
    )
    margin: Annotated[float, Field(ge=0, le=0.5)] = Field(
        DrivingArea.margin, description="m that a plan keeps from walls and boxes"
    )
    truck: TruckModel = Field(TruckModel(), description="figures of the truck")
    forks: ForksModel = Field(ForksModel(), description="figures of its forks")
    camera: TruckCameraModel = Field(TruckCameraModel(), description="its camera")
    pallet: StatedPalletModel | None = Field(None, description="a pallet that is expected")

    def area(self, sensor: SensorModel) -> DrivingArea:
        """Return the area as a value.

        Args:
            sensor: The model of the camera.

        Returns:
            The area.
        """
        low, high, seen = self.walls.low, self.walls.high, self.camera
        x, y, z = seen.position
        error = MountError(seen.error.position, seen.error.angle)
        start, goal, straight = np.array([*self.start.position, self.start.yaw]), np.zeros(3), 0.0
        pallet = None if self.pallet is None else self.pallet.pallet
        if self.goal is not None:
            goal, straight = np.array([*self.goal.position, self.goal.yaw]), self.goal.straight
        area = DrivingArea(
            (low[0], low[1]), (high[0], high[1]), tuple(each.box for each in self.boxes), start, goal,
            straight, self.margin,
            Tricycle(**dict(self.truck)), Forks(**dict(self.forks)),
            TruckCamera(sensor, (x, y, z), seen.pitch, error), pallet, self.goal is None,
        )  # fmt: skip
        if pallet is not None and self.goal is None:
            inside = entered_pose(area, pallet)
            return replace(area, goal=inside, straight=-straight_length(area, pallet))
        return area


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
    names = [each.name for each in model.boxes]
    for i, name in enumerate(names):
        if name in names[:i]:
            source.add(("boxes", i, "name"), f"{name} is the name of another box, too; change one of them")
    source.check()
    if model.goal is None and model.pallet is None:
        source.add((), "expected a goal, or a pallet that the truck drives into, got neither; add one")
    sensor = _sensor(source, model.camera.sensor)
    source.check()
    assert sensor is not None
    area = model.area(sensor)
    occupied = area if area.pallet is None else replace(area, boxes=(*area.boxes, area.pallet.footprint))
    _refuse_near(source, occupied, "start", area.start)
    if not area.enters:
        _refuse_near(source, occupied, "goal", area.goal)
    source.check()
    return area


def _sensor(source: Source, name: str) -> SensorModel | None:
    """The model of a camera of depth; None after noting a mistake."""
    key, is_file = ("camera", "sensor"), name.endswith((".yaml", ".yml"))
    if not is_file and name not in sensor_names():
        refer(source, key, "sensor", name, sensor_names())
        return None
    path = source.path.parent / name if is_file else sensor_file(name)
    if not path.exists():
        source.add(key, f"{name!r}: no such file beside this one; check the name")
        return None
    sensor = read_sensor(path)
    if sensor.depth is None:
        source.add(key, f"{name!r} is a colour camera, which measures no depth; choose another")
        return None
    return sensor


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
