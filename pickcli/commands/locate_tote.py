"""``apc locate-tote``: where the tote stands, by touching it in simulation."""

from __future__ import annotations

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell
from pickcli.commands.options.artifact_options import artifact_options, load_context
from pickcli.commands.options.common_options import (
    cell_option,
    json_option,
    output_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.option_types import NumberType, refuse_suffix
from pickcli.commands.options.pod_shift import parse_pod_shift

if TYPE_CHECKING:
    from pickcli.calibration.tote_location import LocatedTote
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.geometry import Array


@click.command("locate-tote", cls=Command)
@cell_option
@click.option("--tote-shift", "shift", metavar="X,Y,YAW|random|none", callback=parse_pod_shift,
              help="How far the simulated tote truly stands off its place, in mm, mm and degrees; or random, "
                   "at most 30 mm and 3 degrees.  [default: none]")  # fmt: skip
@click.option("--touches", "n_touches", type=NumberType(6, 10), default=8, show_default=True, metavar="N",
              help="Number of touches, 6 to 10: with six, touches of walls cannot disagree.")  # fmt: skip
@click.option("--tilt", "with_tilt", is_flag=True,
              help="Estimate roll and pitch, too; else the tote stands upright.")  # fmt: skip
@output_option("pose")
@arm_option()
@artifact_options
@seed_option
@json_option
def command(
    cell_name: str, shift: Displacement | str | None, n_touches: int, with_tilt: bool, output: Path,
    arm: str | None, roadmap: Path | None, trajectories: Path | None, seed: int, overwrite: bool,
    as_json: bool,
) -> None:  # fmt: skip
    """Locate the tote by touching its walls and its rim with the cup, in simulation.

    The arm moves to each point by a planned and verified motion, then slowly along a line until the lip of
    the cup feels a force, and back. By the joints at the contacts and the shape of the tote, x, y, z and yaw
    are estimated by least squares, with bounds of the error. Touches that do not fit are refused. The file
    is for apc believe.

    \b
    Example:
      apc locate-tote --cell apc2016_delft --tote-shift 12,-8,1.5 -o tote.json
      apc locate-tote --tote-shift random --touches 10 --tilt --seed 3 -o tote.json --json
    """
    from pickcli.calibration.tote_file import tote_values, write_tote
    from pickcli.calibration.tote_location import (
        LocatingSettings,
        locate_in_simulation,
        shifted_tote,
        tote_offset,
        tote_pose_in_simulation,
    )
    from pickcli.cell.pod_tolerance import UNMOVED

    refuse_output(output, overwrite, cell_name, roadmap, trajectories)
    refuse_suffix(output, (".json",), "the pose of a tote")
    cell = open_cell(cell_name, ArmRequest(arm))
    T_true = tote_pose_in_simulation(cell, shift, seed)
    context = load_context(cell, roadmap, trajectories)
    with stage("touching of the tote"):
        located = locate_in_simulation(context, T_true, LocatingSettings(n_touches, with_tilt), seed)
    write_tote(located, cell, seed, output, overwrite)
    if as_json:
        estimate = located.estimate
        off = tote_offset(estimate.T_world_tote, T_true, estimate.names)
        moved = tote_offset(shifted_tote(cell, UNMOVED), estimate.T_world_tote, estimate.names)
        told = {"displacement": moved, "truly_off": off, "collisions": len(located.collisions)}
        emit_json({**tote_values(located, cell, seed), **told, "path": str(output)})
        return
    for line in _lines(located, shifted_tote(cell, UNMOVED), T_true):
        click.echo(line)
    click.echo(f"tote: {output}")


def _lines(located: LocatedTote, T_nominal: Array, T_true: Array) -> list[str]:
    """Tell where the tote is, within which bounds, by which touches, and how far that is truly off."""
    from pickcli.calibration.tote_location import tote_offset
    from pickcli.commands.output.table import table_lines

    estimate = located.estimate
    moved = tote_offset(T_nominal, estimate.T_world_tote, estimate.names)
    off = tote_offset(estimate.T_world_tote, T_true, estimate.names)
    rows = [
        [name, _told(name, moved[name]), _told(name, bound), _told(name, off[name])]
        for name, bound in zip(estimate.names, estimate.bounds, strict=True)
    ]
    touches = [
        [each.touched.aim.name, f"{each.record.most_force:.1f} N", f"{1e3 * residual:+.2f} mm"]
        for each, residual in zip(located.touches, estimate.residuals, strict=True)
    ]
    n = len(located.collisions)
    contacts = "no unplanned contact" if n == 0 else f"{n} unplanned contact{'s' * (n > 1)}"
    return [
        *table_lines(["tote", "off its place", "within", "truly off"], rows),
        *table_lines(["touch", "most force", "residual"], touches),
        f"{len(located.touches)} touches in {located.duration:.1f} s, {contacts}",
    ]


def _told(name: str, value: float) -> str:
    """A length in mm or an angle in degrees."""
    return f"{1e3 * value:.2f} mm" if name in ("x", "y", "z") else f"{degrees(value):.3f} deg"
