"""Shared by the building commands: executors, progress, and notes on how to continue an interrupted build."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.logs import stage
from pickcli.commands.output.progress_bar import progress
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.jobs.executors import Executor
    from pickcli.jobs.job_run import BuildObserver, BuildProgress, RunOptions


@contextmanager
def building(
    label: str, output: Path, jobs: int | None, as_json: bool, scheduler: str | None = None
) -> Iterator[RunOptions]:
    """Provide the options of a build that shows its progress and, if interrupted, how to continue it.

    Args:
        label: Name of the build, for the progress.
        output: The file that is built.
        jobs: Number of parallel processes; None for one per core.
        as_json: Whether progress is printed as JSON.
        scheduler: Address of a Dask scheduler whose workers run the tasks; None for processes of this
            machine.

    Yields:
        Executor of the tasks, and observer of the progress.

    Raises:
        UsageError: Both ``jobs`` and ``scheduler`` are given.
    """
    from pickcli.jobs.job_run import RunOptions
    from pickcli.jobs.journal import journals

    who = _who_works(jobs, scheduler)
    last: BuildProgress | None = None

    def note_last(p: BuildProgress) -> None:
        nonlocal last
        last = p
        report(p)

    try:
        with stage(label), build_report(label, as_json) as report:
            yield RunOptions(who, report=note_last)
    except (KeyboardInterrupt, InputError) as stop:
        if last is not None and last.journal is not None and last.journal.exists():
            done = f"{last.done:.0f} of {last.total:.0f} tasks are kept in {last.journal}"
            when = "once that is mended, " if isinstance(stop, InputError) else ""
            stop.add_note(f"{done}; {when}run the same command again to continue")
        raise
    for journal in journals(output):
        click.echo(
            f"note: {journal} is left from an interrupted build with other settings, another cell or another "
            "version; delete it unless you want to continue that build",
            err=True,
        )


def _who_works(jobs: int | None, scheduler: str | None) -> Executor:
    from pickcli.jobs.dask_executor import DaskExecutor
    from pickcli.jobs.executors import available_cores, runner

    if scheduler is None:
        return runner(jobs or available_cores())
    if jobs is not None:
        raise click.UsageError(
            "--jobs is for this machine; the workers of a scheduler are started separately"
        )
    return DaskExecutor(scheduler)


@contextmanager
def build_report(label: str, as_json: bool = False) -> Iterator[BuildObserver]:
    """Show progress on stderr: a line of JSON per task, a bar on a terminal, else a line from time to time.

    Args:
        label: Name of the work.
        as_json: Whether to print lines of JSON.

    Yields:
        Observer of the progress.
    """
    if as_json:
        yield _json_observer()
    else:
        with progress(label) as observer:
            yield observer


def _json_observer() -> BuildObserver:
    began = time.monotonic()

    def report(p: BuildProgress) -> None:
        left = p.seconds_left(time.monotonic() - began)
        values = {
            "event": "progress", "done": p.done, "total": p.total, "kept": p.n_kept,
            "failed": p.n_failed, "coverage": round(p.coverage, 4), "task": p.what,
            "seconds_left": None if left is None else round(left, 1),
        }  # fmt: skip
        click.echo(json.dumps(values), err=True)

    return report
