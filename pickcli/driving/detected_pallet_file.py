"""Reads and writes what a picture from a truck says of a pallet, as JSON. See docs/formats/drive.md."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.pod_tolerance import Displacement
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.pallet_entry import entered_pose, straight_length
from pickcli.driving.steering_path import posed, seen_from, wrapped
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import DETECTED
from pickcli.files.schema import Coordinate, FileModel, Text, validate
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array
from pickcli.perception.pallets.pallet_pose import PalletEstimate

DECIMALS = 6  # of m and rad in files
LEAST_TOLERANCE = np.array([0.05, 0.05, 0.05])  # m, m and rad, as the truck itself is not sure where it is
Pose = Annotated[tuple[Coordinate, ...], Len(3, 3)]
Bound = Annotated[float, Field(gt=0, le=1)]


@dataclass(frozen=True, eq=False)
class DetectedPallet:
    """A pallet as a picture from the truck shows it.

    Attributes:
        kind: Name of its shape.
        sensor: Model of the camera.
        truck: (3,) m, m, rad: where the truck was believed to be, in the area.
        pose: (3,) m, m, rad of the pallet in the frame of the truck.
        error: Bounds of the true pose in the frame of this one.
        residual: m, root of the mean square of distances of the pixels of its front.
        visible: Share of its front that nothing hides.
        n_pixels: Number of pixels of its front.
    """

    kind: str
    sensor: str
    truck: Array
    pose: Array
    error: Displacement
    residual: float
    visible: float
    n_pixels: int

    @classmethod
    def of(cls, estimate: PalletEstimate, sensor: str, truck: Array) -> DetectedPallet:
        """Take what was found in a picture.

        Args:
            estimate: What was found, in the frame of the truck.
            sensor: Model of the camera.
            truck: (3,) m, m, rad: where the truck was believed to be.

        Returns:
            The pallet.
        """
        return cls(
            estimate.shape.name, sensor, truck, estimate.pose, estimate.error, estimate.residual,
            estimate.visible, estimate.n_pixels,
        )  # fmt: skip

    @property
    def pose_in_area(self) -> Array:
        """(3,) m, m, rad of the pallet in the area."""
        x, y, yaw = posed(self.truck, self.pose)
        return np.array([x, y, float(wrapped(yaw))])


class PalletBoundsModel(FileModel):
    """Bounds of the error of a pose, in its own frame."""

    x: Bound = Field(description="m")
    y: Bound = Field(description="m")
    yaw: Bound = Field(description="rad")


class DetectedPalletModel(FileModel):
    """A whole file."""

    format: Literal["apc detected pallet"] = Field(description="'apc detected pallet'")
    version: Literal[1] = Field(description="1, the only version there is")
    kind: Literal["full", "half"] = Field(description="full or half")
    sensor: Text = Field(description="the name of a sensor")
    truck: Pose = Field(description="m, m, rad: where the truck was believed to be in the area")
    in_truck: Pose = Field(description="m, m, rad of the pallet in the frame of the truck")
    in_area: Pose = Field(description="m, m, rad of the pallet in the area")
    error: PalletBoundsModel = Field(description="bounds of the error, in the frame of the pallet")
    residual: Annotated[float, Field(ge=0, le=1)] = Field(description="m, from its front")
    visible: Annotated[float, Field(ge=0, le=1)] = Field(description="share of its front")
    pixels: Annotated[int, Field(ge=0)] = Field(description="number of pixels of its front")


def detected_values(found: DetectedPallet) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        found: The pallet.

    Returns:
        Plain values.
    """
    return {
        "format": "apc detected pallet",
        "version": 1,
        "kind": found.kind,
        "sensor": found.sensor,
        "truck": _rounded(found.truck),
        "in_truck": _rounded(found.pose),
        "in_area": _rounded(found.pose_in_area),
        "error": {name: round(getattr(found.error, name), DECIMALS) for name in ("x", "y", "yaw")},
        "residual": round(found.residual, DECIMALS),
        "visible": round(found.visible, DECIMALS),
        "pixels": found.n_pixels,
    }


def write_detected(found: DetectedPallet, path: Path, may_replace: bool = True) -> None:
    """Write what a picture says of a pallet.

    Args:
        found: The pallet.
        path: The file.
        may_replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_text(path, json.dumps(detected_values(found), indent=1) + "\n", may_replace)


def read_detected(path: Path) -> DetectedPallet:
    """Read what a picture says of a pallet.

    Args:
        path: The file.

    Returns:
        The pallet.

    Raises:
        InputError: With every mistake and its position.
    """
    source = read_yaml(path, DETECTED, is_json=True)
    model = validate(source, DetectedPalletModel)
    found = DetectedPallet(
        model.kind, model.sensor, np.array(model.truck), np.array(model.in_truck),
        Displacement(model.error.x, model.error.y, model.error.yaw), model.residual, model.visible,
        model.pixels,
    )  # fmt: skip
    off = found.pose_in_area - np.array(model.in_area)
    if np.abs([*off[:2], float(wrapped(off[2]))]).max() > 10.0 ** (2 - DECIMALS):
        source.add(("in_area",), "is not in_truck as seen from truck; leave all as they were written")
    source.check()
    return found


def with_detected(area: DrivingArea, found: DetectedPallet, area_path: Path) -> DrivingArea:
    """Expect the pallet of an area where it was seen; the real one stays where it is in simulation.

    Args:
        area: The area.
        found: What was seen.
        area_path: File of the area, for messages.

    Returns:
        The area; the tolerance is the bound of what was seen, at least ``LEAST_TOLERANCE``.

    Raises:
        InputError: The area states a goal or no pallet, or another kind of one, or the pallet was seen
            beyond its tolerance.
    """
    pallet = area.pallet
    if pallet is None or not area.enters:
        raise InputError(f"{area_path}: the drive does not end in a pallet; state one, and leave goal out")
    if pallet.shape.name != found.kind:
        raise InputError(
            f"{area_path}: expects a {pallet.shape.name} pallet, a {found.kind} one was detected"
        )
    off = seen_from(pallet.pose, found.pose_in_area)
    off[2] = wrapped(off[2])
    if (np.abs(off) > pallet.tolerance).any():
        raise InputError(
            f"{area_path}: the pallet was detected {np.hypot(*off[:2]):.2f} m and "
            f"{np.degrees(abs(off[2])):.1f} degrees from where it is expected, beyond its tolerance"
        )
    bounds = np.array([found.error.x, found.error.y, found.error.yaw])
    real = pallet.real[0].pose if pallet.is_there else pallet.pose
    off = seen_from(found.pose_in_area, real)
    seen = replace(
        pallet, pose=found.pose_in_area, off=np.array([*off[:2], float(wrapped(off[2]))]),
        tolerance=np.maximum(bounds, LEAST_TOLERANCE),
    )  # fmt: skip
    inside, straight = entered_pose(area, seen), -straight_length(area, seen)
    return replace(area, pallet=seen, goal=inside, straight=straight)


def _rounded(values: Array) -> list[float]:
    return [round(float(value), DECIMALS) + 0.0 for value in values]
