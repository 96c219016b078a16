"""``apc detect-pallet``: where a pallet stands, from one depth picture of the camera on a truck."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import (
    json_option,
    of_file,
    output_option,
    refuse_output,
    refuse_reading,
    seed_option,
)
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.driving.driving_area import DrivingArea


@click.command("detect-pallet", cls=Command)
@click.argument("area_path", metavar="AREA", type=PATH)
@click.option("--at", "at", type=(float, float, float), metavar="X Y YAW",
              help="Where the truck is, m, m and rad.  [default: the start of the area]")  # fmt: skip
@click.option("--recorded", "recorded", type=PATH, metavar="FILE",
              help="Recording of a depth picture that the camera took (.json).  "
                   "[default: simulated in the area, with the noise of the sensor]")  # fmt: skip
@output_option("pose")
@seed_option
@json_option
def command(
    area_path: Path, at: tuple[float, float, float] | None, recorded: Path | None, output: Path,
    overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Find the pallet that an area expects in one depth picture, with bounds of the error.

    The camera of the truck sees the area from where the truck is, with the noise of its sensor, or its
    depth was recorded. Where the pallet stands, anywhere in its tolerance, follows from the picture alone.
    Exit code 3 when there is no pallet, with the reason. The file is for apc plan-drive.

    \b
    Example:
      apc detect-pallet dock.yaml --seed 3 -o detected.json
      apc detect-pallet dock.yaml --at 4.5 2.1 0.1 --json -o detected.json
      apc detect-pallet dock.yaml --recorded look.json -o detected.json
    """
    import numpy as np

    from pickcli.driving.area_view import take_picture
    from pickcli.driving.detected_pallet_file import DetectedPallet, detected_values, write_detected
    from pickcli.driving.driving_area_file import read_driving_area
    from pickcli.driving.pallet_look import look_for_pallet
    from pickcli.driving.truck_recording import recorded_look
    from pickcli.perception.recorded_picture import read_recording

    refuse_output(output, overwrite, area_path, recorded)
    refuse_suffix(output, (".json",), "the pose of a pallet")
    if at is not None and recorded is not None:
        raise click.UsageError("a recording states where the truck was; leave --at out")
    if at is not None and not np.isfinite(at).all():
        raise click.UsageError("--at: expected three finite numbers")
    area = read_driving_area(area_path)
    if at is not None:
        _refuse_pose(at, area)
    recording = None if recorded is None else read_recording(recorded)
    if area.pallet is None or area.camera is None:
        raise InputError(f"{area_path}: states no pallet; add where one is expected")
    if recording is None:
        truck = area.start if at is None else np.array(at)
        with stage("rendering"):
            picture = take_picture(area, area.camera, truck, area.pallet.real, seed)
    else:
        refuse_reading(output, recording.depth)
        picture, truck = recorded_look(recording, area.camera)
    with of_file(area_path if recorded is None else recorded), stage("detection"):
        estimate = look_for_pallet(picture, area.camera, truck, area.pallet)
    found = DetectedPallet.of(estimate, area.camera.model.name, truck)
    write_detected(found, output, overwrite)
    if as_json:
        emit_json({**detected_values(found), "path": str(output), "seed": seed})
        return
    x, y, yaw = found.pose_in_area
    bounds = found.error
    click.echo(
        f"{found.kind} pallet at {x:.3f}, {y:.3f} m and {np.degrees(yaw):.2f} degrees; within "
        f"{1e3 * bounds.x:.1f} mm along, {1e3 * bounds.y:.1f} mm across and {np.degrees(bounds.yaw):.2f} "
        f"degrees; {found.visible:.0%} of its front visible, {1e3 * found.residual:.1f} mm off its plane: "
        f"{output}"
    )


def _refuse_pose(at: tuple[float, float, float], area: DrivingArea) -> None:
    """Raise UsageError for a pose of the truck in other units, or outside of the walls."""
    x, y, yaw = at
    if abs(yaw) > 2 * math.pi:
        raise click.UsageError(f"--at: a yaw of {yaw:g} rad; angles are in rad, not degrees")
    (x0, y0), (x1, y1) = area.low, area.high
    if not (x0 <= x <= x1 and y0 <= y <= y1):
        walls = f"{x0:g} to {x1:g} m in x and {y0:g} to {y1:g} m in y"
        raise click.UsageError(f"--at: {x:g}, {y:g} m is not within the walls, {walls}; lengths are in m")
