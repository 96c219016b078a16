"""Checks of a requested pick before any work: its places, its item, and whether that fits."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import Scene

_NO_OTHER = "it has only one place: add another one under places in its cell.yaml (docs/formats/cell.md)"


def example(scene: Scene) -> str:
    """Return an example of a request that is possible in the scene.

    Args:
        scene: The scene.

    Returns:
        The end of a sentence; "" if the scene has no item.
    """
    return next((f"; e.g. {placed.location}:{placed.item.name}" for placed in scene.items), "")


def destination(scene: Scene, place: str | None, out_of: str, how: str = "with --into") -> str:
    """Return the place that an item is brought to.

    Args:
        scene: The scene.
        place: The stated place; None if not stated.
        out_of: The place that it is taken from.
        how: How a place is stated, for the message.

    Returns:
        The stated place, else the tote.

    Raises:
        InputError: No place is stated, and the cell has no tote.
    """
    from pickcli.scene.scene import TOTE

    if place is None and TOTE not in scene.cell.places:
        names = ", ".join(_other_places(scene, out_of))
        remedy = f"name one of its places {how}: {names}" if names else _NO_OTHER
        raise InputError(f"no destination: the cell has no tote; {remedy}")
    return place or TOTE


def refuse_impossible(scene: Scene, query: PickQuery, *, out_of_option: str, into_option: str) -> None:
    """Refuse, before any work, a pick that is impossible in the scene.

    Args:
        scene: The scene.
        query: The requested pick.
        out_of_option: The option that states the place that is picked from, for messages.
        into_option: The option that states the place that the item is brought to.

    Raises:
        InputError: A name is unknown, the item is already at its destination, or is too large for it.
    """
    from pickcli.scene.scene import TOTE

    out_of, into, places = query.out_of, query.into, scene.cell.places
    for name, option in ((out_of, out_of_option), (into, into_option)):
        if name not in places:
            raise UnknownNameError("place", name, list(places), option)
    placed = scene.find(query.item, out_of)
    if into == out_of:
        names = ", ".join(_other_places(scene, out_of))
        remedy = f"name another place: {names}" if names else _NO_OTHER
        raise InputError(f"{into_option}: the item is in {into} already; {remedy}")
    if into != TOTE and (sizes := places[into].room.too_small_for(placed.item.shape.extents)):
        raise InputError(
            f"{into_option}: {placed.id} does not fit into {into}: it has {sizes}; name another place"
        )


def _other_places(scene: Scene, out_of: str) -> list[str]:
    """Return the names of all places except the one that is picked from."""
    return [name for name in scene.cell.places if name != out_of]
