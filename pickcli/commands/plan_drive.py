"""``apc plan-drive``: how a truck drives from its start to its goal, past everything."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.option_types import PATH
from pickcli.commands.options import json_option, output_option, refuse_output

if TYPE_CHECKING:
    from pickcli.driving.drive_plan import DrivePlan


@click.command("plan-drive", cls=Command)
@click.argument("area_path", metavar="AREA", type=PATH)
@output_option("drive")
@json_option
def command(area_path: Path, output: Path, overwrite: bool, as_json: bool) -> None:
    """Plan how a truck drives from its start to its goal, past everything.

    A path on a lattice is smoothed and timed; the truck is proven to keep the margin of the area all along.
    Exit code 5 when there is no path on the lattice.

    \b
    Example:
      apc plan-drive hall.yaml -o drive.json
    """
    from pickcli.driving.drive_plan import plan_drive
    from pickcli.driving.drive_plan_file import figures, write_drive_plan
    from pickcli.driving.driving_area_file import read_driving_area

    refuse_output(output, overwrite, area_path)
    area = read_driving_area(area_path)
    with stage("planning"):
        plan = plan_drive(area)
    write_drive_plan(output, plan, overwrite)
    if as_json:
        emit_json({"path": str(output), **figures(plan)})
    else:
        click.echo(f"{_text(plan)}: {output}")


def _text(plan: DrivePlan) -> str:
    n = len(plan.path.cusps)
    turned = "no change of direction" if not n else f"{n} change{'s' * (n > 1)} of direction"
    return (
        f"{plan.path.length:.2f} m in {plan.profile.duration:.1f} s, {turned}, at least "
        f"{plan.clearance:.3f} m from everything"
    )
