"""``apc show``: one HTML file that shows a cell, scene, plan or trial in 3-D, without a network."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.common_options import (
    CELL_HELP,
    items_option,
    json_option,
    output_option,
    refuse_missing,
    refuse_output,
)
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.options.scene_options import open_scene
from pickcli.commands.options.stream_options import StreamOptions, stream_options
from pickcli.errors import InputError, StaleError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.page.page_document import PageDocument

RECORD = "trial.json"


@click.command("show", cls=Command)
@click.argument("path", metavar="FILE", type=PATH)
@click.option("--scene", "scene_path", type=PATH, metavar="FILE",
              help="For a plan, its scene file.  [default: the empty cell of --cell]")  # fmt: skip
@click.option("--cell", "cell_name", metavar="NAME|FOLDER",
              help=f"{CELL_HELP}  [default: the one that FILE names]")  # fmt: skip
@items_option
@arm_option("the preferred one, or that of the plan")
@standing_option
@stream_options
@output_option("page, an .html file")
@json_option
def command(
    path: Path, scene_path: Path | None, cell_name: str | None, items_path: Path | None, arm: str | None,
    standing: tuple[str, ...], output: Path, overwrite: bool, as_json: bool, request: StreamOptions,
) -> None:  # fmt: skip
    """Make a page that shows a cell, scene, plan, trial, roadmap or database in 3-D.

    The page is one file that needs no network. Motions are replayed in it: with the segments and devices, the
    joints' velocity, acceleration and jerk against their limits, and the clearance along the path. Faults
    that the verifier finds in a plan are drawn in place, as are the failures of a trial. FILE may also be a
    cell's folder or name, the folder of a trial, a folder of such folders, which are compared, or a stacked
    pallet, which is put up carton by carton.

    \b
    Example:
      apc show plan.json --scene scene.json -o plan.html
      apc show plan.json --stream stream.json --now 1.5 -o plan.html
      apc show scene.json -o scene.html
      apc show apc2016_delft -o cell.html
      apc show roadmap.h5 -o roadmap.html
      apc show runs/mine -o trial.html
      apc show stack.json -o stack.html
    """
    from pickcli.files.atomic_write import write_bytes
    from pickcli.page.html_page import page_bytes

    refuse_suffix(output, (".html",), "a page")
    refuse_output(output, overwrite, path, scene_path, cell_name, items_path, request.stream_path)
    request.refuse_scene(scene_path)
    arms = ArmRequest(arm, standing, items=items_path)
    document = _document(path, scene_path, request, cell_name, arms)
    with stage("writing of the page"):
        content = page_bytes(document)
        write_bytes(output, content, overwrite)
    if as_json:
        emit_json({"path": str(output), "kind": document.kind, "bytes": len(content)})
    else:
        click.echo(f"wrote {output}: {document.kind}, {len(content) / 1e6:.2f} MB")


def _document(
    path: Path, scene_path: Path | None, request: StreamOptions, cell_name: str | None, arms: ArmRequest
) -> PageDocument:
    """Build the page for any supported file. Raises InputError for other files."""
    from pickcli.cell.cell_file import CELL_FILE
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import CELL, PLAN, SCENE, STACKED, STORE, TRIAL
    from pickcli.monte_carlo.interrupted_run import refuse_interrupted

    refuse_missing(path, (".h5", ".json"))
    refuse_interrupted(path)
    if path.is_dir() and not _has_trials(path) and not (path / CELL_FILE).exists():
        raise InputError(
            f"{path}: is a folder without a finished trial ({RECORD}) and without a cell ({CELL_FILE}); name "
            "one of these, or a file"
        )
    is_file = path.exists() and not path.is_dir()  # what is no regular file is refused where it is read
    kind = read_kind(path) if is_file else TRIAL if _has_trials(path) else CELL
    if kind is not PLAN and scene_path is not None:
        raise click.UsageError("--scene applies only to a plan; leave it out")
    if kind is not PLAN and request.stream_path is not None:
        raise click.UsageError("--stream applies only to a plan; leave it out")
    if kind is PLAN:
        return _plan(path, scene_path, request, cell_name, arms)
    if kind is STORE:
        return _stored(path, cell_name, arms)
    if kind is SCENE:
        from pickcli.page.scene_page import scene_page

        return scene_page(open_scene(path, cell_name, arms))
    if kind is STACKED:
        from pickcli.page.pallet_page import pallet_page
        from pickcli.palletizing.pallet_stack_file import read_pallet_stack

        return pallet_page(read_pallet_stack(path))
    if kind is CELL:
        return _cell(path, arms)
    if kind is TRIAL:
        folder = path if path.is_dir() else path.parent
        if (folder / RECORD).is_file():
            return _trial(folder, cell_name, arms)
        if cell_name is not None:
            raise click.UsageError("--cell: a folder of trials is shown without their cells; leave it out")
        return _trials(folder)
    found = "is not a file that apc knows" if kind is None else f"is {kind.name}"
    raise InputError(
        f"{path}: {found}, but a roadmap, trajectory database, plan, scene, trial, stacked pallet or cell is "
        "expected here"
    )


def _plan(
    path: Path, scene_path: Path | None, stream: StreamOptions, cell_name: str | None, arms: ArmRequest
) -> PageDocument:
    from pickcli.motion.plan_file import read_plan
    from pickcli.page.plan_page import plan_page

    plan = read_plan(path)
    request = ArmRequest.of_plan(plan, arms.standing, arms.items)
    scene = stream.surroundings(plan, scene_path, cell_name, request)
    try:
        with stage("verification"):
            return plan_page(plan, scene)
    except StaleError as error:
        raise StaleError(f"{path} in {stream.stream_path or scene_path or cell_name}: {error}") from None


def _stored(path: Path, cell_name: str | None, arms: ArmRequest) -> PageDocument:
    from pickcli.drawing.draw import cell_of, picture_of
    from pickcli.page.picture_page import picture_page
    from pickcli.roadmap.store import describe

    description = describe(path)
    cell = cell_of(description["cell_fingerprint"]) if cell_name is None else open_cell(cell_name, arms)
    return picture_page(picture_of(path, cell), cell, str(description["format"]))


def _has_trials(path: Path) -> bool:
    """Whether a folder is that of a trial, or contains such folders."""
    return path.is_dir() and ((path / RECORD).is_file() or any(path.glob(f"*/{RECORD}")))


def _pallet_trial(folder: Path, cell_name: str | None, arms: ArmRequest) -> PageDocument:
    """Build the page of a trial of a pallet. Raises StaleError if its files are not of one trial."""
    from pickcli.page.pallet_trial_page import pallet_trial_page
    from pickcli.pallet_trials.pallet_folder import STACK
    from pickcli.pallet_trials.pallet_record import RECORDS, read_recorded_stack
    from pickcli.pallet_trials.pallet_station import PalletStation
    from pickcli.trial.motion_record import read_motion_of, refuse_other_motion
    from pickcli.trial.trial_folder import MOTION

    record = RECORDS.read(folder / RECORD)
    stack, motion = read_recorded_stack(folder / STACK, record), read_motion_of(folder / MOTION, record)
    made = record["made_from"]
    station = PalletStation.of(open_cell(cell_name or made["cell"], arms), stack)
    if station.cell.scene_fingerprint != made["cell_fingerprint"]:
        raise StaleError(
            f"{folder / RECORD}: was played in the cell {made['cell_fingerprint']}, {station.cell.name} is "
            f"{station.cell.scene_fingerprint}; play the trial again"
        )
    items = tuple(station.presented(placement.carton) for placement in stack.placements)
    refuse_other_motion(motion, replace(station.empty(0), items=items), (station.cell,), str(folder / MOTION))
    return pallet_trial_page(record, stack, station, motion)


def _stream_trial(folder: Path, cell_name: str | None, arms: ArmRequest) -> PageDocument:
    """Build the page of a trial of a stream. Raises StaleError if its files are not of one trial."""
    from pickcli.cell.cell_file import load_workcell
    from pickcli.page.stream_trial_page import stream_trial_page, waiting_scene
    from pickcli.stream_trials.stream_folder import STREAM, read_stream_motion
    from pickcli.stream_trials.stream_record import RECORDS, read_played_stream
    from pickcli.trial.motion_record import refuse_other_motion
    from pickcli.trial.trial_folder import MOTION

    record = RECORDS.read(folder / RECORD)
    motion = read_stream_motion(folder, record)
    first = replace(arms, arm=arms.arm or next(iter(motion.arms), None))
    cell = None if cell_name is None else open_cell(cell_name, first)
    stream = read_played_stream(folder / STREAM, record, lambda name: open_cell(name, first), cell)
    workcell = load_workcell(stream.cell.path, arms.items) if motion.arms else None
    cells = (stream.cell,) if workcell is None else tuple(workcell.arms[name] for name in motion.arms)
    scene = waiting_scene(stream)
    refuse_other_motion(motion, scene, cells, str(folder / MOTION))
    return stream_trial_page(record, scene, cells, motion)


def _commission_trial(folder: Path, cell_name: str | None, arms: ArmRequest) -> PageDocument:
    """Build the page of a trial of a commission. Raises StaleError if its files are not of one trial."""
    from pickcli.commission.commission_folder import COMMISSION, read_commission_motion
    from pickcli.commission.commission_record import RECORDS, read_played_commission
    from pickcli.commission.commission_station import CommissionStation
    from pickcli.page.commission_page import commission_page

    record = RECORDS.read(folder / RECORD)
    commission = read_played_commission(folder / COMMISSION, record)
    made = record["made_from"]
    station = CommissionStation.of(open_cell(cell_name or made["cell"], arms), commission)
    if station.cell.scene_fingerprint != made["cell_fingerprint"]:
        raise StaleError(
            f"{folder / RECORD}: was played in the cell {made['cell_fingerprint']}, {station.cell.name} is "
            f"{station.cell.scene_fingerprint}; play the trial again"
        )
    return commission_page(record, station, *read_commission_motion(folder, record, station))


def _trial(folder: Path, cell_name: str | None, arms: ArmRequest) -> PageDocument:
    from pickcli.cell.cell_file import load_workcell
    from pickcli.commission import commission_record
    from pickcli.page.trial_page import trial_page
    from pickcli.pallet_trials import pallet_record
    from pickcli.scene.scene_file import scene_hash
    from pickcli.stream_trials import stream_record
    from pickcli.trial.motion_record import read_motion, refuse_other_motion, refuse_other_record
    from pickcli.trial.trial_folder import MOTION, read_look_pictures
    from pickcli.trial.trial_record import read_record

    if commission_record.RECORDS.is_of(folder / RECORD):
        return _commission_trial(folder, cell_name, arms)
    if pallet_record.RECORDS.is_of(folder / RECORD):
        return _pallet_trial(folder, cell_name, arms)
    if stream_record.RECORDS.is_of(folder / RECORD):
        return _stream_trial(folder, cell_name, arms)
    record = read_record(folder / RECORD)
    if not (folder / MOTION).exists():
        raise InputError(f"{folder}: has no {MOTION}, nothing to replay; play the trial again")
    motion = read_motion(folder / MOTION)
    first = replace(arms, arm=arms.arm or next(iter(motion.arms), None))
    try:
        scene = open_scene(folder / "scene.json", cell_name, first)
    except UnknownNameError as error:
        if not motion.arms:
            raise
        raise StaleError(
            f"{folder / MOTION}: is the motion of another cell ({error}); play the trial again"
        ) from None
    if scene_hash(scene) != record["made_from"]["scene_hash"]:
        raise StaleError(
            f"{folder / 'scene.json'}: is not the scene of {folder / RECORD}; play the trial again"
        )
    workcell = load_workcell(scene.cell.path, arms.items) if motion.arms else None
    cells = (scene.cell,) if workcell is None else tuple(workcell.arms.values())
    refuse_other_motion(motion, scene, cells, str(folder / MOTION))
    refuse_other_record(motion, record, str(folder / MOTION))
    return trial_page(record, scene, motion, workcell, read_look_pictures(folder, record.get("looks", ())))


def _trials(folder: Path) -> PageDocument:
    from pickcli.commission import commission_trials
    from pickcli.monte_carlo.trials_folder import read_trials
    from pickcli.page.commission_trials_page import commission_trials_page
    from pickcli.page.stream_trials_page import stream_trials_page
    from pickcli.page.trials_page import trials_page
    from pickcli.stream_trials import stream_trials

    if commission_trials.TRIALS.is_of(folder):
        return commission_trials_page(commission_trials.TRIALS.read(folder))
    if stream_trials.TRIALS.is_of(folder):
        return stream_trials_page(stream_trials.TRIALS.read(folder))
    return trials_page(read_trials(folder))


def _cell(path: Path, arms: ArmRequest) -> PageDocument:
    from pickcli.cell.cell_file import load_workcell
    from pickcli.page.scene_page import cell_page

    workcell = load_workcell(path, arms.items)
    is_any = arms.arm is None and not arms.standing
    return cell_page(workcell.preferred if is_any else arms.cell_of(workcell))
