"""Progress on stderr: a bar with the time left on a terminal, a line now and then anywhere else."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

import click

LINE_PERIOD = 10.0  # s between two lines where nobody looks at a terminal

Report: TypeAlias = Callable[[int, int, str], None]  # done, total, what happens now


@contextmanager
def progress(label: str) -> Iterator[Report]:
    """Yields ``report(done, total, what)`` for library callbacks; all of it goes to stderr."""
    with _bar(label) if sys.stderr.isatty() else _lines(label) as report:
        yield report


@contextmanager
def _bar(label: str) -> Iterator[Report]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (
        TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
        TextColumn("left"), TimeRemainingColumn(), TextColumn("{task.fields[what]}"),
    )  # fmt: skip
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(label, total=None, what="")

        def report(done: int, total: int, what: str = "") -> None:
            bar.update(task, completed=done, total=total, what=what)

        yield report


@contextmanager
def _lines(label: str) -> Iterator[Report]:
    began = said = time.monotonic()

    def report(done: int, total: int, what: str = "") -> None:
        nonlocal said
        now = time.monotonic()
        if now - said >= LINE_PERIOD:
            said = now
            click.echo(progress_line(label, done, total, what, now - began), err=True)

    yield report


def progress_line(label: str, done: int, total: int, what: str, elapsed: float) -> str:
    """One line of a log; ``elapsed`` s give the time left, by the share that is done."""
    left = f", about {elapsed * (total - done) / done:.0f} s left" if 0 < done <= total else ""
    return f"{label}: {done}/{total}{left}{': ' if what else ''}{what}"
