"""Types of options and arguments, renamed options, and refusal of output names with a wrong suffix."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.errors import InputError

if TYPE_CHECKING:
    from click.parser import _OptionParser


class PathType(click.Path):
    """Path of a file or folder. An empty path, or `-` for a stream, is a usage error."""

    def __init__(self) -> None:
        """Paths become `pathlib.Path`; who reads or writes them checks whether they exist and may be read."""
        super().__init__(path_type=Path, readable=False)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check a path.

        Args:
            value: Text from the command line.
            param: The option or argument of click.
            ctx: Context of click.

        Returns:
            The path as given.

        Raises:
            BadParameter: The path is empty, or `-`.
        """
        if not str(value).strip():
            self.fail("the path is empty; name a file", param, ctx)
        if str(value) == "-":
            self.fail("files are not read from stdin nor written to stdout; name a file", param, ctx)
        return super().convert(value, param, ctx)


PATH = PathType()


class FiniteRange(click.FloatRange):
    """Number within a range; unlike in `click.FloatRange`, nan is in none."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Check a number.

        Args:
            value: Text from the command line, or a number.
            param: The option of click.
            ctx: Context of click.

        Returns:
            The number.

        Raises:
            BadParameter: It is no number, nan, or beyond the range.
        """
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"{value} is not in the range {self._describe_range()}.", param, ctx)
        return number


def refuse_suffix(path: Path, suffixes: Collection[str], what: str) -> None:
    """Refuse, before any work, an output whose name implies another format.

    Args:
        path: The output.
        suffixes: In lower case, e.g. `.png`.
        what: Name of the output, e.g. "a picture".

    Raises:
        InputError: The name ends with none of the suffixes.
    """
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: {what} is written as {' or '.join(suffixes)}; name such a file")


class NumberType(click.IntRange):
    """A whole number between bounds."""

    name = "whole number"

    def get_metavar(self, param: click.Parameter, ctx: click.Context | None = None) -> str:
        """Return N, as all counts are shown in the help.

        Args:
            param: The option of click.
            ctx: Context of click.

        Returns:
            The metavar.
        """
        return "N"


class RenamedOption(click.Option):
    """An option with former names, which are accepted like its own but appear in no help text.

    Args:
        declarations: The names of the option and its parameter, as in click.
        old: The former names.
        **attributes: As in click; the option has at most one value.

    Attributes:
        old: The former names.
    """

    def __init__(self, declarations: Sequence[str], *, old: Sequence[str], **attributes: Any) -> None:
        """As an option of click."""
        super().__init__(declarations, **attributes)
        self.old = tuple(old)

    def add_to_parser(self, parser: _OptionParser, ctx: click.Context) -> None:
        """Add the option under all of its names.

        Args:
            parser: The parser of click.
            ctx: Context of click.
        """
        super().add_to_parser(parser, ctx)
        action = "store_const" if self.is_flag else "store"
        parser.add_option(self, self.old, self.name, action, self.nargs, const=True)
