"""``apc refresh``: update of a roadmap or trajectory database after a change of its cell."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.operations.building import building
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.build_options import jobs_option
from pickcli.commands.options.common_options import cell_option, json_option
from pickcli.commands.options.option_types import PATH
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.precompute.refreshing import Refresh


@click.command("refresh", cls=Command)
@click.argument("path", metavar="FILE", type=PATH)
@cell_option
@arm_option()
@standing_option
@jobs_option
@json_option
def command(
    path: Path, cell_name: str, arm: str | None, standing: tuple[str, ...], jobs: int | None, as_json: bool
) -> None:  # fmt: skip
    """Update a roadmap or trajectory database for a cell that changed.

    Results that the change does not affect are kept; others are proven again, and planned again only if that
    fails. If solids were removed, pairs that failed before, or that hold only for the pod in its place, are
    planned again, too. The same pairs get a motion or an edge as in a new build. FILE is kept until the new
    one is complete; an interrupted refresh continues when the same command is given again. If the robot, its
    limits or its tool changed, everything is done again.

    \b
    Example:
      apc refresh trajectories.h5 --cell apc2016_delft
    """
    from pickcli.precompute.refreshing import refresh
    from pickcli.roadmap.store import surveyed

    cell = open_cell(cell_name, ArmRequest(arm, standing))
    cell.require_places()
    found = surveyed(path, cell)
    if (joints := found.joint_names) != cell.robot.joint_names:
        raise InputError(
            f"{path}: is for a robot with the joints {', '.join(joints)}, {cell_name} has "
            f"{', '.join(cell.robot.joint_names)}; name its own cell with --cell"
        )
    with building(f"refreshing {path.name}", path, jobs, as_json) as run_options:
        done = refresh(path, found, cell, run_options)
    if as_json:
        emit_json(_summary(path, cell.fingerprint, done))
    else:
        click.echo("\n".join(_lines(path, done)))


def _summary(path: Path, fingerprint: str, done: Refresh) -> dict[str, Any]:
    return {
        "path": str(path),
        "cell_fingerprint": fingerprint,
        "changed": list(done.changed),
        "rebuilt_because": done.why_rebuilt or None,
        "stored": done.n_stored,
        "proven_again": done.n_proven,
        "tasks_kept": done.n_kept,
        "tasks_planned": done.n_planned,
    }


def _lines(path: Path, done: Refresh) -> list[str]:
    changed = ", ".join(done.changed) or "nothing that stands around the robot"
    counts = f"{done.n_kept} tasks kept, {done.n_planned} planned"
    if done.why_rebuilt:
        return [f"{path}: everything is done again: {done.why_rebuilt}", counts]
    proven = f"{done.n_proven} of {done.n_stored} touched and proven again"
    return [f"{path}: changed: {changed}", f"{proven}; {counts}"]
