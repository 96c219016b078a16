"""Shared by Monte Carlo runs of all kinds: their folder, how they are played, and what they depend on."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import emit_json
from pickcli.commands.operations.building import building
from pickcli.commands.options.common_options import refuse_reading
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.monte_carlo.trials_folder import SeededJob, Summary, TrialsReport
    from pickcli.page.page_document import PageDocument

MOST_CAUSES, MAX_CAUSE = 5, 160  # that are printed, and characters of each; the page lists more


@dataclass(frozen=True)
class TrialsFolder:
    """Where and how the results of a run are told.

    Attributes:
        path: The folder.
        overwrite: Whether its files may be replaced.
        scheduler: Address of a Dask scheduler whose workers play; None for processes of this machine.
        as_json: Whether JSON is printed.
    """

    path: Path
    overwrite: bool
    scheduler: str | None
    as_json: bool

    def refuse(self, names: Iterable[str], seeds: Sequence[int], *inputs: Path | str | None) -> None:
        """Refuse, before any work, a folder that must not be written, or that contains an input.

        Args:
            names: What is played.
            seeds: With these seeds.
            inputs: Files that are read.

        Raises:
            InputError: It is such a folder.
        """
        from pickcli.monte_carlo.interrupted_run import SUMMARY
        from pickcli.monte_carlo.trials_folder import PAGE, refuse_trials_folder

        trials = [f"{name}-{seed}" for name in names for seed in seeds]
        refuse_trials_folder(self.path, self.overwrite, trials)
        for name in (SUMMARY, PAGE):
            refuse_reading(self.path / name, *inputs)

    def tell(self, report: TrialsReport, lines: Sequence[str]) -> None:
        """Print the results, as JSON if that is asked for.

        Args:
            report: The results.
            lines: The most important of them.
        """
        from pickcli.monte_carlo.interrupted_run import SUMMARY
        from pickcli.monte_carlo.trials_folder import PAGE

        if self.as_json:
            emit_json({"path": str(self.path), **report.summary})
            return
        click.echo("\n".join([*lines, *(f"wrote {self.path / name}" for name in (SUMMARY, PAGE))]))


def are_all(paths: Sequence[Path], is_of: Callable[[Path], bool], kind: str) -> bool:
    """Tell whether files are of one kind, or none is.

    Args:
        paths: Files of what is played, or names of them.
        is_of: Whether a file is of the kind.
        kind: The kind, as ``a commission``, for messages.

    Returns:
        True for files of the kind, False for what are none.

    Raises:
        InputError: Some are of the kind, and others are not.
    """
    ours = [path for path in paths if is_of(path)]
    others = [path for path in paths if path not in ours]
    if ours and others:
        raise InputError(
            f"{ours[0]} is {kind} and {others[0]} is not: their figures cannot be summed up; play one kind "
            "at a time"
        )
    return bool(ours)


def named_files(paths: Sequence[Path], kind: str) -> dict[str, Path]:
    """Return the files of what is played.

    Args:
        paths: Their paths, or their names under data/tasks.
        kind: What they are, as ``commission``, for messages.

    Returns:
        The files, by name without suffix.

    Raises:
        InputError: Two have one name.
    """
    from pickcli.cell.data_path import task_file

    files: dict[str, Path] = {}
    for path in paths:
        if path.stem in files:
            raise InputError(f"{path}: a second {kind} of the name {path.stem}; rename it, or name it once")
        files[path.stem] = task_file(path)
    return files


def rate_line(rate: Mapping[str, Any], what: str) -> str:
    """Format a rate with its interval.

    Args:
        rate: The rate, as in ``trials.json``.
        what: What was tried, in the plural.

    Returns:
        The text; "none" if nothing was tried.
    """
    if not rate["tries"]:
        return "none"
    low, high = rate["interval"]
    return (
        f"{rate['successes']} of {rate['tries']} {what}, {rate['share']:.1%} (95 %: {low:.1%} to {high:.1%})"
    )


def cause_lines(what: str, causes: Sequence[Mapping[str, Any]], number: str, cause: str) -> list[str]:
    """Format the most frequent causes, shortened; ``trials.json`` and the page have them whole.

    Args:
        what: What came of it, as ``lost``.
        causes: As in ``trials.json``.
        number: Key of how often each came.
        cause: Key of its text.

    Returns:
        One line each.
    """
    from pickcli.monte_carlo.interrupted_run import SUMMARY

    whole = f" ... (whole in {SUMMARY})"
    return [
        f"{what} {each[number]} times: {shorten(each[cause], MAX_CAUSE, placeholder=whole)}"
        for each in causes[:MOST_CAUSES]
    ]


def played_trials(
    job: SeededJob, seeds: Sequence[int], folder: TrialsFolder, jobs: int | None,
    made_from: Mapping[str, Any], summary: Summary,
    page_of: Callable[[Mapping[str, Mapping[str, Any]]], PageDocument],
) -> TrialsReport:  # fmt: skip
    """Play trials and write their folder. An interrupted run keeps its trials in a journal there.

    Args:
        job: The trials.
        seeds: Seeds for each task.
        folder: The folder.
        jobs: Number of parallel processes; None for one per core.
        made_from: Provenance for ``trials.json``.
        summary: Makes the content of ``trials.json``.
        page_of: Makes the page from the records.

    Returns:
        The results.

    Raises:
        InputError: No trial could be played, or a file cannot be written.
    """
    from pickcli.jobs.job_run import Build
    from pickcli.monte_carlo.interrupted_run import SUMMARY, is_interrupted
    from pickcli.monte_carlo.trials_folder import play_trials, write_trials
    from pickcli.page.html_page import page_bytes

    output = folder.path
    replaced = folder.overwrite or is_interrupted(output)
    is_new = not output.exists()
    output.mkdir(parents=True, exist_ok=True)
    path = output / SUMMARY
    with (
        _removed_if_empty(output, is_new),
        building("playing", path, jobs, folder.as_json, folder.scheduler) as run_options,
    ):
        build = Build(job, replace(run_options, output=path, tells_coverage=False))
        report = play_trials(build, job, seeds, made_from, summary)
        write_trials(output, report, page_bytes(page_of(report.records)), replaced)
        build.finish()
    return report


@contextmanager
def _removed_if_empty(folder: Path, is_new: bool) -> Iterator[None]:
    """Remove a folder that was made for results when there are none."""
    try:
        yield
    finally:
        if is_new and folder.is_dir() and not any(folder.iterdir()):
            folder.rmdir()


def stored_files(cell: Cell, roadmap: Path | None, trajectories: Path | None) -> list[Path]:
    """Return the files of stored motions that a cell plays with.

    Args:
        cell: The cell as seen by its arm.
        roadmap: As stated; None for that of the cache.
        trajectories: Likewise.

    Returns:
        Paths of roadmap and trajectory database.
    """
    from pickcli.precompute.artifact_cache import default_paths

    default = default_paths(cell)
    return [roadmap or default.roadmap, trajectories or default.trajectories]


def cell_files(cell_name: str, items_path: Path | None) -> list[Path]:
    """Return the files that describe a cell and its items.

    Args:
        cell_name: Name or folder of the cell.
        items_path: The user's own items.

    Returns:
        Their paths.
    """
    from pickcli.cell.data_path import data_path

    named = data_path() / "cells" / cell_name
    folder = named if named.is_dir() else Path(cell_name)
    folder = folder if folder.is_dir() else folder.parent
    own = (
        [] if items_path is None else [items_path] if items_path.is_file() else [*items_path.rglob("*.yaml")]
    )
    return [*folder.rglob("*.yaml"), *folder.rglob("*.urdf"), *(data_path() / "items").rglob("*.yaml"), *own]


def content_digest(paths: Iterable[Path]) -> str:
    """Compute the SHA-256 of the contents of files, independent of their folders.

    Args:
        paths: The files; those that do not exist are left out.

    Returns:
        The digest.
    """
    contents = sorted(hashlib.sha256(path.read_bytes()).hexdigest() for path in paths if path.is_file())
    return hashlib.sha256("".join(contents).encode()).hexdigest()
