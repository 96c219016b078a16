"""Verification of a drive, for ``apc verify``."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.errors import RejectedError

if TYPE_CHECKING:
    from pickcli.driving.drive_verification import DriveVerdict


def verify_driven(path: Path, area_path: Path | None, detected: Path | None, as_json: bool) -> None:
    """Verify a drive, and tell the verdict.

    Args:
        path: File of the drive.
        area_path: Its driving area.
        detected: Where the pallet was detected that it leads into, if it was planned for that.
        as_json: Whether the verdict is told as JSON.

    Raises:
        UsageError: No area is named.
        InputError: A file cannot be read.
        RejectedError: The drive has faults.
    """
    from pickcli.driving.detected_pallet_file import read_detected, with_detected
    from pickcli.driving.drive_plan_file import read_drive
    from pickcli.driving.drive_verification import verify_drive
    from pickcli.driving.driving_area_file import read_driving_area

    if area_path is None:
        raise click.UsageError(f"{path} is a plan of a drive: name its driving area with --area")
    area = read_driving_area(area_path)
    if detected is not None:
        area = with_detected(area, read_detected(detected), area_path)
    drive = read_drive(path)
    with stage("verification"):
        verdict = verify_drive(drive, area)
    if as_json:
        figures = {name: value for name, value in asdict(verdict).items() if name != "reasons"}
        emit_json({"path": str(path), "accepted": not verdict.reasons, **figures})
    elif not verdict.reasons:
        click.echo(_text(verdict))
    if verdict.reasons:
        raise RejectedError(str(path), verdict.reasons)


def _text(verdict: DriveVerdict) -> str:
    aside, turned = 1e3 * verdict.position_error, math.degrees(verdict.yaw_error)
    rows = (
        ("accepted", "a drive to the goal"),
        ("clearance", f"at least {verdict.clearance:.3f} m from everything, all along"),
        ("end", f"{aside:.2f} mm and {turned:.3f} degrees off the goal"),
        ("speed", f"{verdict.speed_ratio:.1%} of the limit"),
        ("acceleration", f"{verdict.acceleration_ratio:.1%} of the limit"),
        ("centripetal", f"{verdict.centripetal_ratio:.1%} of the limit"),
        ("steering rate", f"{verdict.steering_rate_ratio:.1%} of the limit"),
    )
    return "\n".join(f"{key:>14}: {value}" for key, value in rows)
