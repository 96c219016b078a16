"""Items named on the command line, with their years."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.option_types import NumberType
from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.cell.item import Item

F = TypeVar("F", bound=Callable[..., Any])


def year_option(function: F) -> F:
    """Give a command the option --year N.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--year", type=NumberType(2015, 2100), metavar="N",
        help="Year of the item, if its name exists in several years.  [default: 2016, else the latest]",
    )(function)  # fmt: skip


def find_item(name: str, year: int | None, own: Path | None, where: str = "") -> Item:
    """Find an item by name and year.

    Args:
        name: Name of the item.
        year: Its year; None for 2016, else the latest.
        own: The user's own items, besides those of the package.
        where: Source of the name, for the message.

    Returns:
        The item.

    Raises:
        UnknownNameError: There is no item of that name.
        InputError: There is no item of that name in that year.
    """
    from pickcli.cell.schemas.items_file import load_items

    items = load_items(own)
    years = sorted((y for known, y in items if known == name), key=lambda y: (y == 2016, y))
    if not years:
        raise UnknownNameError("item", name, sorted({known for known, _ in items}), where)
    if year is not None and year not in years:
        raise InputError(f"--year: {name} is of {' and '.join(map(str, sorted(years)))}, not of {year}")
    return items[name, year or years[-1]]
