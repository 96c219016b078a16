"""``apc check`` of texts: cells, scenes, orders of all kinds, driving areas, items and perceived items."""

from __future__ import annotations

import logging
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.played_commission import CELL as CELL_OF_COMMISSIONS
from pickcli.commands.operations.played_commission import read_station
from pickcli.commands.options.arm_options import ArmRequest, open_alike, open_cell
from pickcli.commands.options.common_options import DEFAULT_CELL, refuse_output
from pickcli.commands.options.scene_options import open_scene
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines
from pickcli.errors import InputError
from pickcli.files.file_kind import (
    CELL,
    COMMISSION,
    DRIVING_AREA,
    ITEMS,
    ORDER,
    PALLET,
    PERCEIVED,
    PLAN,
    SCENE,
    STORE,
    STREAM,
    FileKind,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pickcli.reachability.cell_check import CellCheck

HEAD = 4096  # bytes at the start of a text file that state its format
TEXTS = (CELL, SCENE, ORDER, ITEMS, PERCEIVED, STREAM, PALLET, COMMISSION, DRIVING_AREA)
_log = logging.getLogger(__name__)


def kind_of_text(path: Path) -> FileKind | None:
    """Return the kind of hand-written file that a path names.

    Args:
        path: A folder, the name of a cell under data/cells, or a file.

    Returns:
        The kind; None for any other file, also for an unreadable one.

    Raises:
        InputError: The file is of another kind, or a text of none.
    """
    from pickcli.cell.cell_file import cell_names
    from pickcli.files.bounded_reading import refuse_special_file
    from pickcli.files.file_kind import kind_of

    if path.is_dir() or str(path) in cell_names():
        return CELL
    with suppress(OSError):  # the reader will report why it cannot be read
        refuse_special_file(path)
        with path.open("rb") as file:
            head = file.read(HEAD)
            kind = kind_of(head)
            if kind in TEXTS:
                return kind
            wanted = f"{', '.join(each.name for each in TEXTS)}, or {STORE.name} is expected here"
            if kind not in (None, STORE):
                advice = " (apc verify checks plans)" if kind is PLAN else ""
                raise InputError(f"{path}: is {kind.name}, but {wanted}{advice}")
            if kind is None and head.strip() and head.isascii() and b"\0" not in head:
                raise InputError(f"{path}: is a text file of another kind, but {wanted}")
    return None


def refuse_options_of_cells(strict: bool, picture: Path | None) -> None:
    """Refuse options that do not apply to stored files.

    Args:
        strict: Whether warnings are treated as mistakes.
        picture: File of the picture.

    Raises:
        UsageError: One of them was given.
    """
    if strict or picture is not None:
        option = "--strict" if strict else "--picture"
        raise click.UsageError(f"{option} is for cells, scenes, orders and items; leave it out")


def refuse_picture(kind: FileKind, picture: Path, overwrite: bool, *inputs: Path | str | None) -> None:
    """Refuse, before any work, a picture that could not be drawn or written.

    Args:
        kind: Kind of the checked file.
        picture: File of the picture.
        overwrite: Whether an existing file may be replaced.
        *inputs: Files that the command reads.

    Raises:
        UsageError: The checked file is not a cell.
        InputError: The picture cannot be written.
    """
    from pickcli.drawing.draw import refuse_suffix

    if kind is not CELL:
        raise click.UsageError("--picture applies only to a cell; leave it out")
    refuse_suffix(picture)
    refuse_output(picture, overwrite, *inputs)


@dataclass(frozen=True)
class CheckOptions:
    """Options of the check of a file.

    Attributes:
        cell_name: The cell of a scene or order; None for the scene's own, or the default.
        arms: The arms stated on the command line.
        strict: Whether warnings are treated as mistakes.
        poses: Number of tool poses by which each place of a cell is judged.
        picture: File for a picture of what a cell's arm reaches.
        overwrite: Whether an existing file may be replaced.
        as_json: Whether JSON is printed.
    """

    cell_name: str | None
    arms: ArmRequest
    strict: bool
    poses: int
    picture: Path | None
    overwrite: bool
    as_json: bool


def check_text(path: Path, kind: FileKind, options: CheckOptions) -> None:
    """Check a cell, scene, order, file of items or of perceived items, and print the result.

    Args:
        path: The file; for a cell also its name or folder.
        kind: Kind of the file.
        options: Options of the check.

    Raises:
        InputError: With every mistake, or with the number of warnings if they are treated as mistakes.
    """
    check = {
        CELL: _checked_cell,
        SCENE: _checked_scene,
        ORDER: _checked_order,
        ITEMS: _checked_items,
        PERCEIVED: _checked_perceived,
        STREAM: _checked_stream,
        PALLET: _checked_pallet,
        COMMISSION: _checked_commission,
        DRIVING_AREA: _checked_driving_area,
    }[kind]
    with _heard() as warnings:
        values = check(path, options)
    n, what = len(warnings), values.pop("text")
    counted = f"{n} warning{'s' * (n != 1)}"
    if options.as_json:
        emit_json({"path": str(path), **values, "warnings": warnings})
    else:
        click.echo(f"{path}: {f'with {counted}' if warnings else 'without mistakes'}; {what}")
    if options.strict and warnings:
        raise InputError(f"{path}: {counted}, and --strict treats warnings as mistakes")


@contextmanager
def _heard() -> Iterator[list[str]]:
    """Collect the warnings logged in the context, without repetitions."""
    heard: list[str] = []

    def hear(record: logging.LogRecord) -> bool:
        if record.levelno == logging.WARNING and record.getMessage() not in heard:
            heard.append(record.getMessage())
        return False

    listener = logging.Handler(logging.WARNING)
    listener.addFilter(hear)
    logger = logging.getLogger("pickcli")
    logger.addHandler(listener)
    try:
        yield heard
    finally:
        logger.removeHandler(listener)


def _checked_cell(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.cell.cell_file import load_workcell
    from pickcli.reachability.cell_check import check_cell

    workcell = load_workcell(path)
    with stage("standing in every configuration, reaching into every place"), progress("reaching") as report:
        found = check_cell(workcell, options.poses, on_progress=report)
    for line in found.warnings:
        _log.warning("%s", line)
    if options.picture is not None:
        _draw(found, options.picture, options.overwrite)
    if found.reaches and not options.as_json:
        click.echo("\n".join(_reach_table(found)))
    if found.notes and not options.as_json:
        click.echo("\n".join(f"note: {note}" for note in found.notes))
    if found.mistakes:
        raise InputError("\n".join(found.mistakes))
    return {
        "text": f"all {found.n_free} configurations are free",
        "fingerprint": workcell.preferred.scene_fingerprint,
        "configurations": found.n_free,
        "notes": list(found.notes),
        "reach": [
            {
                "arm": each.arm or None,
                "place": each.place,
                "tool_poses": len(each.tips),
                "share": each.share,
                "configuration": each.configuration or None,
                "share_in_line": each.share_in_line,
            }
            for each in found.reaches
        ],
        "picture": None if options.picture is None else str(options.picture),
    }


def _reach_table(found: CellCheck) -> list[str]:
    """Return a row per place: the share of tool poses that the arm reaches at all, and along a line."""
    rows = []
    for each in found.reaches:
        in_line = "-" if each.share_in_line is None else f"{each.share_in_line:.0%}"
        waits = each.configuration or "-"
        name = f"{each.place}, arm {each.arm}" if each.arm else each.place
        rows.append([name, f"{each.share:.0%}", waits, in_line, str(len(each.tips))])
    return table_lines(("place", "reached", "from", "in a line", "tool poses"), rows)


def _checked_stream(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.cell.cell_file import load_workcell
    from pickcli.scene.stream_file import read_stream

    cell = None if options.cell_name is None else open_cell(options.cell_name, options.arms)
    stream = read_stream(path, cell, lambda name: load_workcell(name).preferred)
    n = len(stream.items)
    return {"text": f"a stream of {n} items on {stream.conveyor}", "items": n}


def _checked_pallet(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.palletizing.pallet_order_file import read_pallet_order

    n = len(read_pallet_order(path).cartons)
    return {"text": f"an order of a pallet of {n} cartons", "cartons": n}


def _checked_commission(path: Path, options: CheckOptions) -> dict[str, Any]:
    station = read_station(path, options.cell_name or CELL_OF_COMMISSIONS)
    n = len(station.commission.items)
    return {"text": f"a commission of {n} items in {station.cell.name}", "items": n}


def _checked_driving_area(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.driving.driving_area_file import read_driving_area

    n = len(read_driving_area(path).boxes)
    return {"text": f"a driving area with {n} boxes", "boxes": n}


def _draw(found: CellCheck, picture: Path, overwrite: bool) -> None:
    from pickcli.drawing.place_picture import reach_picture
    from pickcli.page.picture_page import write_drawing

    write_drawing(reach_picture(found.cell, found.reaches), found.cell, picture, overwrite)


def _checked_scene(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.scene.scene_file import scene_hash

    scene = open_scene(path, options.cell_name, options.arms)
    n = len(scene.items)
    return {
        "text": f"{n} item{'s' * (n != 1)}, none of which floats, overlaps or stands in anything",
        "scene_hash": scene_hash(scene),
        "n_items": n,
    }


def _checked_order(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.trial.order_file import read_order

    order = read_order(path, open_cell(options.cell_name or DEFAULT_CELL, options.arms))
    n = len(order.targets)
    return {"text": f"an order of {n} target{'s' * (n != 1)}", "targets": n}


def _checked_perceived(path: Path, options: CheckOptions) -> dict[str, Any]:
    from functools import partial

    from pickcli.perception.items.perceived_file import read_perceived

    cell = None if options.cell_name is None else open_alike(options.cell_name, options.arms)
    perceived = read_perceived(path, cell, partial(open_alike, request=options.arms))
    places, is_located = perceived.places, perceived.pod is not None
    answers = [item for place in places for item in place.items]
    n = sum(item.is_answer for item in answers)
    where = f" in {', '.join(place.place for place in places)}" if places else ""
    text = f"{n} of {len(answers)} listed items found{where}{', and the pod' * is_located}"
    return {"text": text, "n_items": len(answers), "n_found": n, "is_pod_located": is_located}


def _checked_items(path: Path, options: CheckOptions) -> dict[str, Any]:
    from pickcli.cell.schemas.items_file import read_items

    if options.cell_name is not None:
        raise click.UsageError("--cell does not apply to a file of items; leave it out")
    n = len(read_items(path))
    return {"text": f"{n} item{'s' * (n != 1)}", "n_items": n}
