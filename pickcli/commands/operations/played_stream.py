"""``apc run-trial STREAM``: a trial of items that come along a conveyor."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest
from pickcli.commands.options.common_options import refuse_reading
from pickcli.commands.options.stream_options import StreamOptions
from pickcli.commands.options.stream_plan_options import StreamPlanOptions
from pickcli.commands.options.trial_options import TrialOptions, is_stated, refuse_options_of_orders
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines
from pickcli.errors import InputError, TrialAbortedError

if TYPE_CHECKING:
    from pickcli.stream_trials.stream_job import StreamTask
    from pickcli.stream_trials.stream_result import StreamTrialResult

FEW = 8  # reasons that are printed
OF_ORDERS = (
    "strategy_name", "stow_rule", "pod_shift", "tote_shift", "locate_tote", "live", "live_port",
    "learn", "sift", "drop_from",
)  # fmt: skip


def is_stream(path: Path) -> bool:
    """Tell whether a path names a stream.

    Args:
        path: File of an order or a stream, or the name of one under data/tasks.

    Returns:
        True for a stream.
    """
    from pickcli.cell.data_path import task_file
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import STREAM

    path = task_file(path)
    return path.is_file() and read_kind(path) is STREAM


def play_stream_file(
    path: Path,
    folder: Path,
    overwrite: bool,
    options: TrialOptions,
    planned_by: StreamPlanOptions,
    with_plans: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Play the trial of a stream, write its folder, and print what became of the items.

    Args:
        path: File of the stream, or its name under data/tasks.
        folder: Folder of the record.
        overwrite: Whether existing files may be replaced.
        options: The options of the command.
        planned_by: By which rule items are met, and what plans it.
        with_plans: Whether plans are kept, with the streams that they were certified for.
        seed: Seed of all random choices.
        as_json: Whether JSON is printed.

    Raises:
        UsageError: An option was stated that applies to orders only.
        InputError: A file cannot be read or written, or the cell has no place to bring items to.
        TrialAbortedError: Something collided, or a limit was broken.
    """
    from pickcli.cell.data_path import task_file
    from pickcli.stream_trials.stream_folder import NAMES, write_stream_folder
    from pickcli.stream_trials.stream_record import stream_record
    from pickcli.stream_trials.stream_trial import play_stream
    from pickcli.trial.trial_folder import refuse_existing_folder

    refuse_stated(options, planned_by)
    path = task_file(path)
    refuse_existing_folder(folder, overwrite)
    for name in NAMES:
        refuse_reading(folder / name, path, *options.inputs, planned_by.grasps_path)
    each = stream_task(path, options, planned_by)
    request = replace(each.request, seed=seed)
    with stage("trial"), progress("playing") as report:
        played = play_stream(request, each.contexts, report)
    result = played.result
    record = stream_record(request, result, each.contexts[0], each.file_name, each.sha256)
    cells = tuple(context.cell for context in each.contexts)
    paths = write_stream_folder(folder, each.content, cells, played, record, overwrite, with_plans)
    if as_json:
        emit_json({"path": str(folder), **record})
    else:
        click.echo("\n".join([*_lines(result, record), f"wrote {paths[-1]} and {len(paths) - 1} more"]))
    if not result.is_clean:
        counts = f"{result.n_collisions} collisions and {result.n_limit_violations} limit violations"
        raise TrialAbortedError(f"{counts}; see trial.json")


def refuse_stated(options: TrialOptions, planned_by: StreamPlanOptions) -> None:
    """Refuse, before any work, options that do not apply to streams, or not to how they are perceived.

    Args:
        options: The options of the command.
        planned_by: By which rule items are met, and what plans it.

    Raises:
        UsageError: One of them was stated, or options exclude each other.
    """
    planned_by.refuse_beside(options.approach)
    refuse_options_of_orders(OF_ORDERS, "streams")
    if options.perception in ("camera", "truth") and is_stated("pose_noise"):
        why = "a camera has errors of its own" if options.perception == "camera" else "there are no errors"
        raise click.UsageError(f"--pose-noise: {why}; leave it out")


def stream_task(
    path: Path, options: TrialOptions, planned_by: StreamPlanOptions, loaded: Iterable[StreamTask] = ()
) -> StreamTask:
    """Read a stream, and load all that its trials are played with.

    Args:
        path: File of the stream.
        options: The options of the command.
        planned_by: By which rule items are met, and what plans it.
        loaded: Streams that are loaded; with one of the same cell, its cell is not loaded again.

    Returns:
        The stream in its cell.

    Raises:
        InputError: A file cannot be read, there are no items, or the cell has no place to bring them to.
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.scene.scene import PoseNoise
    from pickcli.simulation.reality import read_reality
    from pickcli.stream_trials.belt_camera import BeltCamera
    from pickcli.stream_trials.stream_arms import destination_of
    from pickcli.stream_trials.stream_job import StreamTask
    from pickcli.stream_trials.stream_rules import StreamRule
    from pickcli.stream_trials.stream_trial_request import SPEED_ERROR, StreamTrialRequest

    named, content = options.cell_name if is_stated("cell_name") else None, path.read_bytes()
    stream = StreamOptions(path, None).stream(named, ArmRequest(items=options.items_path))
    if not stream.items:
        raise InputError(f"{path}: items: there are none, so that nothing can be played; state some")
    is_exact = options.perception == "truth"
    request = StreamTrialRequest(
        stream,
        PoseNoise() if is_exact else options.pose_noise,
        0.0 if is_exact else SPEED_ERROR,
        BeltCamera() if options.perception == "camera" else None,
        read_reality(options.reality_path),
        StreamRule(planned_by.stream_rule),
    )
    alike = (each.contexts for each in loaded if each.request.stream.cell.path == stream.cell.path)
    contexts = next(alike, None)
    if contexts is None:
        cells = options.cells(load_workcell(str(stream.cell.path), options.items_path))
        for cell in cells:
            destination_of(cell)  # refused before any work if the cell has none
        recorded = list(map(planned_by.recorded, cells))
        contexts = tuple(map(planned_by.planned_by, options.planning_contexts(cells), recorded))
    return StreamTask(request, path.name, content, hashlib.sha256(content).hexdigest(), contexts)


def _lines(result: StreamTrialResult, record: dict[str, Any]) -> list[str]:
    """Describe the result of a trial in a few lines."""
    counts = (
        f"{record['delivered']} of {record['presented']} items delivered, {record['attempted']} attempted"
    )
    bad = f"collisions {result.n_collisions}, limit violations {result.n_limit_violations}"
    lines = [
        f"{counts}, at {result.speed:g} m/s: {record['delivered_per_minute']:.1f} a minute",
        f"{bad}, stops {result.n_stops}",
    ]
    if record["offset_m"] is not None:
        offset, slip = record["offset_m"], record["slip_m_s"]
        n_held = sum(each.met is not None for each in result.items)
        lines.append(
            f"tool off its place by {1e3 * offset['p95']:.1f} mm and over the item at "
            f"{1e3 * slip['p95']:.1f} mm/s along the belt (95th percentile of {n_held} picks)"
        )
    lines += bound_lines(result.cost_bound)
    others = [each for each in result.items if str(each.outcome) != "delivered"]
    lines += [f"{each.item}: {each.outcome}: {each.reason}" for each in others[:FEW]]
    lines += [f"and {len(others) - FEW} more"] if len(others) > FEW else []
    return [*lines, *paper_lines({"": record})]


def bound_lines(found: Mapping[str, float] | None) -> list[str]:
    """Format the bounds on the cost of transits by ARA*.

    Args:
        found: The proven bounds, as ``percentiles``; None without any.

    Returns:
        A line of text; none without bounds.
    """
    if found is None:
        return []
    return [
        f"transits by ARA*: proven to cost at most {found['median']:.3f} times the least on the lattice in "
        f"the median, {found['worst']:.3f} at worst"
    ]


def paper_lines(records: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """Format the experiments of the PR2 paper of 2013 beside trials of the streams after them.

    Args:
        records: Contents of ``trial.json`` files of streams, by name.

    Returns:
        Lines of text; none if no such stream was played.
    """
    from pickcli.stream_trials.published_experiments import COLUMNS, beside_paper

    return [
        line
        for each in beside_paper(records)
        for line in (f"{each.title}:", *table_lines(COLUMNS, each.rows))
    ]
