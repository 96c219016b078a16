"""Options that several commands share, and what they refuse before any work."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import click

from pickcli.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_CELL = "apc2016_delft"


def cell_option(function: F) -> F:
    """--cell NAME|PATH."""
    return click.option(
        "--cell", "cell_name", metavar="NAME|DIR", default=DEFAULT_CELL, show_default=True,
        help="Name under data/cells, or the path of a cell's folder.",
    )(function)  # fmt: skip


def seed_option(function: F) -> F:
    """--seed N."""
    return click.option(
        "--seed", type=click.IntRange(0, 2**31 - 1), default=0, show_default=True, metavar="N",
        help="Every random choice follows from it: same seed, same bytes.",
    )(function)  # fmt: skip


def reality_option(function: F) -> F:
    """--reality FILE."""
    return click.option(
        "--reality", "reality_path", type=click.Path(path_type=Path), metavar="FILE",
        help="Levels at which the simulated world differs from its model.  [default: docs/reality.md]",
    )(function)  # fmt: skip


def json_option(function: F) -> F:
    """--json."""
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object to stdout.")(function)


def output_option(what: str) -> Callable[[F], F]:
    """-o FILE with --overwrite."""

    def decorate(function: F) -> F:
        function = overwrite_option(function)
        return click.option(
            "-o", "--output", type=click.Path(path_type=Path), metavar="FILE", required=True,
            help=f"Where to write the {what}.",
        )(function)  # fmt: skip

    return decorate


def overwrite_option(function: F) -> F:
    """--overwrite."""
    return click.option("--overwrite", is_flag=True, help="Replace what exists already.")(function)


def refuse_output(path: Path, overwrite: bool) -> None:
    """Raise InputError, before any work, where the output could not be written in the end."""
    if path.is_dir():
        raise InputError(f"{path}: is a folder; name a file in it")
    if path.exists() and not overwrite:
        raise InputError(f"{path}: exists already; choose another name or add --overwrite")
    if not path.parent.is_dir():
        what = "is a file; move that" if path.parent.exists() else "does not exist; make it first"
        raise InputError(f"{path}: the folder {path.parent} {what}, or name another")
    refuse_unwritable(path.parent, path)


def refuse_unwritable(folder: Path, output: Path, option: str = "-o") -> None:
    """Raise InputError if no file can be made in a folder. Tries it: permissions alone do not tell."""
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{output}: nothing can be written in {folder} ({error.strerror}); name another place with "
            f"{option}"
        ) from None
