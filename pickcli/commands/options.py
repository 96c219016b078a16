"""Options that several commands share, and the two ways they report."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

import click

from pickcli.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_CELL = "apc2016_delft"


def cell_option(function: F) -> F:
    """--cell NAME|PATH."""
    return click.option(
        "--cell", "cell_name", default=DEFAULT_CELL, show_default=True,
        help="Name under data/cells, or the path of a cell's folder.",
    )(function)  # fmt: skip


def seed_option(function: F) -> F:
    """--seed N."""
    return click.option(
        "--seed", type=click.IntRange(0, 2**31 - 1), default=0, show_default=True,
        help="Every random choice follows from it: same seed, same bytes.",
    )(function)  # fmt: skip


def json_option(function: F) -> F:
    """--json."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object to stdout.")(function)


def output_option(required: bool = True, what: str = "file") -> Callable[[F], F]:
    """-o PATH with --overwrite."""

    def decorate(function: F) -> F:
        function = click.option("--overwrite", is_flag=True, help="Replace an existing output.")(function)
        return click.option(
            "-o", "--output", type=click.Path(path_type=Path), required=required,
            help=f"Where to write the {what}.",
        )(function)  # fmt: skip

    return decorate


def scene_option(function: F) -> F:
    """--scene FILE."""
    return click.option(
        "--scene", "scene_path", type=click.Path(path_type=Path), required=True,
        help="Scene file (see apc make-scene).",
    )(function)  # fmt: skip


def refuse_existing(path: Path, overwrite: bool) -> None:
    """Raise InputError when ``path`` exists and may not be replaced, or its folder does not exist."""
    if path.exists() and not overwrite:
        raise InputError(f"{path}: exists already; choose another name or add --overwrite")
    if not path.parent.exists():
        raise InputError(f"{path}: the folder {path.parent} does not exist; create it first")


def emit_json(value: Any) -> None:
    """One JSON object on stdout, keys in the order given."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))


@contextmanager
def progress(label: str) -> Iterator[Callable[[int, int, str], None]]:
    """A bar with the time left on stderr; yields ``report(done, total, what)`` for library callbacks."""
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
