"""Writes watched drives as JSON. See docs/formats/watch.md."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.steering_path import wrapped
from pickcli.files.atomic_write import write_text
from pickcli.watching.protective_field import ProtectiveField
from pickcli.watching.watched_drive import DECIMALS, WatchedDrive
from pickcli.watching.watched_scene_file import scene_to_dict

SHOWN_EVERY = 5  # periods between poses in a file


def write_watched_drive(path: Path, drive: WatchedDrive, replace: bool = True) -> None:
    """Write a watched drive as JSON.

    Args:
        path: The file.
        drive: The drive.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_text(path, json.dumps(watched_drive_to_dict(drive), indent=1) + "\n", replace)


def watched_drive_to_dict(drive: WatchedDrive) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        drive: The drive.

    Returns:
        Plain values.
    """
    shown = range(0, len(drive.poses), SHOWN_EVERY)
    return {
        "format": "apc watched drive",
        "version": 1,
        "figures": drive.figures(PERIOD),
        "scene": scene_to_dict(drive.scene),
        "poses": [_pose(drive, k) for k in shown],
        "fields": [
            {"time": round(each.time, DECIMALS)} | _field(each.field)
            for each in drive.requests
            if each.field is not None
        ],
        "tracks": [
            {"number": number, "places": np.round(rows, DECIMALS).tolist()}
            for number, rows in drive.tracks.items()
        ],
    }


def _field(field: ProtectiveField) -> dict[str, Any]:
    rounded = {name: round(getattr(field, name), DECIMALS) for name in ("speed", "steering", "stopping")}
    return rounded | {"outline": np.round(field.outline, DECIMALS).tolist()}


def _pose(drive: WatchedDrive, k: int) -> dict[str, Any]:
    x, y, yaw = drive.poses[k]
    row = {"time": k * PERIOD, "x": x, "y": y, "yaw": wrapped(yaw), "speed": drive.speeds[k]}
    plain: dict[str, Any] = {name: round(float(value), DECIMALS) + 0.0 for name, value in row.items()}
    return plain | {"braked": bool(drive.is_braked[k])}
