"""Progress on stderr: a bar with the time left on a terminal, a line now and then anywhere else."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

import click

from pickcli.commands.logs import stderr_console

LINE_PERIOD = 10.0  # s between two lines where nobody looks at a terminal

Report: TypeAlias = Callable[[int, int, str], None]  # done, total, what happens now


@contextmanager
def progress(label: str) -> Iterator[Report]:
    """Yields ``report(done, total, what)`` for library callbacks; all of it goes to stderr."""
    with _bar(label) if sys.stderr.isatty() else _lines(label) as report:
        yield report


@contextmanager
def terminal_bar(label: str) -> Iterator[Callable[[int, int, float | None, str], None]]:
    """Yields ``show(done, total, seconds_left, what)``: one line that fits, ``what`` cut where need be."""
    from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn
    from rich.table import Column

    whole, rest = Column(no_wrap=True), Column(no_wrap=True, overflow="ellipsis", ratio=1)
    columns = (
        SpinnerColumn(table_column=whole), TextColumn("{task.description}", table_column=whole),
        BarColumn(bar_width=8, table_column=whole),
        TextColumn("{task.fields[state]}", table_column=whole, markup=False),
        TextColumn("{task.fields[what]}", table_column=rest, markup=False),
    )  # fmt: skip
    with Progress(*columns, console=stderr_console(), transient=True, expand=True) as bar:
        task = bar.add_task(label, total=None, state="", what="")

        def show(done: int, total: int, left: float | None, what: str) -> None:
            state = f"{done}/{total}" + ("" if left is None else f", {duration(left)} left")
            bar.update(task, completed=done, total=total, state=state, what=what)

        yield show


def duration(seconds: float) -> str:
    """A time to wait, as precisely as it interests: "95 s", "12 min", "3.5 h"."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 7200.0 else f"{seconds / 3600.0:.1f} h"


@contextmanager
def _bar(label: str) -> Iterator[Report]:
    began = time.monotonic()
    with terminal_bar(label) as show:

        def report(done: int, total: int, what: str = "") -> None:
            show(done, total, _left(done, total, time.monotonic() - began), what)

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
    left = _left(done, total, elapsed)
    told = "" if left is None else f", about {duration(left)} left"
    return f"{label}: {done}/{total}{told}{': ' if what else ''}{what}"


def _left(done: int, total: int, elapsed: float) -> float | None:
    return elapsed * (total - done) / done if 0 < done <= total else None
