"""Reads files of sensors, such as those under data/sensors. See docs/formats/sensor.md."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field, model_validator

from pickcli.cell.data_path import data_path
from pickcli.cell.schemas.pose_schema import Name
from pickcli.cell.sensors.material import Material
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.files.file_kind import SENSOR
from pickcli.files.schema import FileModel, Text, validate
from pickcli.files.yaml_reader import read_yaml

MAX_PIXELS = 5e7  # of a picture, also of the wider one of a second eye
Pixels = Annotated[int, Field(ge=1, le=7_000)]
FocalLength = Annotated[float, Field(gt=0, le=100_000)]
Place = Annotated[float, Field(ge=-10_000, le=20_000)]
Share = Annotated[float, Field(ge=0, le=1)]
Coefficient = Annotated[float, Field(ge=0, le=1)]
Depth = Annotated[float, Field(ge=0.05, le=100)]
Steepness = Annotated[float, Field(ge=0, le=pi / 2)]
Error = Annotated[float, Field(ge=0, le=10)]


class PictureModel(FileModel):
    """Intrinsics of a camera without distortion."""

    width: Pixels = Field(description="px")
    height: Pixels = Field(description="px")
    fx: FocalLength = Field(description="focal length in px")
    fy: FocalLength = Field(description="focal length in px")
    cx: Place = Field(description="column of the principal point, px")
    cy: Place = Field(description="row of the principal point, px")


class AxialModel(FileModel):
    """Standard deviation of depth along the ray."""

    constant: Coefficient = Field(0.0, description="m")
    quadratic: Coefficient = Field(0.0, description="1/m, times the square of (depth - from_depth)")
    from_depth: Annotated[float, Field(ge=0, le=100)] = Field(0.0, description="m")
    oblique: Coefficient = Field(0.0, description="m^1.5")
    oblique_from: Steepness = Field(0.0, description="rad")


class DisparityModel(FileModel):
    """Errors and steps of disparities."""

    error: Error = Field(0.0, description="px, standard deviation")
    step: Error = Field(0.0, description="px, in whole multiples of which they are measured")


class LateralModel(FileModel):
    """Standard deviation of edges along rows and columns."""

    facing: Error = Field(description="px where the surface faces the camera")
    oblique: Error = Field(0.0, description="px, times t / (pi/2 - t)")


class DepthFileModel(FileModel):
    """Depth of a sensor."""

    range: Annotated[tuple[Depth, ...], Len(2, 2)] = Field(description="[nearest, farthest] in m")
    incidence: Annotated[tuple[Steepness, ...], Len(2, 2)] = Field(
        description="[all comes back up to, nothing from], rad to the normal"
    )
    axial: AxialModel = Field(AxialModel(), description="standard deviation along the ray")
    baseline: Annotated[float, Field(gt=0, le=1)] | None = Field(None, description="m to the second eye")
    disparity: DisparityModel | None = Field(None, description="errors and steps of disparities")
    correlation: Annotated[float, Field(ge=0.5, le=2)] | None = Field(
        None, description="px, 0.5 to 2: width of the filter that makes errors of neighbours alike"
    )
    lateral: LateralModel | None = Field(None, description="px by which edges are off")
    mixes_edges: bool = Field(False, description="whether edges get depths between both surfaces")
    no_return: dict[Material, Share] = Field(
        default_factory=dict, description="by material, the share from which nothing comes back"
    )

    @model_validator(mode="after")
    def _ordered(self) -> DepthFileModel:
        for name, (low, high) in (("range", self.range), ("incidence", self.incidence)):
            if not low < high:
                raise ValueError(f"expected {name} as [smaller, larger], got {[low, high]}; swap them")
        if self.disparity is not None and self.baseline is None:
            raise ValueError("expected the baseline of the disparity, got nothing; add baseline")
        return self


class SensorFileModel(FileModel):
    """A whole file of a sensor."""

    format: Literal["apc sensor"] = Field(description="'apc sensor'")
    version: Literal[1] = Field(description="1, the only version there is")
    name: Name = Field(description="the sensor's name")
    picture: PictureModel = Field(description="size and intrinsics of its picture")
    depth: DepthFileModel | None = Field(None, description="how it measures depth, if it does")
    sources: dict[Text, Annotated[str, Field(min_length=3)]] = Field(
        description="where the figures come from, by key: picture, and each key under depth"
    )

    @model_validator(mode="after")
    def _second_eye(self) -> SensorFileModel:
        """The kernel renders what the second eye may see of all depths in range."""
        if self.depth is not None and self.depth.baseline is not None:
            near, far = (self.picture.fx * self.depth.baseline / depth for depth in self.depth.range)
            if (self.picture.width + near - far) * self.picture.height > MAX_PIXELS:
                raise ValueError(
                    f"expected a second eye whose disparities are not as large as {near:.0f} px at "
                    f"{self.depth.range[0]:g} m; correct fx, baseline or range"
                )
        return self

    @model_validator(mode="after")
    def _has_sources(self) -> SensorFileModel:
        stated = [] if self.depth is None else sorted(self.depth.model_fields_set)
        known = ["picture", *stated]
        if lacking := [key for key in known if key not in self.sources]:
            raise ValueError(f"expected a source of {', '.join(lacking)}, got nothing; add it to sources")
        if other := [key for key in self.sources if key not in known]:
            raise ValueError(f"expected sources of {', '.join(known)}, got {', '.join(other)}; remove it")
        return self


def read_sensor(path: Path) -> SensorModel:
    """Read the file of a sensor.

    Args:
        path: The file.

    Returns:
        The model.

    Raises:
        InputError: With every mistake and its position.
    """
    model = validate(read_yaml(path, SENSOR), SensorFileModel)
    camera = PinholeCamera(**model.picture.model_dump())
    depth = None if model.depth is None else _depth(model.depth)
    return SensorModel(model.name, camera, depth, model.sources)


def sensor_names() -> list[str]:
    """Names of the sensors under data/sensors.

    Returns:
        Sorted names.
    """
    return sorted(path.stem for path in _folder().glob("*.yaml"))


def sensor_file(name: str) -> Path:
    """Return the file of a sensor under data/sensors.

    Args:
        name: One of ``sensor_names``.

    Returns:
        Its path.
    """
    return _folder() / f"{name}.yaml"


def _folder() -> Path:
    return data_path() / "sensors"


def _depth(model: DepthFileModel) -> DepthModel:
    axial, disparity, lateral = model.axial, model.disparity or DisparityModel(), model.lateral
    return DepthModel(
        least=model.range[0],
        greatest=model.range[1],
        incidence_from=model.incidence[0],
        incidence_to=model.incidence[1],
        constant=axial.constant,
        quadratic=axial.quadratic,
        from_depth=axial.from_depth,
        oblique=axial.oblique,
        oblique_from=axial.oblique_from,
        baseline=model.baseline or 0.0,
        disparity_error=disparity.error,
        disparity_step=disparity.step,
        correlation=model.correlation or 0.0,
        lateral=0.0 if lateral is None else lateral.facing,
        lateral_oblique=0.0 if lateral is None else lateral.oblique,
        mixes_edges=model.mixes_edges,
        no_return=dict(model.no_return),
    )
