"""``apc run-trials``: Monte Carlo over orders and seeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command
from pickcli.commands.operations.played_commission import is_commission
from pickcli.commands.operations.played_commissions import play_commission_files
from pickcli.commands.operations.played_stream import is_stream
from pickcli.commands.operations.played_streams import play_stream_files
from pickcli.commands.options.build_options import scheduler_option
from pickcli.commands.options.common_options import json_option
from pickcli.commands.options.option_types import PATH
from pickcli.commands.options.people_options import PeopleOptions, people_options, refuse_people
from pickcli.commands.options.stream_plan_options import (
    StreamPlanOptions,
    refuse_stream_plan,
    stream_plan_options,
)
from pickcli.commands.options.trial_options import TrialOptions, refuse_stow_rule, trial_arm, trial_options
from pickcli.commands.output.trials_output import (
    MOST_CAUSES,
    TrialsFolder,
    are_all,
    cause_lines,
    cell_files,
    content_digest,
    played_trials,
    stored_files,
)
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.monte_carlo.trial_job import TrialJob
    from pickcli.monte_carlo.trials_folder import TrialsReport
    from pickcli.trial.order import Order

MOST_SEEDS = 10_000
LARGEST_SEED = 2**31 - 1


def parse_seeds(ctx: click.Context | None, param: click.Parameter | None, value: str) -> tuple[int, ...]:
    """Parse the value of --seeds.

    Args:
        ctx: Context of click.
        param: The option.
        value: Numbers and ranges A:B (without B) with commas, from the command line.

    Returns:
        The seeds.

    Raises:
        BadParameter: The value is invalid, out of range, or contains a seed twice.
    """
    seeds: list[int] = []
    for part in value.split(","):
        ends = part.split(":")
        if len(ends) > 2 or not all(end.isascii() and end.isdecimal() and len(end) <= 10 for end in ends):
            what = f"{value!r}: expected seeds, e.g. 0:20 (20 excluded) or 3,5,8"
            raise click.BadParameter(what, ctx, param)
        first, end = int(ends[0]), int(ends[-1]) + (len(ends) == 1)
        if not first < end <= LARGEST_SEED + 1 or len(seeds) + end - first > MOST_SEEDS:
            what = f"{part!r}: expected 1 to {MOST_SEEDS} seeds, 0 to {LARGEST_SEED}, the lower one first"
            raise click.BadParameter(what, ctx, param)
        seeds += range(first, end)
    if len(set(seeds)) < len(seeds):
        raise click.BadParameter(f"{value!r}: names a seed twice", ctx, param)
    return tuple(seeds)


@click.command("run-trials", cls=Command)
@click.argument("order_paths", metavar="ORDER...", nargs=-1, required=True, type=PATH)
@click.option(
    "--seeds", metavar="A:B", callback=parse_seeds, default="0:20", show_default=True,
    help="Seeds that each order is played with: from A to before B, or numbers with commas.",
)  # fmt: skip
@click.option("-o", "--output", type=PATH, metavar="FOLDER", required=True, help="Folder to write.")
@click.option(
    "--overwrite", is_flag=True,
    help="Replace trials.json, trials.html and the files of trials in a folder that exists.",
)  # fmt: skip
@stream_plan_options
@people_options
@trial_options
@scheduler_option
@json_option
def command(
    order_paths: tuple[Path, ...], seeds: tuple[int, ...], output: Path, overwrite: bool,
    planned_by: StreamPlanOptions, people: PeopleOptions, options: TrialOptions, scheduler: str | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Play orders with many seeds, and report the distribution of scores.

    Each ORDER (a file, or the name of one under data/tasks) is played with each seed as by run-trial, which
    writes its files to OUTPUT/ORDER-SEED. Statistics of all trials are written to trials.json and
    trials.html: scores, success by item and place with 95 % intervals, causes of failure, times. Instead
    of orders these may be commissions (docs/formats/commission.md): how often the whole chain succeeds, its
    times, and the steps that fail; or streams on a conveyor (docs/formats/stream.md): what is delivered of
    what comes, how well it is met, and why the rest is not. An interrupted run continues when the same
    command is given again.

    \b
    Example:
      apc run-trials jsk_pick_sample delft_pick_2 --seeds 0:20 --jobs 2 -o runs/many
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.simulation.reality import read_reality
    from pickcli.trial.order_file import order_file

    folder = TrialsFolder(output, overwrite, scheduler, as_json)
    if are_all(order_paths, is_commission, "a commission"):
        refuse_stream_plan()
        play_commission_files(order_paths, seeds, folder, options, people)
        return
    refuse_people()
    if are_all(order_paths, is_stream, "a stream"):
        play_stream_files(order_paths, seeds, folder, options, planned_by)
        return
    refuse_stream_plan()
    workcell = load_workcell(options.cell_name, options.items_path)
    reality = read_reality(options.reality_path)
    cells = options.cells(workcell)
    orders = _orders(order_paths, cells[0])
    refuse_stow_rule(orders.values())
    options.refuse_misplaced(reality, cells[0], orders.values(), seeds[0])
    files = [order_file(path, cells[0]) for path in order_paths]
    folder.refuse(orders, seeds, *files, *options.inputs)

    from pickcli.jobs.job import sources_digest
    from pickcli.monte_carlo.trial_job import TrialJob
    from pickcli.monte_carlo.trials_folder import order_summary
    from pickcli.page.trials_page import trials_page

    conditions = options.conditions(reality, cells[0], orders.values())
    contexts = options.planning_contexts(cells)
    stored = [path for each in cells for path in stored_files(each, options.roadmap, options.trajectories)]
    job = TrialJob(
        orders, {path.stem: path.name for path in order_paths},
        tuple(trial_arm(workcell, context) for context in contexts), conditions,
        content_digest([*files, *stored, *cell_files(options.cell_name, options.items_path)]),
        sources_digest(),
    )  # fmt: skip
    report = played_trials(
        job, seeds, folder, options.jobs, _made_from(job, seeds), order_summary, trials_page
    )
    folder.tell(report, _lines(report))


def _orders(paths: Sequence[Path], cell: Cell) -> dict[str, Order]:
    """Read the orders by name. Raises InputError for two of one name, and for unplayable ones."""
    from pickcli.random_scenes.make_scene import refuse_too_much
    from pickcli.trial.order import require_playable
    from pickcli.trial.order_file import read_order, refuse_unknown_task

    orders: dict[str, Order] = {}
    for path in paths:
        if path.stem in orders:
            raise InputError(f"{path}: a second order of the name {path.stem}; rename it, or name it once")
        refuse_unknown_task(path, cell)
        orders[path.stem] = require_playable(read_order(path, cell), str(path))
        refuse_too_much(orders[path.stem].contents, cell, orders[path.stem].year, str(path))
    return orders


def _made_from(job: TrialJob, seeds: Sequence[int]) -> dict[str, Any]:
    """Return the parameters of the trials, for trials.json."""
    import math

    cell, noise = job.arms[0].context.cell, job.conditions.noise
    return {
        "orders": list(job.order_files.values()),
        "seeds": list(seeds),
        "cell": cell.name,
        "cell_fingerprint": cell.scene_fingerprint,
        "perception": str(job.conditions.perception),
        "sift": str(job.conditions.sift),
        "pose_noise": {"position_mm": 1e3 * noise.position, "angle_deg": math.degrees(noise.angle)},
        "pod_shift": _shift(job.conditions.pod_shift, job.conditions.reality.pod_shift),
        "tote_shift": _shift(job.conditions.tote_shift, job.conditions.reality.tote_shift),
        "locate_tote": job.conditions.touches_tote,
        "strategy": job.conditions.strategy.name,
        "stow_rule": str(job.conditions.stow_rule),
        "approach": str(job.arms[0].context.settings.approach),
        "drop_from": str(job.arms[0].context.settings.drop_from),
        "reality": job.conditions.reality.as_dict(),
        "inputs": job.inputs,
    }


def _shift(stated: Displacement | str | None, is_random: bool) -> Any:
    """A displacement of pod or tote; is_random: by the levels of reality, if none is stated."""
    from dataclasses import asdict

    from pickcli.trial.pod_shift import NONE, RANDOM

    shift = stated or (RANDOM if is_random else NONE)
    return shift if isinstance(shift, str) else asdict(shift)


def _lines(report: TrialsReport) -> list[str]:
    """Format the most important results."""
    from pickcli.monte_carlo.success_rate import SuccessRate
    from pickcli.monte_carlo.trials_folder import PAGE

    summary = report.summary
    share, rate, clock = summary["score_share"], summary["delivered"], summary["statistics"]
    between = share["mean_interval"]
    within = "" if between is None else f" (95 %: {between[0]:.1%} to {between[1]:.1%})"
    done = SuccessRate(rate["successes"], rate["tries"])
    low, high = done.interval
    return [
        f"{share['n']} trials: {share['mean']:.1%} of the points on average{within}, "
        f"{share['median']:.1%} in the median, {share['min']:.1%} in the worst",
        f"delivered: {done.successes} of {done.tries} targets, {done.share:.1%} "
        f"(95 %: {low:.1%} to {high:.1%})",
        ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in summary["totals"].items()),
        *_times(summary["motion_s"], clock),
        f"failed in {', '.join(f'{stage} {n}' for stage, n in summary['failed_in'].items())}",
        *cause_lines("missed", summary["causes"], "targets", "cause"),
        *(
            [f"and {more} other causes: see {PAGE}"]
            if (more := len(summary["causes"]) - MOST_CAUSES) > 0
            else []
        ),
        *(f"not played: {name}: {why}" for name, why in report.not_stowed.items()),
    ]


def _times(motion: dict[str, Any], clock: dict[str, Any]) -> list[str]:
    """Format times of motion and of planning, if there are any."""
    lines = []
    if motion["n"]:
        lines.append(f"motion for a delivered target: {motion['mean']:.1f} s simulated on average")
    if clock["planning_ms"]["n"]:
        planning, item = clock["planning_ms"], clock["planning_per_item_ms"]
        each = f"; {item['median']:.0f} ms for a delivered target with failed attempts" if item["n"] else ""
        lines.append(
            f"planning: {planning['median']:.0f} ms a plan in the median, {planning['p99']:.0f} ms at the "
            f"99th percentile{each}"
        )
    return lines
