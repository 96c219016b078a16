"""Types of options and arguments, and names of outputs that are refused before any work."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

import click

from pickcli.errors import InputError


class PathType(click.Path):
    """The path of a file or folder. An empty one, and `-` for a stream, are wrong usage."""

    def __init__(self) -> None:
        """Paths as `pathlib.Path`; whether they exist is asked by who reads or writes them."""
        super().__init__(path_type=Path)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check a path.

        Args:
            value: What was written on the command line.
            param: The option or argument of click.
            ctx: Context of click.

        Returns:
            The path as it was given.

        Raises:
            BadParameter: It is empty, or `-`.
        """
        if not str(value).strip():
            self.fail("the path is empty; name a file", param, ctx)
        if str(value) == "-":
            self.fail("files are not read from stdin nor written to stdout; name a file", param, ctx)
        return super().convert(value, param, ctx)


PATH = PathType()


def refuse_suffix(path: Path, suffixes: Collection[str], what: str) -> None:
    """Refuse, before any work, an output whose name promises another format.

    Args:
        path: The output.
        suffixes: In lower case, e.g. `.png`.
        what: What is written, e.g. "a picture".

    Raises:
        InputError: The name ends with none of the suffixes.
    """
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: {what} is written as {' or '.join(suffixes)}; name such a file")


class NumberType(click.IntRange):
    """A whole number between bounds."""

    name = "whole number"
