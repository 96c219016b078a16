"""Reads and writes where a tote was located, as JSON. See docs/formats/tote.md."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.calibration.tote_location import HEIGHT, TOLERANCE, LocatedTote
from pickcli.calibration.tote_schema import LocatedToteModel
from pickcli.calibration.tote_shape import tote_shape
from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement, yaw_of
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import TOTE
from pickcli.files.schema import validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array, inverse
from pickcli.scene.scene import CarrierPose, tote_pose
from pickcli.scene.scene_checks import MAX_LEAN
from pickcli.scene.scene_file import cell_of_file, pose_of_model, pose_values


@dataclass(frozen=True, eq=False)
class StatedTote:
    """Where a file says that the tote stands.

    Attributes:
        T_world_tote: (4, 4) pose of the middle of its inner floor.
        error: Bounds of the error in x, y and yaw, in the tote's frame.
    """

    T_world_tote: Array
    error: Displacement

    def carrier_pose(self, cell: Cell) -> CarrierPose:
        """Return the pose for the carriers of a scene.

        Args:
            cell: The tote's cell.

        Returns:
            The pose.
        """
        return tote_pose(cell, self.T_world_tote, self.error)


def tote_values(located: LocatedTote, cell: Cell, seed: int) -> dict[str, Any]:
    """Convert to JSON values.

    Args:
        located: Where the tote was located.
        cell: The cell.
        seed: The seed it was made with.

    Returns:
        The content of a file.
    """
    estimate = located.estimate
    return {
        "format": "apc tote",
        "version": 1,
        "cell": {"name": cell.name, "fingerprint": cell.scene_fingerprint},
        "pose": pose_values(estimate.T_world_tote),
        "error": {name: float(v) for name, v in zip(estimate.names, estimate.bounds, strict=True)},
        "covariance": estimate.covariance.tolist(),
        "touches": [
            {
                "name": each.touched.aim.name,
                "point": each.touched.point.tolist(),
                "deviation": each.touched.deviation,
                "bias": each.touched.bias,
                "residual": float(residual),
                "force": each.record.most_force,
            }
            for each, residual in zip(located.touches, estimate.residuals, strict=True)
        ],
        "duration": located.duration,
        "seed": seed,
    }


def write_tote(located: LocatedTote, cell: Cell, seed: int, path: Path, replace: bool = True) -> None:
    """Write a file of a located tote atomically.

    Args:
        located: Where the tote was located.
        cell: The cell.
        seed: The seed it was made with.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_text(path, json.dumps(tote_values(located, cell, seed), indent=1) + "\n", replace)


def read_tote(path: Path, cell: Cell) -> StatedTote:
    """Read a file of a located tote.

    Args:
        path: The file.
        cell: Its cell.

    Returns:
        Where the tote stands.

    Raises:
        InputError: The file has mistakes: with every problem.
        StaleError: It was made for another cell.
    """
    source = read_yaml(path, TOTE, is_json=True)
    model = validate(source, LocatedToteModel)
    cell_of_file(source, model.cell, cell, lambda name: cell, "tote")
    T = pose_of_model(source, ("pose",), model.pose)
    source.check()
    error = Displacement(model.error.x, model.error.y, model.error.yaw)
    _refuse_far(source, inverse(tote_shape(cell).T_world_tote) @ T, error, model.error.z)
    source.check()
    return StatedTote(T, error)


def _refuse_far(source: Source, off: Array, error: Displacement, height: float) -> None:
    """Note a pose, in the frame of where the cell says, that no touches can have found."""
    x, y, z = (1e3 * off[:3, 3]).tolist()
    yaw, lean = np.degrees(yaw_of(off)), np.degrees(np.arccos(np.clip(off[2, 2], -1.0, 1.0)))
    if np.radians(lean) > MAX_LEAN:
        source.add(("pose", "quaternion"), f"leans by {lean:.0f} degrees; a tote stands upright")
    limits = (
        ("x", x, 1e3 * (TOLERANCE.x + error.x), "mm"),
        ("y", y, 1e3 * (TOLERANCE.y + error.y), "mm"),
        ("z", z, 1e3 * (HEIGHT + height), "mm"),
        ("yaw", yaw, np.degrees(TOLERANCE.yaw + error.yaw), "degrees"),
    )
    for name, value, most, unit in limits:
        if abs(value) > most:
            told = f"{name} is {value:.1f} {unit} off where the cell says that the tote stands, at most"
            source.add(("pose",), f"{told} {most:.1f} {unit} are located by touch; locate it again")
