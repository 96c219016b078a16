"""Progress on stderr: a bar with the remaining time on a terminal, else a line from time to time."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

import click

from pickcli.commands.logs import stderr_console
from pickcli.progress import Progress, ProgressObserver

LINE_PERIOD = 10.0  # s between two lines if stderr is not a terminal


@contextmanager
def progress(label: str) -> Iterator[ProgressObserver]:
    """Show progress on stderr.

    Args:
        label: Name of the work.

    Yields:
        Observer of the progress.
    """
    with _bar(label) if sys.stderr.isatty() else _lines(label) as observer:
        yield observer


@contextmanager
def _bar(label: str) -> Iterator[ProgressObserver]:
    """Show one line on a terminal, truncated if it is too long."""
    from rich.progress import BarColumn, SpinnerColumn, TextColumn
    from rich.progress import Progress as Bar
    from rich.table import Column

    whole, rest = Column(no_wrap=True), Column(no_wrap=True, overflow="ellipsis", ratio=1)
    columns = (
        SpinnerColumn(table_column=whole), TextColumn("{task.description}", table_column=whole),
        BarColumn(bar_width=8, table_column=whole),
        TextColumn("{task.fields[state]}", table_column=whole, markup=False),
        TextColumn("{task.fields[what]}", table_column=rest, markup=False),
    )  # fmt: skip
    with Bar(*columns, console=stderr_console(), transient=True, expand=True) as bar:
        task = bar.add_task(label, total=None, state="", what="")

        began = time.monotonic()

        def show(progress: Progress, /) -> None:
            left = progress.seconds_left(time.monotonic() - began)
            state = _state(progress) + ("" if left is None else f", {duration(left)} left")
            bar.update(task, completed=progress.done, total=progress.total, state=state, what=progress.detail)

        yield show


def duration(seconds: float) -> str:
    """Format a waiting time with suitable precision: "95 s", "12 min", "3.5 h".

    Args:
        seconds: The time, s.

    Returns:
        The text.
    """
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


@contextmanager
def _lines(label: str) -> Iterator[ProgressObserver]:
    """Print a line from time to time, also while nothing new is reported."""
    began = said = time.monotonic()
    latest: Progress | None = None
    has_ended = Event()

    def say() -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= LINE_PERIOD:
            said = now
            elapsed = now - began
            line = (
                f"{label}: {duration(elapsed)}" if latest is None else progress_line(label, latest, elapsed)
            )
            click.echo(line, err=True)

    def report(progress: Progress, /) -> None:
        nonlocal latest
        latest = progress
        say()

    def beat() -> None:
        while not has_ended.wait(LINE_PERIOD):
            say()

    beating = Thread(target=beat, daemon=True)
    beating.start()
    try:
        yield report
    finally:
        has_ended.set()
        beating.join()


def progress_line(label: str, progress: Progress, elapsed: float) -> str:
    """Format one line of a log.

    Args:
        label: Name of the work.
        progress: Current progress.
        elapsed: s since the start.

    Returns:
        The line.
    """
    left = progress.seconds_left(elapsed)
    time_left = "" if left is None else f", about {duration(left)} left"
    detail = progress.detail
    return f"{label}: {_state(progress)}{time_left}{': ' if detail else ''}{detail}"


def _state(progress: Progress) -> str:
    """Format done and total in whole units."""
    return f"{progress.done:.0f}/{progress.total:.0f}"
