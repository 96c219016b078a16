"""``apc plan-drive``: how a truck drives from its start to its goal, past everything."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.options.option_types import PATH, refuse_suffix

if TYPE_CHECKING:
    from pickcli.driving.drive_plan import DrivePlan

MOST_DRIVES = 2000


@click.command("plan-drive", cls=Command)
@click.argument("area_path", metavar="AREA", type=PATH)
@click.option("--drives", type=click.IntRange(0, MOST_DRIVES), default=0, show_default=True, metavar="N",
              help="Number of simulated drives with noise, of which the end poses are told.")  # fmt: skip
@click.option("--picture", type=PATH, metavar="FILE",
              help="Draw the drive from above, too, as .svg.")  # fmt: skip
@click.option("--detected", "detected", type=PATH, metavar="FILE.json",
              help="Drive into the pallet where apc detect-pallet saw it, instead of where the area "
                   "expects it.")  # fmt: skip
@output_option("drive")
@seed_option
@json_option
def command(
    area_path: Path,
    drives: int,
    picture: Path | None,
    detected: Path | None,
    output: Path,
    overwrite: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Plan how a truck drives from its start to its goal, past everything.

    A path on a lattice is smoothed and timed; the truck is proven to keep the margin of the area all along.
    In an area with a pallet and no goal it drives into the pallet, the last part straight; simulated drives
    look at the pallet on the way, change the path each time, and are judged by where it truly stands.
    The seed is that of the simulated drives. Exit code 5 when there is no path on the lattice.

    \b
    Example:
      apc plan-drive hall.yaml -o drive.json
      apc plan-drive dock.yaml --detected detected.json --drives 20 -o drive.json
      apc plan-drive hall.yaml --drives 100 --seed 3 --picture drive.svg -o drive.json
    """
    from pickcli.driving.detected_pallet_file import read_detected, with_detected
    from pickcli.driving.drive_plan_file import figures, write_drive_plan
    from pickcli.driving.drive_svg import drive_svg
    from pickcli.driving.driving_area_file import read_driving_area
    from pickcli.driving.pallet_entry import plan_in_area
    from pickcli.driving.simulated_drives import simulate_drives
    from pickcli.driving.simulated_entries import entry_figures, simulate_entries
    from pickcli.files.atomic_write import write_text

    refuse_output(output, overwrite, area_path, detected)
    if picture is not None:
        refuse_suffix(picture, (".svg",), "a picture of a drive")
        refuse_output(picture, overwrite, area_path, detected, output)
    area = read_driving_area(area_path)
    if detected is not None:
        area = with_detected(area, read_detected(detected), area_path)
    with stage("planning"):
        plan = plan_in_area(area)
    write_drive_plan(output, plan, overwrite)
    if picture is not None:
        write_text(picture, drive_svg(plan), overwrite)
    simulated: dict[str, Any] = {}
    if drives:
        with stage("simulated drives"):
            if area.enters:
                simulated = entry_figures(simulate_entries(area, plan, drives, seed))
            else:
                simulated = simulate_drives(plan, drives, seed).figures
    if as_json:
        emit_json({"path": str(output), **figures(plan), **({"drives": simulated} if drives else {})})
        return
    click.echo(f"{_text(plan)}: {output}")
    if drives:
        where = "in the true pallet" if area.enters else "at the goal"
        click.echo(
            f"{simulated['within']} of {drives} simulated drives end {where} within 0.03 m and 1 degree, at "
            f"most {simulated['position_error']:.3f} m and {simulated['yaw_error_deg']:.2f} degrees off; "
            + (
                f"{simulated['renewals']} changes of the path, {simulated['stops']} stops, "
                f"{simulated['given_up']} given up before it"
                if area.enters
                else f"at least {simulated['clearance']:.3f} m from everything"
            )
        )


def _text(plan: DrivePlan) -> str:
    n = len(plan.path.cusps)
    turned = "no change of direction" if not n else f"{n} change{'s' * (n > 1)} of direction"
    return (
        f"{plan.path.length:.2f} m in {plan.profile.duration:.1f} s, {turned}, at least "
        f"{plan.clearance:.3f} m from everything"
    )
