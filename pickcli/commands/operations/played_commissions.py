"""``apc run-trials COMMISSION...``: many trials of commissions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.commands.operations.played_commission import (
    OF_ORDERS,
    commission_cell,
    commission_conditions,
    commission_task,
)
from pickcli.commands.options.people_options import PeopleOptions
from pickcli.commands.options.trial_options import TrialOptions, refuse_options_of_orders
from pickcli.commands.output.trials_output import (
    TrialsFolder,
    cause_lines,
    cell_files,
    content_digest,
    named_files,
    played_trials,
    rate_line,
    stored_files,
)

if TYPE_CHECKING:
    from pickcli.commission.commission_job import CommissionJob


def play_commission_files(
    paths: Sequence[Path], seeds: Sequence[int], folder: TrialsFolder, options: TrialOptions,
    people: PeopleOptions,
) -> None:  # fmt: skip
    """Play trials of commissions, write their folder, and print what came of them.

    Args:
        paths: Files of commissions, or their names under data/tasks.
        seeds: Seeds for each.
        folder: Where and how results are told.
        options: The options of the command.
        people: Those of people in the booth.

    Raises:
        UsageError: An option was stated that applies to orders only.
        InputError: A file cannot be read or written, two have one name, or the cell cannot do what they say.
    """
    from pickcli.commission.commission_job import CommissionJob
    from pickcli.commission.commission_station import HAND
    from pickcli.commission.commission_trials import commission_summary
    from pickcli.hand.hand_file import hand_file
    from pickcli.jobs.job import sources_digest
    from pickcli.page.commission_trials_page import commission_trials_page

    refuse_options_of_orders(OF_ORDERS, "commissions")
    conditions = commission_conditions(options, seeds[0])
    files = named_files(paths, "commission")
    folder.refuse(files, seeds, *files.values(), people.path, *options.inputs)
    played = {name: commission_task(path, options) for name, path in files.items()}
    stored = [
        path for each in played.values()
        for path in stored_files(each.station.cell, options.roadmap, options.trajectories)
    ]  # fmt: skip
    watches = [people.booth_watch(each.station) for each in played.values()]  # all alike, once each is right
    conditions = replace(conditions, watched=watches[0])
    reads = [*files.values(), *stored, *cell_files(commission_cell(options), None), hand_file(HAND)]
    job = CommissionJob(played, conditions, content_digest(reads), sources_digest())
    made_from = _made_from(job, seeds, people)
    report = played_trials(
        job, seeds, folder, options.jobs, made_from, commission_summary, commission_trials_page
    )
    folder.tell(report, _lines(report.summary))


def _made_from(job: CommissionJob, seeds: Sequence[int], people: PeopleOptions) -> dict[str, Any]:
    """Return the parameters of the trials, for trials.json."""
    cell, noise = next(iter(job.commissions.values())).station.cell, job.conditions.noise
    return {
        "commissions": [each.file_name for each in job.commissions.values()],
        "seeds": list(seeds),
        "cell": cell.name,
        "cell_fingerprint": cell.scene_fingerprint,
        "pose_noise": {"position_mm": 1e3 * noise.position, "angle_deg": math.degrees(noise.angle)},
        "strategy": job.conditions.strategy.name,
        "people": people.people,
        "guards": None if people.people is None else people.guards,
        "reality": job.conditions.reality.as_dict(),
        "inputs": job.inputs,
    }


def _lines(summary: Mapping[str, Any]) -> list[str]:
    """Format the most important results."""
    time, handling = summary["duration_s"], summary["handling_s"]
    return [
        f"success: {rate_line(summary['success'], 'commissions')}",
        f"items in place: {rate_line(summary['items_placed'], 'items')}",
        f"time: {time['median']:.0f} s in the median, {time['max']:.0f} s at most; at the load "
        f"{handling['median']:.0f} s in the median, {handling['max']:.0f} s at most",
        ", ".join(f"{name.replace('_', ' ')} {n}" for name, n in summary["totals"].items()),
        *_people(summary["people"]),
        *cause_lines("no success", summary["causes"], "trials", "cause"),
        *cause_lines("failed", summary["failed_steps"], "steps", "why"),
    ]


def _people(people: Mapping[str, Any] | None) -> list[str]:
    """Format what watched drives tell of people."""
    if people is None:
        return []
    braked = people["braked_s"]
    return [
        f"people: {people['number']} came, {people['touched']} touched by the truck, {people['walked_in']} "
        f"walked into it; braked {braked['median']:.1f} s in the median, {braked['max']:.1f} s at most"
    ]
