"""``apc check``: mistakes in hand-written files, and damage in stored ones with its repair."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.building import building
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.build_options import jobs_option
from pickcli.commands.options.common_options import (
    CELL_HELP,
    DEFAULT_CELL,
    items_option,
    json_option,
    overwrite_option,
    refuse_missing,
)
from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.commands.output.checked_texts import (
    CheckOptions,
    check_text,
    kind_of_text,
    refuse_options_of_cells,
    refuse_picture,
)
from pickcli.errors import DamagedError
from pickcli.files.file_kind import ORDER, PERCEIVED, SCENE

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.precompute.repair import Repair
    from pickcli.storage.integrity_scan import IntegrityReport

MOST_LINES = 20  # damaged blocks that are listed in the text output


@click.command("check", cls=Command)
@click.argument("path", metavar="FILE", type=PATH)
@click.option("--strict", is_flag=True, help="Treat warnings as mistakes: exit code 3.")
@click.option("--picture", type=PATH, metavar="FILE",
              help="For a cell, also draw what its arm reaches: .png, or .html to rotate.")  # fmt: skip
@overwrite_option
@click.option("--poses", type=NumberType(1, 10000), default=60, show_default=True,
              help="Tool poses by which each place of a cell is judged.")  # fmt: skip
@click.option("--repair", "is_repair", is_flag=True, help="Recompute only what is lost.")
@click.option("--cell", "cell_name", metavar="NAME|FOLDER",
              help=f"{CELL_HELP}  [default: the one that FILE names, else {DEFAULT_CELL}]")  # fmt: skip
@items_option
@arm_option()
@standing_option
@jobs_option
@json_option
def command(
    path: Path, strict: bool, picture: Path | None, overwrite: bool, poses: int, is_repair: bool,
    cell_name: str | None, items_path: Path | None, arm: str | None, standing: tuple[str, ...],
    jobs: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Find mistakes in a cell, scene, order, driving area or items, or damage in a stored file.

    For a cell (its name, folder or cell.yaml) everything is read, and it is checked whether its named
    configurations are free, and how much of each place the arm reaches. Mistakes end with exit code 3; what
    may be intended is a warning, which --strict treats as a mistake. For a stored file every damaged block is
    listed, with what is lost. With --repair intact parts are kept and the rest is computed again, for the
    same cell. Exit code 4 if damage is left.

    \b
    Example:
      apc check trajectories.h5 --repair
      apc check my_robot --strict --picture reach.png
      apc check scene.json
    """
    from pickcli.cell.data_path import task_file, task_names

    path = task_file(path)
    refuse_missing(path, (".h5", ".json", ".yaml"), task_names())
    arms, kind = ArmRequest(arm, standing, items=items_path), kind_of_text(path)
    if items_path is not None and kind not in (SCENE, ORDER, PERCEIVED):
        raise click.UsageError("--items is for scenes, orders and perceived items; leave it out")
    if kind is None:
        refuse_options_of_cells(strict, picture)
        cell = open_cell(cell_name or DEFAULT_CELL, arms)
        _check_stored(path, cell, is_repair, jobs, as_json)
        return
    if is_repair:
        raise click.UsageError("--repair is for roadmaps and trajectory databases; edit this file instead")
    if picture is not None:
        refuse_picture(kind, picture, overwrite, path, cell_name)
    check_text(path, kind, CheckOptions(cell_name, arms, strict, poses, picture, overwrite, as_json))


def _check_stored(path: Path, cell: Cell, is_repair: bool, jobs: int | None, as_json: bool) -> None:
    """Scan every byte of a roadmap or trajectory database. Raises DamagedError if damage is left."""
    from pickcli.roadmap.store import describe, surveyed

    with stage("reading of every byte"):
        found = surveyed(path, cell)
    done = None
    if found.damage and is_repair:
        done = _repaired(path, found, cell, jobs, as_json)
    if done is not None or not found.damage:
        describe(path)
    if as_json:
        emit_json(_summary(path, found, done))
    else:
        click.echo("\n".join(_lines(path, found, done)))
    if found.damage and done is None:
        what = found.cut_off or f"damaged in {_places(len(found.damage))}"
        raise DamagedError(f"{path}: {what}; add --repair, or build it again")


def _places(n: int) -> str:
    return "one place" if n == 1 else f"{n} places"


def _repaired(path: Path, found: IntegrityReport, cell: Cell, jobs: int | None, as_json: bool) -> Repair:
    from pickcli.precompute.repair import repair

    with building(f"repairing {path.name}", path, jobs, as_json) as run_options:
        return repair(path, found, cell, run_options)


def _summary(path: Path, found: IntegrityReport, done: Repair | None) -> dict[str, Any]:
    return {
        "path": str(path),
        "format": found.kind.name,
        "cell_fingerprint": found.fingerprint,
        "cut_off": found.cut_off or None,
        "damage": [{"where": damage.where, "lost": damage.lost or None} for damage in found.damage],
        "intact": {name: len(rows) for name, rows in found.intact.items()},
        "repair": None
        if done is None
        else {"kept": done.n_kept, "computed": done.n_done, "same_bytes_as_made": done.is_same},
    }


def _lines(path: Path, found: IntegrityReport, done: Repair | None) -> list[str]:
    intact = ", ".join(f"{len(rows)} {name}" for name, rows in found.intact.items())
    if not found.damage:
        return [f"{path}: {found.kind.name}, undamaged: {intact}"]
    if found.cut_off:  # one cause of all losses
        lines = [f"{path}: {found.kind.name}, {found.cut_off}; intact: {intact}"]
    else:
        listed = [f"  {d.where}: {'lost: ' + d.lost if d.lost else 'nothing is lost'}" for d in found.damage]
        more = len(listed) - MOST_LINES
        lines = [f"{path}: {found.kind.name}, damaged; intact: {intact}", *listed[:MOST_LINES]]
        lines += [f"  and {more} more"] if more > 0 else []
    if done is not None:
        same = "the same bytes as when it was made" if done.is_same else "not the bytes that were made then"
        lines += [f"repaired: {done.n_kept} tasks kept, {done.n_done} computed again; {same}"]
    return lines
