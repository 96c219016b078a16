"""``apc roll-out``: a controller alone, from a stack of tasks."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.arm_options import ArmRequest, arm_option
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.options.configuration_option import parse_configuration, start_option
from pickcli.commands.options.option_types import FiniteRange, refuse_suffix
from pickcli.commands.options.scene_options import open_scene, scene_options
from pickcli.errors import InputError, NoPlanError, Reason, UnknownNameError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pickcli.cell.cell import Cell
    from pickcli.control.roll_out import RollOut
    from pickcli.control.stack_file import StackFile
    from pickcli.geometry import Array
    from pickcli.grasping.envelope import Envelope
    from pickcli.planning.envelope_roll_outs import EnvelopeRollOut
    from pickcli.planning.item_envelopes import ItemEnvelopes
    from pickcli.planning.planning_context import PlanningContext

N_SHOWN = 10  # about, instants in the table


@click.command("roll-out", cls=Command)
@click.argument("stack_name", metavar="STACK")
@scene_options
@click.option("--item", "item_name", metavar="ITEM", required=True, help="Item to grasp: its id or name.")
@click.option("--envelope", "envelope_name", metavar="NAME",
              help="Envelope of the item (see apc show-envelope).  [default: all]")  # fmt: skip
@start_option
@click.option("--seconds", type=FiniteRange(0.1, 600.0), default=20.0, show_default=True, metavar="S",
              help="Longest duration of a roll-out.")  # fmt: skip
@arm_option()
@seed_option
@output_option("table of all instants, a .csv file")
@json_option
def command(
    stack_name: str, scene_path: Path, cell_name: str | None, items_path: Path | None, item_name: str,
    envelope_name: str | None, start: str, seconds: float, arm: str | None, seed: int,
    output: Path, overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Let a controller bring the tool into an envelope of an item, and show how its tasks fare.

    STACK is a name under data/stacks or a file. Each step is proven free. Where nothing gets better any more,
    the roll-out ends in a local minimum (exit code 5): the level that gave way is told, and whether a region
    query finds a path from there.

    \b
    Example:
      apc roll-out grasp --scene scene.json --item kleenex_tissue_box -o run.csv
    """
    from pickcli.control.stack_file import read_stack, stack_file
    from pickcli.files.atomic_write import write_bytes
    from pickcli.planning.envelope_roll_outs import best_of, roll_out_into
    from pickcli.planning.item_envelopes import ItemEnvelopes
    from pickcli.planning.planning_context import PlanningContext

    refuse_suffix(output, (".csv",), "a table")
    path = stack_file(stack_name)
    refuse_output(output, overwrite, scene_path, cell_name, items_path, path)
    file = read_stack(path)
    if file.model.goal != "envelope":
        goal = f"its goal is {file.model.goal}, as of the stack that plan-pick --approach reactive runs"
        raise InputError(f"{path}: {goal}; state goal: envelope")
    scene = open_scene(scene_path, cell_name, ArmRequest(arm, configurations=(start,), items=items_path))
    context = PlanningContext(scene.cell)
    found = ItemEnvelopes.of(context, scene, scene.find(item_name), scene.cell.robot.tool.default_state)
    q, _ = parse_configuration(scene.cell, start)
    if not found.arm.is_valid(q):
        raise NoPlanError(f"roll-out of {file.name}", [found.arm.explain(q).at("start")])
    chosen = _chosen(found, envelope_name)
    ended = roll_out_into(
        lambda envelope, start, rates: _run(file, context, found, envelope, start, rates, seconds),
        file.model.goal, q, chosen, found.target.T_world_item, found.tool,
    )  # fmt: skip
    best = best_of(ended)
    write_bytes(output, _csv(scene.cell, file, best.run).encode(), overwrite)
    if as_json:
        emit_json(_as_json(file, best, output))
    if not best.is_reached:
        raise _not_reached(context, found, ended, len(chosen), file, seed, output)
    if as_json:
        return
    _print(file, best)
    click.echo(f"wrote {output}: {len(best.run.Q)} instants")


def _chosen(found: ItemEnvelopes, name: str | None) -> tuple[Envelope, ...]:
    if name is None:
        return found.envelopes
    named = tuple(each for each in found.envelopes if each.name == name)
    if not named:
        raise UnknownNameError("envelope", name, [each.name for each in found.envelopes], "--envelope")
    return named


def _run(
    file: StackFile,
    context: PlanningContext,
    found: ItemEnvelopes,
    envelope: Envelope,
    q: Array,
    rates: Array,
    seconds: float,
) -> RollOut:
    from pickcli.control.roll_out import ControlScene, roll_out
    from pickcli.control.stack_file import ControlledArm
    from pickcli.kinematics.arm import ToolGoal

    named = {name: each.q for name, each in context.cell.configurations.items()}
    controlled = ControlledArm(context.arm, found.tool_state, found.arm, named)
    goal = ToolGoal(envelope.constraints, found.target.T_world_item, envelope.T_tip_palm)
    now = ControlScene(file.stack(controlled, goal), found.arm)
    return roll_out(lambda _: now, q, seconds, file.period, rates)


def _not_reached(
    context: PlanningContext,
    found: ItemEnvelopes,
    ended: Sequence[EnvelopeRollOut],
    n_whole: int,
    file: StackFile,
    seed: int,
    output: Path,
) -> NoPlanError:
    """Explain where roll-outs ended, which level gave way, and what a region query finds from there."""
    from pickcli.planning.envelope_roll_outs import best_of

    reasons = []
    for each in ended[:n_whole]:
        run, detail = each.run, f"after {each.run.duration:.2f} s, {file.model.goal} off by {each.left:.3g}"
        if len(run.slack):
            above = next(i for i, names in enumerate(file.task_names) if file.model.goal in names) + 1
            level = int(run.slack[-1, :above].argmax())
            detail += f"; level {level + 1} ({', '.join(file.task_names[level])}) gave way most"
        reasons.append(Reason(run.end.value, each.envelope.name, detail))
    best = best_of(ended)
    if best not in ended[:n_whole]:
        detail = f"after {best.run.duration:.2f} s in all, {file.model.goal} off by {best.left:.3g}"
        where = f"the nearest of all, {best.envelope.name} or part of it"
        reasons.append(Reason(best.run.end.value, where, detail))
    reasons.append(_by_region_query(context, found, best.run, seed))
    more = len(ended) - n_whole
    parts = f", nor any of them or of their free parts in {more} more roll-outs" if more else ""
    lines = [f"none of {n_whole} envelopes is reached{parts}", *(f"  {reason}" for reason in reasons)]
    lines.append(f"  the instants of the nearest one are in {output}")
    return NoPlanError(f"roll-out of {file.name}", reasons, "\n".join(lines))


def _by_region_query(context: PlanningContext, found: ItemEnvelopes, run: RollOut, seed: int) -> Reason:
    from pickcli.planning.region_query import RegionChecks, RegionProblem, plan_to_region

    problem = RegionProblem(found.envelopes, found.target.T_world_item, found.tool_state, run.Q[-1])
    path = plan_to_region(
        context.arm, context.space, problem, RegionChecks(found.tool.are_valid_at, found.arm), seed
    )
    if path is None:
        return Reason("region query from there", "", "no path into any envelope")
    travel = float(abs(path.waypoints[1:] - path.waypoints[:-1]).sum())
    return Reason(
        "region query from there", "", f"a path into an envelope, {travel:.2f} rad or m of joints' ways"
    )


def _csv(cell: Cell, file: StackFile, run: RollOut) -> str:
    """Return rows of t in s, joints in rad or m, errors of tasks, and slack of levels per s."""
    slack = [*run.slack.tolist(), [""] * len(file.task_names)]
    levels = [f"slack_{i + 1}" for i in range(len(file.task_names))]
    lines = [",".join(["t", *cell.robot.joint_names, *(f"error_{name}" for name in run.errors), *levels])]
    for i, q in enumerate(run.Q.tolist()):
        errors = [float(each[i]) for each in run.errors.values()]
        lines.append(",".join(str(value) for value in (round(i * run.period, 6), *q, *errors, *slack[i])))
    return "\n".join(lines) + "\n"


def _as_json(file: StackFile, best: EnvelopeRollOut, output: Path) -> dict[str, object]:
    run = best.run
    return {
        "path": str(output), "stack": file.name, "envelope": best.envelope.name, "end": run.end.value,
        "duration": run.duration, "instants": len(run.Q), "q": run.Q[-1].tolist(),
        "errors": {name: float(each[-1]) for name, each in run.errors.items()},
        "most_slack": run.slack.max(axis=0, initial=0.0).tolist(),
    }  # fmt: skip


def _print(file: StackFile, best: EnvelopeRollOut) -> None:
    from rich.table import Table

    from pickcli.commands.output.table import stdout_console

    run = best.run
    click.echo(f"{file.name}: {best.envelope.name} reached in {run.duration:.2f} s")
    table = Table("t, s", *(f"{name}, off by" for name in run.errors), *(
        f"slack {i + 1}" for i in range(len(file.task_names))
    ))  # fmt: skip
    for i in range(0, len(run.slack), max(1, len(run.slack) // N_SHOWN)):
        errors = (f"{each[i]:.3g}" for each in run.errors.values())
        table.add_row(f"{i * run.period:.2f}", *errors, *(f"{each:.3g}" for each in run.slack[i]))
    stdout_console().print(table)
