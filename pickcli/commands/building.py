"""What the building commands share: who works, progress, and how an interrupted build goes on."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.logs import stage
from pickcli.commands.progress import LINE_PERIOD, duration, terminal_bar
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.jobs.executors import Runner
    from pickcli.jobs.job_run import Means, Progress, Report


@contextmanager
def building(
    label: str, output: Path, jobs: int | None, as_json: bool, scheduler: str | None = None
) -> Iterator[Means]:
    """The means of a build that tells its progress and, where it cannot be finished, how it goes on."""
    from pickcli.jobs.job_run import Means
    from pickcli.jobs.journal import journals

    who = _who_works(jobs, scheduler)
    last: Progress | None = None

    def told(p: Progress) -> None:
        nonlocal last
        last = p
        report(p)

    try:
        with stage(label), build_report(label, as_json) as report:
            yield Means(who, report=told)
    except (KeyboardInterrupt, InputError):
        if last is not None and last.journal is not None and last.journal.exists():
            done = f"{last.n_done} of {last.n_total} tasks are kept in {last.journal}"
            click.echo(f"{done}; the same command goes on from there", err=True)
        raise
    for journal in journals(output):
        click.echo(
            f"note: {journal} is left from an interrupted build with other settings, another cell or another "
            "version; delete it unless that build is to go on",
            err=True,
        )


def _who_works(jobs: int | None, scheduler: str | None) -> Runner:
    from pickcli.jobs.dask_executor import Cluster
    from pickcli.jobs.executors import available_cores, runner

    if scheduler is None:
        return runner(jobs or available_cores())
    if jobs is not None:
        raise click.UsageError("--jobs is of this machine; the scheduler's workers are started beside it")
    return Cluster(scheduler)


@contextmanager
def build_report(label: str, as_json: bool = False) -> Iterator[Report]:
    """Progress on stderr: a line of JSON per task, a bar on a terminal, else a line now and then."""
    if as_json:
        yield _telling_json()
    elif sys.stderr.isatty():
        began = time.monotonic()
        with terminal_bar(label) as show:
            yield lambda p: show(p.n_done, p.n_total, seconds_left(p, time.monotonic() - began), details(p))
    else:
        yield _telling_lines(label)


def _telling_json() -> Report:
    began = time.monotonic()

    def report(p: Progress) -> None:
        left = seconds_left(p, time.monotonic() - began)
        told = {
            "event": "progress", "done": p.n_done, "total": p.n_total, "kept": p.n_kept,
            "failed": p.n_failed, "coverage": round(p.coverage, 4), "task": p.task,
            "seconds_left": None if left is None else round(left, 1),
        }  # fmt: skip
        click.echo(json.dumps(told), err=True)

    return report


def _telling_lines(label: str) -> Report:
    began = said = time.monotonic()

    def report(p: Progress) -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= LINE_PERIOD:
            said = now
            click.echo(f"{label}: {line(p, now - began)}", err=True)

    return report


def line(p: Progress, elapsed: float) -> str:
    """One line of a log, after ``elapsed`` s."""
    left = seconds_left(p, elapsed)
    time_left = "" if left is None else f", about {duration(left)} left"
    return f"{p.n_done}/{p.n_total}{time_left}, {details(p)}"


def details(p: Progress) -> str:
    """Failures, coverage, what is kept from before and the last task."""
    kept = f", {p.n_kept} kept from before" if p.n_kept else ""
    return f"{p.n_failed} failed, coverage {100 * p.coverage:.0f} %{kept}" + (f": {p.task}" if p.task else "")


def seconds_left(p: Progress, elapsed: float) -> float | None:
    """Time left, by the share of the work that was done in ``elapsed`` s; None before the first task was."""
    left = p.effort_total - p.effort_done
    return elapsed * left / p.effort_done if p.effort_done > 0.0 else None
