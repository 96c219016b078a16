"""``apc run-trial COMMISSION``: a trial in which a truck takes a pallet and its arm fills it."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import refuse_reading
from pickcli.commands.options.people_options import PeopleOptions
from pickcli.commands.options.trial_options import TrialOptions, is_stated, refuse_options_of_orders
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines
from pickcli.errors import InputError, TrialAbortedError

if TYPE_CHECKING:
    from pickcli.commission.commission_job import CommissionTask
    from pickcli.commission.commission_result import CommissionResult
    from pickcli.commission.commission_station import CommissionStation
    from pickcli.commission.commission_trial import CommissionRequest
    from pickcli.scene.scene import PoseNoise
    from pickcli.strategy.strategy_tree import Strategy

CELL = "apple_booth"  # unless --cell names another
OF_ORDERS = (
    "stow_rule",
    "pod_shift",
    "tote_shift",
    "locate_tote",
    "arm",
    "live",
    "live_port",
    "learn",
    "sift",
    "drop_from",
    "approach",
    "items_path",
)


def is_commission(path: Path) -> bool:
    """Tell whether a path names a commission.

    Args:
        path: File of an order, or the name of one.

    Returns:
        True for the file of a commission, or the name of one under data/tasks.
    """
    from pickcli.cell.data_path import task_file
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import COMMISSION

    found = task_file(path)
    return found.is_file() and read_kind(found) is COMMISSION


def play_commission_file(
    path: Path,
    folder: Path,
    overwrite: bool,
    how: tuple[TrialOptions, PeopleOptions],
    with_plans: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Play the trial of a commission, write its folder, and print what came of it.

    Args:
        path: File of the commission, or its name under data/tasks.
        folder: Folder of the record.
        overwrite: Whether existing files may be replaced.
        how: The options of the command, and those of people in the booth.
        with_plans: Whether plans are kept, with the scenes that they were certified for.
        seed: Seed of all random choices.
        as_json: Whether JSON is printed.

    Raises:
        UsageError: An option was stated that applies to orders only.
        InputError: A file cannot be read or written, or the cell cannot do what it says.
        TrialAbortedError: Something collided, a limit was broken, or the commission was ended early.
    """
    from pickcli.cell.data_path import task_file
    from pickcli.commission.commission_folder import NAMES, write_commission_folder
    from pickcli.commission.commission_record import commission_record
    from pickcli.commission.commission_trial import play_commission
    from pickcli.trial.trial_folder import refuse_existing_folder

    path, (options, people) = task_file(path), how
    refuse_options_of_orders(OF_ORDERS, "commissions")
    refuse_existing_folder(folder, overwrite)
    for name in NAMES:
        refuse_reading(folder / name, path, people.path, *options.inputs)
    each = commission_task(path, options)
    request = replace(commission_conditions(options, seed), watched=people.booth_watch(each.station))
    with stage("trial"), progress("playing") as report:
        played = play_commission(request, each.station, each.context, report)
    record = commission_record(request, each.station, played, each.file_name, each.sha256)
    paths = write_commission_folder(folder, each.text, each.station, played, record, overwrite, with_plans)
    if as_json:
        emit_json({"path": str(folder), **record})
    else:
        click.echo("\n".join([*_lines(played.result), f"wrote {paths[-1]} and {len(paths) - 1} more"]))
    if why := _what_went_wrong(played.result):
        raise TrialAbortedError(f"{why}; see trial.json")


def commission_task(path: Path, options: TrialOptions) -> CommissionTask:
    """Read a commission, and load all that its trials are played with.

    Args:
        path: The file.
        options: The options of the command.

    Returns:
        The commission in its cell.

    Raises:
        InputError: The file cannot be read, or the cell cannot do what it says.
    """
    from pickcli.commission.commission_job import CommissionTask

    station = read_station(path, commission_cell(options))
    content = path.read_bytes()
    (context,) = options.planning_contexts([station.cell])
    digest = hashlib.sha256(content).hexdigest()
    return CommissionTask(station, path.name, content.decode("utf-8-sig"), digest, context)


def read_station(path: Path, cell_name: str) -> CommissionStation:
    """Read a commission and build its station in a cell.

    Args:
        path: The file.
        cell_name: Name or folder of the cell.

    Returns:
        The station.

    Raises:
        InputError: The file cannot be read, or the cell cannot do what it says.
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.commission.commission_file import read_commission
    from pickcli.commission.commission_station import CommissionStation

    cell, commission = load_workcell(cell_name).preferred, read_commission(path)
    try:
        return CommissionStation.of(cell, commission)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def commission_cell(options: TrialOptions) -> str:
    """Return the name or folder of the cell in which commissions are played.

    Args:
        options: The options of the command.

    Returns:
        That of ``--cell``, else the cell of commissions.
    """
    return options.cell_name if is_stated("cell_name") else CELL


def commission_conditions(options: TrialOptions, seed: int) -> CommissionRequest:
    """Return the conditions of trials of commissions.

    Args:
        options: The options of the command.
        seed: Seed of the trial.

    Returns:
        The conditions.

    Raises:
        UsageError: An option was stated that does not apply to commissions.
        InputError: Strategy or reality cannot be read.
    """
    from pickcli.commission.commission_trial import CommissionRequest
    from pickcli.simulation.reality import read_reality

    reality = read_reality(options.reality_path)
    return CommissionRequest(_strategy(options), _noise(options), reality, seed=seed)


def _strategy(options: TrialOptions) -> Strategy:
    from pickcli.commission.commission_trial import STRATEGY
    from pickcli.strategy.node_types import TrialKind
    from pickcli.strategy.strategy_file import load_strategy

    name = options.strategy_name if is_stated("strategy_name") else STRATEGY
    return load_strategy(name, TrialKind.COMMISSION)


def _noise(options: TrialOptions) -> PoseNoise:
    """Return the bounds of errors of perceived poses. Raises UsageError if cameras are to see."""
    from pickcli.commission.commission_trial import NOISE
    from pickcli.scene.scene import PoseNoise

    if options.perception == "camera":
        raise click.UsageError("--perception camera: commissions are not seen by cameras; leave it out")
    if options.perception == "truth":
        return PoseNoise()
    return options.pose_noise if is_stated("pose_noise") else NOISE


def _lines(result: CommissionResult) -> list[str]:
    """Describe the result of a trial: its steps, and a few lines."""
    rows = [
        (f"{each.t_start:.1f}", f"{each.t_end - each.t_start:.1f}", each.action, each.target,
         "done" if each.is_success else "failed", each.told)
        for each in result.steps
    ]  # fmt: skip
    off = result.delivered
    delivered = (
        "the pallet was not set down" if off is None
        else f"the pallet stands {1e3 * off.distance:.0f} mm and {off.turn * 57.2958:.1f} degrees off"
    )  # fmt: skip
    return [
        *table_lines(("s", "takes", "step", "item", "", "why"), rows),
        f"{'success' if result.is_success else 'no success'}: {result.n_placed} of {len(result.items)} items "
        f"on the pallet, {delivered}",
        *(f"not in its place: {each.told}" for each in result.items if not each.is_placed),
        *_people(result),
        f"{result.duration:.0f} s, of these {result.handling:.0f} s at the load; collisions "
        f"{result.n_collisions}, limit violations {result.n_limit_violations}, stops {result.n_stops}",
    ]


def _people(result: CommissionResult) -> list[str]:
    """Describe what the drives tell of people, if they were watched."""
    met = result.people
    if met is None:
        return []
    touched = f"{met.touched} touched by the moving truck" if met.touched else "nobody touched by the truck"
    return [
        f"{met.number} people in the booth: {met.brake_requests} brake requests, {met.braked_s:.1f} s "
        f"braked, {touched}, {met.walked_in} walked into it"
    ]


def _what_went_wrong(result: CommissionResult) -> str:
    """Describe why the trial was aborted or not clean; "" if it was neither."""
    if result.aborted:
        return f"ended where the truck stood after {result.aborted}"
    if not result.is_clean:
        return f"{result.n_collisions} collisions and {result.n_limit_violations} limit violations"
    return ""
