"""``apc run-trial PALLET``: a trial in which an arm stacks the cartons of a pallet."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import refuse_reading
from pickcli.commands.options.trial_options import TrialOptions, is_stated, refuse_options_of_orders
from pickcli.commands.output.progress_bar import progress
from pickcli.errors import InputError, RejectedError, TrialAbortedError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.pallet_trials.pallet_result import PalletTrialResult
    from pickcli.palletizing.pallet_stack_file import StackedPallet
    from pickcli.scene.scene import PoseNoise

CELL = "pallet_sia20"  # unless --cell names another
HOW_TO = "docs/how-to/stack-a-pallet.md"
FEW = 8  # reasons that are printed
OF_ORDERS = (
    "strategy_name",
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
)


def is_pallet(path: Path) -> bool:
    """Tell whether a path names the order of a pallet, or a stack.

    Args:
        path: File of an order, or the name of one.

    Returns:
        True for the file of either.
    """
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import PALLET, STACKED

    return path.is_file() and read_kind(path) in (PALLET, STACKED)


def play_pallet_file(
    path: Path,
    folder: Path,
    overwrite: bool,
    options: TrialOptions,
    with_plans: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Play the trial of a pallet, write its folder, and print what became of the cartons.

    Args:
        path: File of the stack, or of an order, which is stacked first.
        folder: Folder of the record.
        overwrite: Whether existing files may be replaced.
        options: The options of the command.
        with_plans: Whether plans are kept, with the scenes that they were certified for.
        seed: Seed of all random choices.
        as_json: Whether JSON is printed.

    Raises:
        UsageError: An option was stated that applies to orders only.
        InputError: A file cannot be read or written, or the cell cannot stack what it says.
        RejectedError: The stack has faults.
        TrialAbortedError: Something collided, or a limit was broken.
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.pallet_trials.pallet_folder import NAMES, write_pallet_folder
    from pickcli.pallet_trials.pallet_record import pallet_record
    from pickcli.pallet_trials.pallet_station import PalletStation
    from pickcli.pallet_trials.pallet_trial import PalletTrialRequest, play_pallet
    from pickcli.simulation.reality import read_reality
    from pickcli.trial.trial_folder import refuse_existing_folder

    refuse_options_of_orders(OF_ORDERS, "pallets")
    refuse_existing_folder(folder, overwrite)
    for name in NAMES:
        refuse_reading(folder / name, path, *options.inputs)
    workcell = load_workcell(options.cell_name if is_stated("cell_name") else CELL, options.items_path)
    cell, digest = workcell.preferred, hashlib.sha256(path.read_bytes()).hexdigest()
    _ = cell.home  # refused before any work if the cell has none
    stack = _stack(path, cell, seed)
    try:
        station = PalletStation.of(cell, stack)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None
    noise, reality = _noise(options), read_reality(options.reality_path)
    if tight := station.shortfalls(stack, noise):
        click.echo(f"note: {'; '.join(tight)}: some cartons may be left; see {HOW_TO}", err=True)
    request = PalletTrialRequest(stack, noise, reality, seed)
    (context,) = options.planning_contexts([station.cell])
    with stage("trial"), progress("playing") as report:
        played = play_pallet(request, station, context, report)
    record = pallet_record(request, station, played, path.name, digest)
    paths = write_pallet_folder(folder, stack, station, played, record, overwrite, with_plans)
    if as_json:
        emit_json({"path": str(folder), **record})
    else:
        click.echo(
            "\n".join([*_lines(played.result, record), f"wrote {paths[-1]} and {len(paths) - 1} more"])
        )
    if not played.result.is_clean:
        result = played.result
        counts = f"{result.n_collisions} collisions and {result.n_limit_violations} limit violations"
        raise TrialAbortedError(f"{counts}; see trial.json")


def _stack(path: Path, cell: Cell, seed: int) -> StackedPallet:
    """Read a stack, or plan that of an order. Raises RejectedError if the verifier finds a fault."""
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import STACKED
    from pickcli.pallet_trials.pallet_station import side_of_arm
    from pickcli.palletizing.arm_sequence import seen_from
    from pickcli.palletizing.drop_test import what_stands
    from pickcli.palletizing.pallet_order_file import read_pallet_order
    from pickcli.palletizing.pallet_stack_file import StackedPallet, read_pallet_stack
    from pickcli.palletizing.stack_verification import verify_stack
    from pickcli.palletizing.stacking import stack_all

    if read_kind(path) is STACKED:
        stack = read_pallet_stack(path)
    else:
        order = read_pallet_order(path)
        with stage("stacking"):
            stack = StackedPallet.of(*what_stands(seen_from(stack_all(order, seed), side_of_arm(cell))))
    if reasons := verify_stack(stack).reasons:
        raise RejectedError(str(path), reasons)
    return stack


def _noise(options: TrialOptions) -> PoseNoise:
    """Return the bounds of errors of perceived poses. Raises UsageError if cameras are to see."""
    from pickcli.pallet_trials.pallet_trial import NOISE
    from pickcli.scene.scene import PoseNoise

    if options.perception == "camera":
        raise click.UsageError("--perception camera: cartons are not perceived by cameras yet; leave it out")
    if options.perception == "truth":
        return PoseNoise()
    return options.pose_noise if is_stated("pose_noise") else NOISE


def _lines(result: PalletTrialResult, record: dict[str, Any]) -> list[str]:
    """Describe the result of a trial in a few lines."""
    fallen = "; it has collapsed" if result.has_collapsed else ""
    bad = f"collisions {result.n_collisions}, limit violations {result.n_limit_violations}"
    lines = [
        f"{result.n_placed} of {result.n_ordered} cartons stacked, score {result.score:.2f}{fallen}",
        f"{result.boxes_an_hour:.0f} boxes an hour, {result.t_end:.0f} s",
        f"{bad}, stops {result.n_stops}",
    ]
    if (aside := record["aside_m"]) is not None:
        lines.append(
            f"set down {1e3 * aside['median']:.1f} mm beside the planned places in the median, "
            f"{1e3 * aside['worst']:.1f} mm at worst"
        )
    others = [f"{each.carton}: {each.outcome}: {each.reason}" for each in result.cartons if each.reason]
    others += [f"{name}: left: {'; '.join(reasons)}" for name, reasons in result.unplanned.items()]
    return [*lines, *others[:FEW], *([f"and {len(others) - FEW} more"] if len(others) > FEW else [])]
