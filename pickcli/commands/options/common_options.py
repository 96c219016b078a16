"""Options that several commands share, and checks of them before any work."""

from __future__ import annotations

import difflib
import os
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar, cast

import click

from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.errors import InputError
from pickcli.name_suggestion import suggestion

F = TypeVar("F", bound=Callable[..., Any])

DEFAULT_CELL = "apc2016_delft"
CELL_HELP = "Cell: a name under data/cells, or a cell's folder."
CELL_SUFFIXES = (".yaml", ".urdf")  # suffixes of the files that describe a cell


def passed_as(name: str, of: type[Any]) -> Callable[[F], F]:
    """Pass several parameters to a command as one value.

    Args:
        name: Name of the parameter that the command takes instead.
        of: A dataclass; its fields have the names of the parameters of click.

    Returns:
        A decorator, to be applied before those that add the options.
    """

    def decorate(function: F) -> F:
        @wraps(function)
        def called(**values: Any) -> Any:
            value = of(**{field.name: values.pop(field.name) for field in fields(of)})
            return function(**values, **{name: value})

        return cast(F, called)

    return decorate


def cell_option(function: F) -> F:
    """Give a command the option --cell NAME|FOLDER.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--cell", "cell_name", metavar="NAME|FOLDER", default=DEFAULT_CELL, show_default=True,
        help=CELL_HELP,
    )(function)  # fmt: skip


def items_option(function: F) -> F:
    """Give a command the option --items FILE|FOLDER.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--items", "items_path", type=PATH, metavar="FILE|FOLDER",
        help="Your own items, in addition to those of the package (docs/how-to/my-item.md).",
    )(function)  # fmt: skip


def order_argument(function: F) -> F:
    """Give a command the argument ORDER, the path of a file or the name of one under data/tasks.

    Args:
        function: The command.

    Returns:
        The command with the argument.
    """
    return click.argument(
        "order_path", metavar="ORDER", type=click.Path(readable=False), callback=_named_order
    )(function)


def optional_order_argument(function: F) -> F:
    """Give a command the argument ORDER, which may be left out.

    Args:
        function: The command.

    Returns:
        The command with the argument.
    """
    return click.argument(
        "order_path",
        metavar="[ORDER]",
        type=click.Path(readable=False),
        callback=_named_order,
        required=False,
    )(function)


def _named_order(_: click.Context, __: click.Parameter, text: str | None) -> Path | None:
    """Return the path. An empty one, which would mean the current folder, raises InputError."""
    from pickcli.trial.order_file import order_names

    if text is None:
        return None
    if not text:
        raise InputError(
            f"no order is named; give the path of a JSON file, or one of {', '.join(order_names())}"
        )
    return Path(text)


def seed_option(function: F) -> F:
    """Give a command the option --seed N.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--seed", type=NumberType(0, 2**31 - 1), default=0, show_default=True, metavar="N",
        help="Seed of all random choices: same seed, same bytes.",
    )(function)  # fmt: skip


def reality_option(function: F) -> F:
    """Give a command the option --reality FILE.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--reality", "reality_path", type=PATH, metavar="FILE",
        help="Levels at which the simulated world differs from its model.  [default: docs/reality.md]",
    )(function)  # fmt: skip


def stow_rule_option(function: F) -> F:
    """Give a command the option --stow-rule points|size.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--stow-rule", type=click.Choice(["points", "size"], case_sensitive=False), default="points",
        show_default=True,
        help="Smallest items first, into the bins with most points, or largest into largest bins (KTH).",
    )(function)  # fmt: skip


def approach_option(function: F) -> F:
    """Give a command the option --approach lines|region|reactive|lines-then-region.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    from pickcli.planning.pick_settings import GraspApproach

    return click.option(
        "--approach", type=click.Choice([str(each) for each in GraspApproach], case_sensitive=False),
        default=str(GraspApproach.LINES), show_default=True,
        help="Where grasps come from: fixed candidates on every face, a region query into the item's "
             "envelopes (APPLE), that with a transit that a controller rolls out, or that where no fixed "
             "candidate succeeds.",
    )(function)  # fmt: skip


def drop_from_option(default: str) -> Callable[[F], F]:
    """Give a command the option --drop-from inside|rim.

    Args:
        default: What holds if it is not stated.

    Returns:
        Decorator of the command.
    """
    from pickcli.planning.pick_settings import DropPlace

    return click.option(
        "--drop-from", type=click.Choice([str(each) for each in DropPlace], case_sensitive=False),
        default=default, show_default=True,
        help="From where items are dropped into a tote: low between its walls, or from over its rim where "
             "that is at most 0.28 m high, which takes a second less.",
    )  # fmt: skip


def strategy_option(function: F) -> F:
    """Give a command the option --strategy NAME|FILE.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--strategy", "strategy_name", metavar="NAME|FILE", default="points", show_default=True,
        help="Strategy that decides what is tried next; apc show-strategy lists them.",
    )(function)  # fmt: skip


def json_option(function: F) -> F:
    """Give a command the option --json.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option("--json", "as_json", is_flag=True, help="Print one JSON object to stdout.")(function)


def output_option(what: str) -> Callable[[F], F]:
    """Give a command the options -o FILE and --overwrite.

    Args:
        what: Name of the output.

    Returns:
        A decorator that adds the options.
    """

    def decorate(function: F) -> F:
        function = overwrite_option(function)
        return click.option(
            "-o", "--output", type=PATH, metavar="FILE", required=True,
            help=f"Where to write the {what}.",
        )(function)  # fmt: skip

    return decorate


def overwrite_option(function: F) -> F:
    """Give a command the option --overwrite.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option("--overwrite", is_flag=True, help="Replace existing files.")(function)


def refuse_output(path: Path, overwrite: bool, *inputs: Path | str | None) -> None:
    """Refuse, before any work, an output that could not be written.

    Args:
        path: The output.
        overwrite: Whether an existing file may be replaced.
        *inputs: Files that the command reads (a cell by its folder or name); they are never replaced.

    Raises:
        InputError: The output cannot be written, exists, or is an input.
    """
    from pickcli.files.bounded_reading import refuse_special_file

    try:
        if path.is_dir():
            raise InputError(f"{path}: is a folder; name a file in it")
        refuse_special_file(path)
        if path.exists() and not overwrite:
            raise InputError(f"{path}: exists already; choose another name or add --overwrite")
        refuse_reading(path, *inputs)
        if not path.parent.is_dir():
            what = "is a file; move that" if path.parent.exists() else "does not exist; make it first"
            raise InputError(f"{path}: the folder {path.parent} {what}, or name another")
    except OSError as error:  # e.g. a name that is too long
        raise InputError(f"{path}: cannot be written: {error.strerror}; name another file") from None
    target = Path(os.path.realpath(path))
    refuse_unwritable(target.parent, path)


def refuse_reading(path: Path, *inputs: Path | str | None) -> None:
    """Refuse an output that is, or links to, an input.

    Args:
        path: The output.
        *inputs: Files that the command reads (a cell by its folder or name); None for an option not given.

    Raises:
        InputError: The output is an input.
    """
    if not path.exists():
        return
    for read in _files(inputs):
        if read.exists() and path.samefile(read):
            raise InputError(f"{path}: is an input of this command ({read}); name another file")


def refuse_same(*outputs: Path) -> None:
    """Refuse two outputs that are the same file, also through links.

    Args:
        *outputs: All outputs of the command.

    Raises:
        InputError: Two of them are the same.
    """
    by_target: dict[str, Path] = {}
    for output in outputs:
        first = by_target.setdefault(os.path.realpath(output), output)
        if first is not output:
            raise InputError(f"{output}: would be written twice, also as {first}; name two files")


def refuse_missing(path: Path, suffixes: Collection[str] = (), tasks: Collection[str] = ()) -> None:
    """Refuse a path that does not exist and is not the name of a cell either, with a suggestion.

    Args:
        path: A file, or the name or folder of a cell.
        suffixes: Suffixes of files that may be suggested.
        tasks: Names of tasks that may be suggested.

    Raises:
        InputError: The path does not exist.
    """
    from pickcli.cell.cell_file import cell_names

    known = cell_names()
    if path.exists() or str(path) in known:
        return
    beside = sorted(path.parent.iterdir()) if path.parent.is_dir() else []
    known += [str(each) for each in beside if (each / "cell.yaml").is_file()]
    files = [str(each) for each in beside if each.suffix in suffixes]
    known += difflib.get_close_matches(str(path), [*files, *tasks])
    of = "cell or task" if tasks else "cell"
    raise InputError(f"{path}: no such file, and no {of} of that name; {suggestion(str(path), known)}")


@contextmanager
def of_file(path: Path) -> Iterator[None]:
    """Add the file to the message of an InputError raised in the context.

    Args:
        path: The file.

    Yields:
        Nothing, once.

    Raises:
        InputError: As raised inside, with the file.
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


@contextmanager
def advised(advice: str) -> Iterator[None]:
    """Add what else the user of a command may do to the message of an InputError raised in the context.

    Args:
        advice: The advice, which may name options, as libraries do not know any.

    Yields:
        Nothing, once.

    Raises:
        InputError: As raised inside, with the advice.
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{error}{advice}") from None


def _files(inputs: Sequence[Path | str | None]) -> Iterator[Path]:
    """Yield the files that a command reads; for a cell all that describe it, else those near the top."""
    from pickcli.cell.data_path import data_path

    for each in (name for name in inputs if name is not None):
        named = data_path() / "cells" / each
        folder = named if isinstance(each, str) and named.is_dir() else Path(each)
        if folder.is_dir():
            patterns = ("**/*",) if (folder / "cell.yaml").is_file() else ("*", "*/*")
            found = (file for pattern in patterns for file in folder.glob(pattern))
            yield from (file for file in found if file.suffix in CELL_SUFFIXES)
        else:
            yield folder


def refuse_unwritable(folder: Path, output: Path, option: str = "-o") -> None:
    """Refuse a folder in which no file can be created. Tries it, because permissions are not sufficient.

    Args:
        folder: The folder.
        output: The output, for the message.
        option: The option that names another place, for the message.

    Raises:
        InputError: Nothing can be written in the folder.
    """
    import tempfile

    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(
            f"{output}: nothing can be written in {folder} ({error.strerror}); name another place with "
            f"{option}"
        ) from None
