"""``apc record-grasp``: keeps pregrasp, grasp and postgrasp of an item in a file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.common_options import (
    cell_option,
    items_option,
    json_option,
    output_option,
    refuse_output,
)
from pickcli.commands.options.option_types import PATH
from pickcli.errors import InputError, StaleError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.geometry import Array
    from pickcli.grasping.recorded_grasp import RecordedGrasp


def _pose(ctx: click.Context, param: click.Parameter, text: str | None) -> Array | None:
    """Parse X,Y,Z,R,P,Y in mm and degrees; None if not stated. Raises BadParameter for anything else."""
    from pickcli.geometry import pose

    if text is None:
        return None
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 6 or not all(map(math.isfinite, numbers)):
        raise click.BadParameter(f"expected X,Y,Z,ROLL,PITCH,YAW in mm and degrees, got {text!r}", ctx, param)
    x, y, z = (1e-3 * number for number in numbers[:3])
    return pose((x, y, z), rpy=[math.radians(number) for number in numbers[3:]])


@click.command("record-grasp", cls=Command)
@click.option(
    "--plan", "plan_path", type=PATH, metavar="FILE", help="A verified plan, whose grasp is recorded."
)
@click.option("--item", metavar="ITEM", help="The item that a stated grasp is of.")
@click.option("--grasp", metavar="X,Y,Z,R,P,Y", callback=_pose,
              help="Tool frame in the item's: mm, and degrees of roll, pitch and yaw.")  # fmt: skip
@click.option("--pregrasp", metavar="X,Y,Z,R,P,Y", callback=_pose,
              help="Where it comes from.  [default: 100 mm back along its axis]")  # fmt: skip
@click.option("--postgrasp", metavar="X,Y,Z,R,P,Y", callback=_pose,
              help="Where it lifts the item to.  [default: 100 mm back along its axis]")  # fmt: skip
@click.option("--tool-state", metavar="NAME", help="State of the tool for it.  [default: its first]")
@click.option("--add", is_flag=True, help="Add it to the grasps that FILE has already.")
@cell_option
@arm_option()
@standing_option
@items_option
@output_option("file of grasps")
@json_option
def command(
    plan_path: Path | None, item: str | None, grasp: Array | None, pregrasp: Array | None,
    postgrasp: Array | None, tool_state: str | None, add: bool, cell_name: str, arm: str | None,
    standing: tuple[str, ...], items_path: Path | None, output: Path, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Record a grasp of an item: from a verified plan, or as stated.

    A grasp is three poses of the tool in the frame of the item: pregrasp, grasp and postgrasp. apc plan-pick
    --grasps takes its candidates from the file.

    \b
    Example:
      apc record-grasp --plan plan.json -o grasps.json
      apc record-grasp --plan belt.json --cell conveyor_sia20 -o belt_grasps.json
      apc record-grasp --item dove_beauty_bar --grasp 0,0,17,180,0,0 --add -o grasps.json
    """
    from pickcli.grasping.recorded_grasp_file import read_recorded_grasps, write_recorded_grasps

    stated = [item, grasp, pregrasp, postgrasp, tool_state]
    if (plan_path is None) == all(value is None for value in stated):
        raise click.UsageError("name a plan with --plan, or state --item and --grasp; not both")
    if plan_path is None and (item is None or grasp is None):
        raise click.UsageError("a stated grasp needs --item and --grasp")
    refuse_output(output, overwrite or add, plan_path, items_path, cell_name)
    if plan_path is not None:
        cell, found = _of_plan(plan_path, cell_name, ArmRequest(arm, standing, items=items_path))
    else:
        assert item is not None and grasp is not None
        cell = open_cell(cell_name, ArmRequest(arm, standing, items=items_path))
        found = _stated(cell, item, tool_state, (grasp, pregrasp, postgrasp))
    kept = read_recorded_grasps(output, cell) if add and output.exists() else ()
    write_recorded_grasps([*kept, found], cell, output, overwrite or add)
    if as_json:
        emit_json({"path": str(output), "item": found.item, "year": found.year,
                   "tool_state": found.tool_state, "grasps": len(kept) + 1})  # fmt: skip
    else:
        click.echo(
            f"{found.item} of {found.year}, tool {found.tool_state}: grasp {len(kept) + 1} of {output}"
        )


def _of_plan(path: Path, cell_name: str, arms: ArmRequest) -> tuple[Cell, RecordedGrasp]:
    """Return the cell and the grasp of a plan. Raises InputError and StaleError."""
    from pickcli.grasping.recorded_grasp import recorded_from_plan
    from pickcli.motion.plan_file import read_plan

    plan = read_plan(path)
    if arms.arm not in (None, plan.arm):
        raise InputError(f"--arm {arms.arm}: the plan is of {plan.arm or 'the only arm'}; leave --arm out")
    cell = open_cell(cell_name, ArmRequest.of_plan(plan, arms.standing, arms.items))
    if plan.cell_fingerprint != cell.fingerprint:
        raise StaleError(
            f"{path}: its plan ({plan.query}) was made for {_named(plan.cell_fingerprint)}, and this is "
            f"{cell.name}; name the cell of the plan with --cell"
        )
    return cell, recorded_from_plan(plan, cell)


def _named(fingerprint: str) -> str:
    """Name the cell of a fingerprint, if it is one under data/cells."""
    from pickcli.drawing.draw import cell_of

    try:
        return cell_of(fingerprint).name
    except InputError:
        return f"a cell of the fingerprint {fingerprint[:12]}"


def _stated(
    cell: Cell, item: str, tool_state: str | None, poses: tuple[Array, Array | None, Array | None]
) -> RecordedGrasp:
    """Return the grasp that the options state. Raises InputError for an unknown item or state."""
    from dataclasses import replace

    from pickcli.grasping.recorded_grasp import recorded_along_axis

    years = sorted((year for name, year in cell.items if name == item), key=lambda year: (year == 2016, year))
    if not years:
        raise UnknownNameError("item", item, sorted({name for name, _ in cell.items}), "--item")
    states = [state.name for state in cell.robot.tool.states]
    if tool_state is not None and tool_state not in states:
        raise UnknownNameError("state of the tool", tool_state, states, "--tool-state")
    grasp, before, after = poses
    found = recorded_along_axis((item, years[-1]), tool_state or states[0], grasp, "stated")
    return replace(
        found,
        T_item_pregrasp=found.T_item_pregrasp if before is None else before,
        T_item_postgrasp=found.T_item_postgrasp if after is None else after,
    )
