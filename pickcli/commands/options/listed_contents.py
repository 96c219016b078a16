"""What is listed to be in places, and into which of them is looked, as stated on the command line."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.option_types import PATH
from pickcli.errors import UnknownNameError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.place import Place
    from pickcli.perception.perceived_places import Contents
    from pickcli.scene.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])


def order_option(function: F) -> F:
    """Give a command the option --order.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--order", "order_path", type=PATH, metavar="ORDER",
        help="Order that says what is in each place.  [default: what the scene has there]",
    )(function)  # fmt: skip


def bin_option(function: F) -> F:
    """Give a command the option --bin.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--bin", "bin_names", metavar="PLACE", multiple=True,
        help="Bin, or other place, whose items are looked for; may be repeated.  "
             "[default: all with items whose room is seen at least to half]",
    )(function)  # fmt: skip


def listed_contents(scene: Scene, order_path: Path | None, may_deform: bool) -> Contents:
    """Tell what is listed to be in each place.

    Args:
        scene: The scene.
        order_path: Order that says so; None for what the scene has.
        may_deform: Whether cloth, bags and plush may look other than their boxes.

    Returns:
        The items by name of the place.

    Raises:
        InputError: The order cannot be read, or is of another cell.
    """
    from pickcli.perception.items.listed_item import ListedItem
    from pickcli.perception.perceived_places import listed_in
    from pickcli.random_scenes.make_scene import instances_of
    from pickcli.trial.order_file import read_order

    if order_path is None:
        return listed_in(scene, may_deform)
    order = read_order(order_path, scene.cell)
    listed = instances_of(order.contents, scene.cell, order.year)
    return {
        name: [ListedItem.of(each.id, each.item, may_deform) for each in items]
        for name, items in listed.items()
    }


def named_places(cell: Cell, names: tuple[str, ...]) -> tuple[Place, ...]:
    """Find the places that --bin names.

    Args:
        cell: The cell.
        names: Their names.

    Returns:
        The places, each once; none if none is named.

    Raises:
        UnknownNameError: The cell has no such place.
    """
    for name in names:
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places), "--bin")
    return tuple(cell.places[name] for name in dict.fromkeys(names))
