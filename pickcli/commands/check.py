"""``apc check``: every byte of a roadmap or trajectory database, and making it whole again."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.build_options import jobs_option
from pickcli.commands.building import building
from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.option_types import PATH
from pickcli.commands.options import cell_option, json_option, refuse_missing
from pickcli.errors import DamagedError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.precompute.repair import Repair
    from pickcli.storage.integrity_scan import IntegrityReport

YARDSTICK = "yardstick"  # the kind of configurations that no motion goes to
HEAD = 4096  # bytes, in which a cell file names its format
MOST_LINES = 20  # damaged blocks that are listed for people


@click.command("check", cls=Command)
@click.argument("path", metavar="FILE", type=PATH)
@click.option("--repair", "is_repair", is_flag=True, help="Compute again what is lost, and only that.")
@cell_option
@arm_option()
@standing_option
@jobs_option
@json_option
def command(
    path: Path, is_repair: bool, cell_name: str, arm: str | None, standing: tuple[str, ...],
    jobs: int | None, as_json: bool,
) -> None:  # fmt: skip
    """Find damage in a roadmap or trajectory database, or mistakes in a cell.

    Of a cell (its name, folder or cell.yaml) everything is read, and whether the arm can stand in its named
    configurations; exit code 3 where not. Of a stored file every damaged block is named, and what is lost
    with it. With --repair the file is made whole again: what is intact is kept, the rest computed anew, for
    the same cell. Exit code 4 where damage is left.

    \b
    Example:
      apc check trajectories.h5 --repair
      apc check my_robot
    """
    from pickcli.roadmap.store import describe, surveyed

    refuse_missing(path, (".h5",))
    if _is_cell(path):
        _check_cell(path, as_json)
        return
    cell = open_cell(cell_name, ArmRequest(arm, standing))
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


def _is_cell(path: Path) -> bool:
    """Whether a path means a cell: a folder, the name of one under data/cells, or a cell file."""
    from pickcli.cell.cell_file import cell_names
    from pickcli.files.bounded_reading import refuse_special_file
    from pickcli.files.file_kind import CELL, kind_of

    if path.is_dir() or str(path) in cell_names():
        return True
    with suppress(OSError):  # who reads it then says why it cannot be
        refuse_special_file(path)
        with path.open("rb") as file:
            return kind_of(file.read(HEAD)) == CELL
    return False


def _check_cell(path: Path, as_json: bool) -> None:
    """Read a cell, and have the arm stand in its configurations. Raises InputError with every mistake."""
    from pickcli.cell.cell_file import load_workcell
    from pickcli.errors import InputError
    from pickcli.precompute.empty_cell_checkers import why_not_free

    workcell, told, n_meant = load_workcell(path), list[str](), 0
    for arm, cell in workcell.arms.items():
        with stage("standing in every configuration"):
            reasons = why_not_free(cell)
        meant = [named.name for named in cell.configurations.values() if named.kind != YARDSTICK]
        n_meant += len(meant)
        of_arm = f" of arm {arm}" if arm else ""
        told += [
            f"configuration {name}{of_arm} is not free, {reasons[name]}" for name in meant if name in reasons
        ]
    cell = workcell.preferred
    if told:
        raise InputError("\n".join(f"{cell.path / 'cell.yaml'}: {text}" for text in told))
    if as_json:
        emit_json({"path": str(path), "fingerprint": cell.scene_fingerprint, "configurations": n_meant})
    else:
        click.echo(f"{path}: a cell without mistakes; all {n_meant} configurations are free")


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
    if found.cut_off:  # one cause, whatever is lost with it
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
