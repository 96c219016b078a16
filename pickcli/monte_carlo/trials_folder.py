"""Folder of a Monte Carlo run: a folder for each trial, and a summary in ``trials.json``.

See docs/formats/trials.md. All wall-clock figures are under ``statistics``.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from pickcli.errors import InputError, StaleError
from pickcli.files.atomic_write import write_bytes, write_text
from pickcli.files.bounded_reading import read_kind, read_text
from pickcli.files.file_kind import TRIALS
from pickcli.files.json_reader import parse_json
from pickcli.jobs.job import Job, Key
from pickcli.jobs.job_run import Build
from pickcli.jobs.journal import journals
from pickcli.monte_carlo.interrupted_run import SUMMARY, is_interrupted, refuse_interrupted
from pickcli.monte_carlo.packed_folder import files_of
from pickcli.monte_carlo.trial_statistics import Record, TrialStatistics, score_share
from pickcli.trial.trial_folder import refuse_existing_folder
from pickcli.trial.trial_record import read_record

FORMAT, VERSION = "apc-trials", 1
PAGE, RECORD = "trials.html", "trial.json"
MAX_SUMMARY = 64 * 2**20  # bytes of a trials.json
_COUNTED = ("score", "max_score", "items_in_tote", "collisions", "limit_violations", "drops", "disturbed",
            "misjudged", "aborted", "clock_s", "simulated_s")  # fmt: skip


@dataclass(frozen=True, eq=False)
class TrialsReport:
    """Results of a Monte Carlo run.

    Attributes:
        files: File contents by name, by name of the trial's folder.
        records: Content of each ``trial.json``, by name of the trial's folder.
        not_stowed: Why trials could not be played, by the name that their folder would have had.
        summary: Content of ``trials.json``.
    """

    files: Mapping[str, Mapping[str, bytes]]
    records: Mapping[str, Record]
    not_stowed: Mapping[str, str]
    summary: Mapping[str, Any]


class SeededJob(Job, Protocol):
    """Trials as jobs: one per task and seed, whose results are the files of the trial's folder."""

    def keys(self, seeds: Sequence[int]) -> list[Key]:
        """List the keys of all combinations of tasks and seeds.

        Args:
            seeds: Seeds for each task.

        Returns:
            Keys, each a name and a seed.
        """


Summary = Callable[[Mapping[str, Record], Mapping[str, str], Mapping[str, Any]], dict[str, Any]]


def refuse_trials_folder(folder: Path, overwrite: bool, trials: Iterable[str] = ()) -> None:
    """Refuse a folder, before any work, if the results could not be written there.

    A folder with the journal of an interrupted run is accepted, which may have begun to write it.

    Args:
        folder: The folder, which need not exist.
        overwrite: Whether existing files may be replaced.
        trials: Names of the folders of the run's trials.

    Raises:
        InputError: It is a file, has other files and may not be overwritten, or cannot be written.
    """
    is_ours = is_interrupted(folder)
    if is_ours:
        ours = {SUMMARY, PAGE, *trials, *(path.name for path in journals(folder / SUMMARY))}
        is_ours = all(path.name in ours for path in folder.iterdir())
    refuse_existing_folder(folder, overwrite or is_ours)


def play_trials(
    build: Build, job: SeededJob, seeds: Sequence[int], made_from: Mapping[str, Any], summary: Summary
) -> TrialsReport:
    """Play the trials that have not been played yet.

    Args:
        build: Runs the jobs and stores their results.
        job: The trials.
        seeds: Seeds for each order.
        made_from: Provenance for ``trials.json``.
        summary: Makes the content of ``trials.json`` from records, why others were not played, and
            provenance.

    Returns:
        The results, which are not written yet.

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
    return TrialsReport(files, records, why, summary(records, why, made_from))


def write_trials(folder: Path, report: TrialsReport, page: bytes, replace: bool) -> None:
    """Write the folder of each trial, then the page, and the summary last.

    Args:
        folder: The folder, which must exist.
        report: The results.
        page: The page as HTML.
        replace: Whether existing files may be replaced.

    Raises:
        InputError: A file cannot be written.
    """
    if replace:
        (folder / SUMMARY).unlink(missing_ok=True)  # it is about other trials than those that follow
    for name, files in report.files.items():
        _make_folder(folder / name)
        for file, content in files.items():
            write_bytes(folder / name / file, content, replace)
    write_bytes(folder / PAGE, page, replace)
    write_text(folder / SUMMARY, json.dumps(report.summary, indent=2, allow_nan=False) + "\n", replace)


def _make_folder(path: Path) -> None:
    """Make a folder if there is none, again if those above it were removed meanwhile. Raises InputError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: cannot be made: {error.strerror}; mend that and run the same command again"
        ) from None


def trial_name(key: Key) -> str:
    """Return the name of a trial's folder.

    Args:
        key: The job's key.

    Returns:
        Order and seed joined by a hyphen.
    """
    return "-".join(key)


def require_folder(folder: Path) -> None:
    """Refuse a path that is not a folder.

    Args:
        folder: The path.

    Raises:
        InputError: It is a file, or does not exist.
    """
    if folder.is_dir():
        return
    if not folder.exists():
        raise InputError(f"{folder}: no such folder; {TRIALS.origin}")
    kind = read_kind(folder)
    found = "is a file" if kind is None else f"is {kind.name}"
    raise InputError(f"{folder}: {found}, but {TRIALS.name} is expected here ({TRIALS.origin})")


def read_trials(folder: Path) -> dict[str, dict[str, Any]]:
    """Read the records of all trials in a folder.

    Args:
        folder: A folder with one folder per trial, as written by ``run-trials`` or several ``run-trial``.

    Returns:
        Content of each ``trial.json``, by the name of its folder, sorted.

    Raises:
        InputError: It contains no trial, or a record cannot be read.
        StaleError: A record has another version of the format.
    """
    return read_records(folder, read_record)


def read_records(folder: Path, read: Callable[[Path], dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Read the records of all trials in a folder, which have to be those that its ``trials.json`` lists.

    Args:
        folder: The folder.
        read: Reads a ``trial.json``.

    Returns:
        Content of each, by the name of its folder, sorted.

    Raises:
        InputError: It contains no trial, or a record cannot be read.
        StaleError: A record is of another seed than is listed.
    """
    records = {path.parent.name: read(path) for path in record_paths(folder)}
    seeds = _listed(folder / SUMMARY) if (folder / SUMMARY).is_file() else {}
    for name, seed in seeds.items():
        if seed is not None and (stated := records[name]["made_from"].get("seed")) != seed:
            raise StaleError(
                f"{folder / name / RECORD}: is of seed {stated}, and {SUMMARY} lists it with seed {seed}; "
                "play the trials again with --overwrite"
            )
    return records


def record_paths(folder: Path) -> list[Path]:
    """Find the records of the trials that a folder is about.

    These are the trials that its ``trials.json`` lists: others may be left of a run that was overwritten.
    Without that file, as several ``run-trial`` leave a folder, they are all that are there.

    Args:
        folder: The folder.

    Returns:
        Paths of the ``trial.json`` files, sorted by the names of their folders; at least one.

    Raises:
        InputError: It is no folder, or has no such trials: it is that of an interrupted run, or of a single
            trial; or a trial that is listed is not there.
    """
    require_folder(folder)
    if (folder / SUMMARY).is_file():
        paths = [folder / name / RECORD for name in _listed(folder / SUMMARY)]
        if missing := next((path for path in paths if not path.is_file()), None):
            what = f"{folder / SUMMARY}: lists the trial {missing.parent.name}, which has no {RECORD} there"
            raise InputError(f"{what}; play it again with --overwrite")
        return paths
    refuse_interrupted(folder)
    if paths := sorted(folder.glob(f"*/{RECORD}")):
        return paths
    if (folder / RECORD).is_file():
        raise InputError(
            f"{folder}: is the folder of a single trial; name a folder that has several in it, as apc "
            "run-trials makes it"
        )
    raise InputError(f"{folder}: no trials in it (no */{RECORD}); apc run-trials makes such a folder")


def _listed(path: Path) -> dict[str, Any]:
    """Return the seeds of the trials that a ``trials.json`` lists, by name, sorted. Raises InputError."""
    content = parse_json(read_text(path, MAX_SUMMARY), str(path))
    lines = content.get("trials") if isinstance(content, dict) else None
    lines = lines if isinstance(lines, list) else []
    names = [line.get("trial") if isinstance(line, dict) else None for line in lines]
    if not names or not all(isinstance(name, str) and _is_beside(name) for name in names):
        raise InputError(f"{path}: lists no trials; play them again with --overwrite")
    seeds = {str(line["trial"]): line.get("seed") for line in lines}
    return {name: seeds[name] for name in sorted(seeds)}


def _is_beside(name: str) -> bool:
    """Tell whether a name is that of a folder beside the file, and not of a place outside."""
    return name not in ("", "..") and Path(name).name == name


def order_summary(
    records: Mapping[str, Record], not_stowed: Mapping[str, str], made_from: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the content of ``trials.json`` for trials of orders.

    Args:
        records: Content of each ``trial.json``, by name of the trial's folder.
        not_stowed: Why trials could not be played, by the name that their folder would have had.
        made_from: Provenance.

    Returns:
        JSON values; those that depend on wall time are under ``statistics``.
    """
    statistics = TrialStatistics(records)
    return {
        **statistics.values(),
        "trials": [_line(name, record) for name, record in records.items()],
        "not_stowed": dict(not_stowed),
        "made_from": {"format": FORMAT, "version": VERSION, **made_from},
        "statistics": statistics.computing(),
    }


def _line(name: str, record: Record) -> dict[str, Any]:
    made = record["made_from"]
    figures = {key: record[key] for key in _COUNTED}
    share, n = round(score_share(record), 6), len(record["items"])
    return {"trial": name, "order": made["order"], "seed": made["seed"], "score_share": share, "targets": n,
            **figures}  # fmt: skip
