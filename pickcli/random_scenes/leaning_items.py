"""Which items of a bin are to lean, and whether one does."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pickcli.cell.place import Place
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import inverse
from pickcli.random_scenes.bin_layout import ItemInstance
from pickcli.random_scenes.leaning_placements import (
    LEAST_ANGLE,
    MOST_ANGLE,
    LeanKind,
    lean_angle,
    leaning_stances,
)
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.seeds import derived_rng


def drawn_to_lean(
    place: Place, contents: Sequence[ItemInstance], seed: int, share: float
) -> Iterator[Mapping[int, Sequence[LeanKind]]]:
    """Draw which items of a bin are to lean, and how; then fewer of them, in case not all find room so.

    Args:
        place: The place; in those that are open above nothing is drawn to lean.
        contents: The items.
        seed: Seed of the scene.
        share: Share of them that is drawn, of those that can lean.

    Yields:
        Indices of the items that are to lean, each with how it may: at first as drawn, then in any way, then
        without the last one, until one is left.
    """
    if share <= 0.0 or place.access.is_from_above:
        return
    rng = derived_rng("leaning", seed, place.name)
    drawn: dict[int, list[LeanKind]] = {}
    possible: dict[int, list[LeanKind]] = {}
    for k, entry in enumerate(contents):
        kinds = [kind for kind in LeanKind if leaning_stances(entry.item, kind)]
        is_drawn, which = rng.random() < share, rng.random()
        if kinds and is_drawn:
            drawn[k], possible[k] = [kinds[int(which * len(kinds))]], kinds
    if drawn:
        yield drawn
    order = list(possible)
    for n in range(len(order), 0, -1):
        yield {k: possible[k] for k in order[:n]}


def leaning_items(scene: Scene) -> dict[str, float]:
    """Collect the boxes in bins that lean, on purpose or as they came to rest.

    Args:
        scene: The scene.

    Returns:
        Angles against the floor in rad, over 3 and up to 20 degrees, by id.
    """
    found = {}
    for placed in scene.items:
        place = scene.cell.places.get(placed.location)
        is_box = placed.item.shape.kind is ShapeKind.BOX
        if is_box and place is not None and not place.access.is_from_above and leans(scene, place, placed):
            found[placed.id] = _angle(scene, place, placed)
    return found


def leans(scene: Scene, place: Place, placed: PlacedItem) -> bool:
    """Whether an item leans by more than 3 degrees, and by 20 at most.

    Args:
        scene: The scene that the place is in.
        place: The bin that the item is in.
        placed: The item at rest.

    Returns:
        True if it does.
    """
    return bool(LEAST_ANGLE < _angle(scene, place, placed) <= MOST_ANGLE)


def _angle(scene: Scene, place: Place, placed: PlacedItem) -> float:
    return lean_angle(place, inverse(scene.T_world_place(place)) @ placed.T_world_item)
