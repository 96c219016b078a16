"""The folder of a Monte Carlo run: a folder of each trial, and what they have in common in ``trials.json``.

docs/formats/trials.md describes it. Everything by the clock on the wall stands under ``statistics``.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes, write_text
from pickcli.files.bounded_reading import read_kind
from pickcli.files.file_kind import TRIALS
from pickcli.jobs.job import Key
from pickcli.jobs.job_run import Build
from pickcli.jobs.journal import journals
from pickcli.trial.trial_folder import refuse_existing_folder
from pickcli.trial.trial_job import TrialJob, files_of
from pickcli.trial.trial_record import read_record
from pickcli.trial.trial_statistics import Record, TrialStatistics, score_share

FORMAT, VERSION = "apc-trials", 1
SUMMARY, PAGE, RECORD = "trials.json", "trials.html", "trial.json"
_COUNTED = ("score", "max_score", "items_in_tote", "collisions", "limit_violations", "drops", "disturbed",
            "misjudged", "aborted", "clock_s", "simulated_s")  # fmt: skip


@dataclass(frozen=True, eq=False)
class TrialsReport:
    """What a Monte Carlo run found.

    Attributes:
        files: Contents of the files of each trial's folder, by name, by the name of the folder.
        records: What each ``trial.json`` says, by the name of the trial's folder.
        not_stowed: Why trials could not be played, by the name that their folder would have had.
        summary: What ``trials.json`` says.
    """

    files: Mapping[str, Mapping[str, bytes]]
    records: Mapping[str, Record]
    not_stowed: Mapping[str, str]
    summary: Mapping[str, Any]


def refuse_trials_folder(folder: Path, overwrite: bool) -> None:
    """Refuse a folder, before any work, in which the results could not be written in the end.

    A folder with nothing in it but the journal of an interrupted run is taken.

    Args:
        folder: The folder, which need not exist.
        overwrite: Whether files that are there may be replaced.

    Raises:
        InputError: It is a file, has other files and must not be overwritten, or cannot be written.
    """
    kept = set(journals(folder / SUMMARY)) if folder.is_dir() else set()
    only_kept = bool(kept) and kept == set(folder.iterdir())
    refuse_existing_folder(folder, overwrite or only_kept)


def play_trials(
    build: Build, job: TrialJob, seeds: Sequence[int], made_from: Mapping[str, Any]
) -> TrialsReport:
    """Play what is not played yet.

    Args:
        build: Who plays, and where what is played is kept.
        job: The trials.
        seeds: Seeds that each order is played with.
        made_from: What ``trials.json`` tells of how it was made.

    Returns:
        What was found; nothing is written yet.

    Raises:
        InputError: No trial could be played.
    """
    keys = job.keys(seeds)
    results = sorted(zip(map(trial_name, keys), build.records(keys), strict=True), key=lambda each: each[0])
    files = {name: files_of(result) for name, result in results if result.reason is None}
    why = {name: result.reason.detail for name, result in results if result.reason is not None}
    if not files:
        raise InputError(f"no trial could be played: {next(iter(why.values()))}; name other orders")
    records = {name: json.loads(contents[RECORD]) for name, contents in files.items()}
    return TrialsReport(files, records, why, _summary(records, why, made_from))


def write_trials(folder: Path, report: TrialsReport, page: bytes, replace: bool) -> None:
    """Write the folder of each trial, the page, and the summary last.

    Args:
        folder: Where to write; it is there.
        report: What was found.
        page: The page as HTML.
        replace: Whether files that are there may be replaced.

    Raises:
        InputError: A file cannot be written.
    """
    for name, files in report.files.items():
        (folder / name).mkdir(exist_ok=True)
        for file, content in files.items():
            write_bytes(folder / name / file, content, replace)
    write_bytes(folder / PAGE, page, replace)
    write_text(folder / SUMMARY, json.dumps(report.summary, indent=2, allow_nan=False) + "\n", replace)


def trial_name(key: Key) -> str:
    """Name of the folder of a trial.

    Args:
        key: The task.

    Returns:
        Order and seed with a hyphen.
    """
    return "-".join(key)


def require_folder(folder: Path) -> None:
    """Refuse what is no folder.

    Args:
        folder: Where trials should be.

    Raises:
        InputError: It is a file, or nothing.
    """
    if folder.is_dir():
        return
    if not folder.exists():
        raise InputError(f"{folder}: no such folder; {TRIALS.origin}")
    kind = read_kind(folder)
    found = "is a file" if kind is None else f"is {kind.name}"
    raise InputError(f"{folder}: {found}, but {TRIALS.name} is wanted here ({TRIALS.origin})")


def read_trials(folder: Path) -> dict[str, dict[str, Any]]:
    """Read the records of all trials in a folder.

    Args:
        folder: With a folder for each trial, as ``run-trials`` or several ``run-trial`` leave it.

    Returns:
        What each ``trial.json`` says, by the name of its folder, sorted.

    Raises:
        InputError: There is no trial in it, or a record cannot be read.
        StaleError: A record is of another version.
    """
    require_folder(folder)
    records = {path.parent.name: read_record(path) for path in sorted(folder.glob(f"*/{RECORD}"))}
    if not records:
        raise InputError(f"{folder}: no trials in it (no */{RECORD}); apc run-trials makes such a folder")
    return records


def _summary(
    records: Mapping[str, Record], not_stowed: Mapping[str, str], made_from: Mapping[str, Any]
) -> dict[str, Any]:
    told = TrialStatistics(records)
    return {
        **told.values(),
        "trials": [_line(name, record) for name, record in records.items()],
        "not_stowed": dict(not_stowed),
        "made_from": {"format": FORMAT, "version": VERSION, **made_from},
        "statistics": told.computing(),
    }


def _line(name: str, record: Record) -> dict[str, Any]:
    made = record["made_from"]
    figures = {key: record[key] for key in _COUNTED}
    share, n = round(score_share(record), 6), len(record["items"])
    return {"trial": name, "order": made["order"], "seed": made["seed"], "score_share": share, "targets": n,
            **figures}  # fmt: skip
