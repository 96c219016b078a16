"""``apc run-trials STREAM...``: many trials of streams."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.commands.operations.played_stream import bound_lines, paper_lines, refuse_stated, stream_task
from pickcli.commands.options.stream_plan_options import StreamPlanOptions
from pickcli.commands.options.trial_options import TrialOptions
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
    from pickcli.stream_trials.stream_job import StreamJob, StreamTask


def play_stream_files(
    paths: Sequence[Path], seeds: Sequence[int], folder: TrialsFolder, options: TrialOptions,
    planned_by: StreamPlanOptions,
) -> None:  # fmt: skip
    """Play trials of streams, write their folder, and print what came of them.

    Args:
        paths: Files of streams, or their names under data/tasks.
        seeds: Seeds for each.
        folder: Where and how results are told.
        options: The options of the command.
        planned_by: By which rule items are met, and what plans it.

    Raises:
        UsageError: An option was stated that does not apply to streams.
        InputError: A file cannot be read or written, two have one name, or a cell has no place to bring items
            to.
    """
    from pickcli.jobs.job import sources_digest
    from pickcli.page.stream_trials_page import stream_trials_page
    from pickcli.stream_trials.stream_job import StreamJob
    from pickcli.stream_trials.stream_trials import stream_summary

    refuse_stated(options, planned_by)
    files = named_files(paths, "stream")
    folder.refuse(files, seeds, *files.values(), *options.inputs, planned_by.grasps_path)
    streams: dict[str, StreamTask] = {}
    for name, path in files.items():
        streams[name] = stream_task(path, options, planned_by, streams.values())
    cells = {context.cell.fingerprint: context.cell for each in streams.values() for context in each.contexts}
    reads = [
        path for cell in cells.values()
        for path in (
            *cell_files(str(cell.path), options.items_path),
            *stored_files(cell, options.roadmap, options.trajectories),
        )
    ]  # fmt: skip
    reads += [] if planned_by.grasps_path is None else [planned_by.grasps_path]
    job = StreamJob(streams, content_digest({*files.values(), *reads}), sources_digest())
    made_from = _made_from(job, seeds, options)
    report = played_trials(job, seeds, folder, options.jobs, made_from, stream_summary, stream_trials_page)
    folder.tell(report, [*_lines(report.summary), *paper_lines(report.records)])


def _made_from(job: StreamJob, seeds: Sequence[int], options: TrialOptions) -> dict[str, Any]:
    """Return the parameters of the trials, for trials.json."""
    from pickcli.stream_trials.stream_record import planned_by_values
    from pickcli.trial.trial_perception import PerceptionKind

    first = next(iter(job.streams.values())).request
    cells = (each.request.stream.cell for each in job.streams.values())
    return {
        "streams": [each.file_name for each in job.streams.values()],
        "seeds": list(seeds),
        "cells": {cell.name: cell.scene_fingerprint for cell in cells},
        "perception": options.perception or str(PerceptionKind.NOISE),
        "noise": first.noise.figures if first.camera is None else None,
        "speed_error_m_s": first.speed_error if first.camera is None else None,
        "camera": None if first.camera is None else asdict(first.camera),
        "rule": str(first.rule),
        **planned_by_values(next(iter(job.streams.values())).contexts[0]),
        "approach": options.approach,
        "reality": first.reality.as_dict(),
        "inputs": job.inputs,
    }


def _lines(summary: Mapping[str, Any]) -> list[str]:
    """Format the most important results."""
    totals = summary["totals"]
    bad = ("collisions", "limit_violations", "stops")
    return [
        f"delivered: {rate_line(summary['delivered'], 'items that came')}",
        f"of those attempted: {rate_line(summary['delivered_of_attempted'], 'items')}",
        f"{summary['delivered_per_minute']:.1f} delivered a minute",
        ", ".join(f"{key.replace('_', ' ')} {totals[key]}" for key in bad),
        *_met(summary),
        *bound_lines(summary["cost_bound"]),
        *_planning(summary["statistics"]),
        *cause_lines("not attempted", summary["not_attempted"], "items", "why"),
        *cause_lines("lost", summary["lost"], "items", "why"),
    ]


def _met(summary: Mapping[str, Any]) -> list[str]:
    """Format how items were met, if any was."""
    offset, slip = summary["offset_m"], summary["slip_m_s"]
    if offset is None:
        return []
    return [
        f"tool off its place by {1e3 * offset['p95']:.1f} mm and over the item at "
        f"{1e3 * slip['p95']:.1f} mm/s along the belt at the 95th percentile; at worst "
        f"{1e3 * offset['worst']:.1f} mm and {1e3 * slip['worst']:.1f} mm/s"
    ]


def _planning(computing: Mapping[str, Any]) -> list[str]:
    """Format times of planning, if there are any."""
    told = {"planning_ms": "a plan", "refusing_ms": "a refusal"}
    return [
        f"planning: {found['median']:.0f} ms {what} in the median, {found['p99']:.0f} ms at the 99th "
        "percentile"
        for key, what in told.items()
        if (found := computing[key]) is not None
    ]
