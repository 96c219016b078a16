"""Creates a scene from an order: every item with its real size, at rest in its place.

Places are filled one by one, each with its own seed, so that a bin does not depend on the contents of others.
Targets of the order are not treated differently.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import ceil

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.station import POD
from pickcli.errors import InputError, Reason, UnknownNameError
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.random_scenes.bin_layout import ItemInstance, lay_out
from pickcli.random_scenes.heap import lay_heap
from pickcli.random_scenes.leaning_items import drawn_to_lean, leans
from pickcli.random_scenes.leaning_placements import LeanKind
from pickcli.scene.scene import CarrierPose, PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.settle import settle

N_ATTEMPTS = 5  # at a bin: items of a layout may still slip or roll away
N_RAISING = 10  # further attempts, with items tilted up inside
# largest number of items for which all attempts are made: the cost of each grows with its cube
MAX_ITEMS_OF_ALL_ATTEMPTS = 12
MAX_ITEMS = 30  # items of one place; this number takes a minute of search
N_LEANING = 3  # attempts at a bin with the same items leaning
N_HEAPS = 30  # attempts at a place open above


def make_scene(
    bin_contents: Mapping[str, Sequence[str]],
    cell: Cell,
    seed: int,
    year: int = 2016,
    on_progress: ProgressObserver = nobody,
    carriers: Mapping[str, CarrierPose] | None = None,
    leaning_share: float = 0.0,
) -> Scene:
    """Place items at rest and without overlap.

    Args:
        bin_contents: Item names by bin or other place.
        cell: The cell, for places and items.
        seed: Seed of all random choices.
        year: Year of the figures of items that occur in two years.
        on_progress: Called with the number of finished bins and the name of the next, also during a search.
        carriers: Poses of pod, tote and user-defined carriers that are displaced, by name; None if none is.
        leaning_share: Share, 0 to 1, of the items that are to lean, of those in bins that can.

    Returns:
        The scene.

    Raises:
        InputError: The items of a bin do not fit; the message names the bin and the reason. Or the share is
            none.
        UnknownNameError: A name is not an item or place of the cell.
    """
    for name, names in bin_contents.items():
        if name not in cell.places:
            raise UnknownNameError("place", name, list(cell.places))
        if isinstance(names, str):
            raise InputError(f"{name}: expected a list of items, got {names!r}; put it into one")
    if not 0.0 <= leaning_share <= 1.0:
        raise InputError(f"leaning_share: {leaning_share} is no share; give a number from 0 to 1")
    moved = dict(carriers or {})
    pod = moved.pop(POD, CarrierPose(cell.T_world_pod))
    empty = Scene(cell, pod.T_world_carrier, (), PoseNoise(), seed, pod.error, carriers=moved)
    items: list[PlacedItem] = []
    for done, (bin_name, contents) in enumerate(instances_of(bin_contents, cell, year).items()):
        tell = partial(on_progress, Progress(done, len(bin_contents), bin_name))
        items.extend(fill_bin(empty, bin_name, contents, seed, tell, leaning_share))
    return replace(empty, items=tuple(items))


def instances_of(
    contents: Mapping[str, Sequence[str]], cell: Cell, year: int
) -> dict[str, list[ItemInstance]]:
    """Give each copy of an item an id of its own, in the order of the names of places.

    Args:
        contents: Names of items by place; duplicates are copies.
        cell: The cell.
        year: Year of the items' figures.

    Returns:
        The instances by place, sorted by its name.

    Raises:
        UnknownNameError: A name is not an item of the cell.
    """
    ids: dict[str, int] = {}
    return {
        place: [ItemInstance(_instance_id(name, ids), cell.item(name, year)) for name in names]
        for place, names in sorted(contents.items())
    }


def fill_bin(
    scene: Scene,
    bin_name: str,
    contents: Sequence[ItemInstance],
    seed: int,
    tell: Callable[[], None] = lambda: None,
    leaning_share: float = 0.0,
) -> tuple[PlacedItem, ...]:
    """Place the contents of one bin, or other place, at rest.

    Args:
        scene: The scene that the bin is in.
        bin_name: Name of the bin.
        contents: Items to be placed.
        seed: Seed of all random choices.
        tell: Called before every step.
        leaning_share: Share, 0 to 1, of the items that are to lean, of those that can if the place is a bin.
            Where not all of them find room so, the others stand or lie.

    Returns:
        The items in their places.

    Raises:
        InputError: No layout comes to rest.
    """
    tell()
    if not contents:
        return ()
    if too_much := _too_much(scene.cell, bin_name, [entry.item for entry in contents]):
        raise InputError(too_much)
    for leaning in drawn_to_lean(scene.cell.places[bin_name], contents, seed, leaning_share):
        if (leant := _leant(scene, bin_name, contents, seed, leaning, tell)) is not None:
            return leant
    reason = Reason("no room for all of them at once")
    for layout in _layouts(scene, bin_name, contents, seed, tell):
        tell()
        rested = settle(scene, layout)
        if not isinstance(rested, Reason):
            return rested
        reason = rested
    raise InputError(
        f"{bin_name}: its {len(contents)} item{'s do' if len(contents) > 1 else ' does'} not fit at rest "
        f"(last: {reason}); take another seed, or put fewer or smaller items there"
    )


def _leant(
    scene: Scene,
    bin_name: str,
    contents: Sequence[ItemInstance],
    seed: int,
    leaning: Mapping[int, Sequence[LeanKind]],
    tell: Callable[[], None],
) -> tuple[PlacedItem, ...] | None:
    """The contents of a bin at rest, with some of them leaning; None if no layout stays so."""
    place = scene.cell.places[bin_name]
    for attempt in range(N_LEANING):
        key = derived_seed("leaning layout", seed, bin_name, attempt, *sorted(leaning))
        layouts = lay_out(scene, bin_name, contents, key, tell=tell, leaning=leaning)
        if not layouts:
            break
        for layout in layouts:
            tell()
            rested = settle(scene, layout)
            if not isinstance(rested, Reason) and all(leans(scene, place, rested[k]) for k in leaning):
                return rested
    return None


def _layouts(
    scene: Scene, bin_name: str, contents: Sequence[ItemInstance], seed: int, tell: Callable[[], None]
) -> Iterator[tuple[PlacedItem, ...]]:
    """Yield layouts of a place; those whose items pass the mouth upright come first."""
    place = scene.cell.places[bin_name]
    if place.access.is_from_above:
        for attempt in range(N_HEAPS):
            rng = derived_rng("heap", seed, bin_name, attempt)
            if (laid := lay_heap(scene, place, contents, rng)) is not None:
                yield laid
        return
    n_items = max(MAX_ITEMS_OF_ALL_ATTEMPTS, len(contents))
    for attempt in range(ceil(N_ATTEMPTS * (MAX_ITEMS_OF_ALL_ATTEMPTS / n_items) ** 3)):
        layouts = lay_out(
            scene, bin_name, contents, derived_seed("layout", seed, bin_name, attempt), tell=tell
        )
        if not layouts:
            break
        yield from layouts
    for attempt in range(ceil(N_RAISING * (MAX_ITEMS_OF_ALL_ATTEMPTS / n_items) ** 3)):
        key = derived_seed("raised layout", seed, bin_name, attempt)
        yield from lay_out(scene, bin_name, contents, key, may_raise=True, tell=tell)


def refuse_too_much(bin_contents: Mapping[str, Sequence[str]], cell: Cell, year: int, where: str) -> None:
    """Refuse, before any search, items too large for their bin, or too many by volume or number.

    Args:
        bin_contents: Item names by bin.
        cell: The cell, for bins and items.
        year: Year of the figures of items that occur in two years.
        where: The order's file, for messages.

    Raises:
        InputError: An item is too large for its bin, or a bin's items are too many; all bins are named.
    """
    faults = (
        _too_much(cell, bin_name, [cell.item(name, year) for name in names])
        for bin_name, names in bin_contents.items()
    )
    if too_much := [f"{where}: {text}" for text in faults if text]:
        raise InputError("\n".join(too_much))


def _too_much(cell: Cell, bin_name: str, items: Sequence[Item]) -> str:
    """Why a bin cannot hold these items, "" if it may."""
    inside = cell.places[bin_name].room
    for item in items:
        if sizes := inside.too_small_for(item.shape.extents):
            return f"{bin_name}: {item.name} fits in no way: it has {sizes}; take it out of there"
    volume_inside = 1e3 * inside.volume
    volume = 1e3 * sum(item.shape.volume for item in items)
    if volume <= volume_inside and len(items) <= MAX_ITEMS:
        return ""
    count = f"its {len(items)} items are more than are laid out in one place, {MAX_ITEMS}"
    if volume > volume_inside:
        count = f"its {len(items)} items take {volume:.1f} litres, the place has {volume_inside:.1f}"
    return f"{bin_name}: {count}; put fewer items there"


def _instance_id(name: str, seen: dict[str, int]) -> str:
    """Return ``name`` for the first copy in the scene, ``name#2`` for the second."""
    seen[name] = seen.get(name, 0) + 1
    return name if seen[name] == 1 else f"{name}#{seen[name]}"
