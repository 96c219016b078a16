"""Checks of a requested stow before any work: its item, and the bins that the item fits into."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.scene.scene import PlacedItem, Scene


def item_in_tote(scene: Scene, item: str, option: str, how: str = "") -> PlacedItem:
    """Find an item in the tote.

    Args:
        scene: The scene.
        item: The item's name or id.
        option: The option that states it, for messages.
        how: What takes it from elsewhere; "" for a query of its own.

    Returns:
        The item.

    Raises:
        InputError: The item is elsewhere.
        UnknownNameError: The scene has no such item.
    """
    from pickcli.scene.scene import TOTE

    places = sorted({placed.location for placed in scene.items if item in (placed.id, placed.item.name)})
    if places and TOTE not in places:
        fault = f"{option}: {item} is in {' and '.join(places)}, not in the tote"
        how = how or f"--pick {places[0]}:{item}"
        raise InputError(f"{fault}; {how} picks it from there")
    return scene.find(item, TOTE)


def stated_bin(scene: Scene, placed: PlacedItem, name: str, option: str) -> str:
    """Return the name of a bin that is large enough for an item.

    Args:
        scene: The scene.
        placed: The item.
        name: The bin's name.
        option: The option that states it, for messages.

    Returns:
        The name.

    Raises:
        UnknownNameError: The cell has no such bin.
        InputError: The item is too large for it.
    """
    bins = scene.cell.pod.bins
    if name not in bins:
        raise UnknownNameError("bin", name, list(bins), option)
    if sizes := scene.cell.places[name].room.too_small_for(placed.item.shape.extents):
        raise InputError(f"{option}: {placed.id} does not fit into {name}: it has {sizes}; name another bin")
    return name


def bins_for(scene: Scene, placed: PlacedItem) -> tuple[str, ...]:
    """Return the bins to try for an item, as if the scene were the start of a stow task.

    Args:
        scene: The scene.
        placed: The item.

    Returns:
        Names, the bin with most points first.

    Raises:
        InputError: The item is too large for all bins.
    """
    from pickcli.trial.score import item_bonuses
    from pickcli.trial.stow_assignment import assign_bins, order_as_it_lies

    order = order_as_it_lies(scene, placed.item)
    (choice,) = assign_bins(order, scene.cell, item_bonuses(scene.cell, order), [scene.cell.robot.tool])
    if not choice.bins:
        raise InputError(f"{placed.id}: {choice.reason}")
    return choice.bins
