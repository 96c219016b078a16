"""Decide what falls, rolls or is lifted when an item is taken out of a pile: equilibrium of the rest.

Independent of the planner, by the verifier's own model of the pile.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from functools import lru_cache

from pickcli.cell.place import Place
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.contact_pile import CARRYING_NORMAL_Z, pile_at


@dataclass(frozen=True, eq=False)
class Removal:
    """Effects on a pile of lifting an item out of it.

    Attributes:
        lifted: Ids of items that lie on the item, directly or through others, wholly or partly.
        falling: Ids of items without an equilibrium once it is removed.
        rolling: Ids of items that touch it, stay in place on level ground, and roll if pushed.
    """

    lifted: frozenset[str]
    falling: frozenset[str]
    rolling: frozenset[str]


def barrier(scene: Scene, place: Place, placed: PlacedItem) -> float:
    """Return the height over which the middle of an item must come to get over the rim of an open box.

    Above the rim it is at least the radius of the largest ball in the item higher than the rim: a convex
    solid that the rim does not enter holds none that does.

    Args:
        scene: The scene.
        place: The box.
        placed: The item, in the box.

    Returns:
        m in the world.
    """
    rim = float((scene.T_world_place(place) @ place.access.T_place_mouth)[2, 3])
    return rim + float(placed.item.shape.extents.min()) / 2


def may_leave(scene: Scene, place: Place, placed: PlacedItem) -> bool:
    """Whether an item that falls in an open box may get over the rim. It falls, so its middle does not rise.

    Args:
        scene: The scene.
        place: The box.
        placed: The item, in the box.

    Returns:
        Whether its middle is not certainly below the barrier.
    """
    return not placed.T_world_item[2, 3] + scene.bound(placed) < barrier(scene, place, placed)


@lru_cache(maxsize=64)
def removal(scene: Scene, item_id: str) -> Removal:
    """Compute the effects of lifting an item out of its pile. Cached by identity of the scene.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        The effects.
    """
    pile = pile_at(scene, scene.find(item_id).location).around(item_id)
    lifted = pile.lying_on(item_id)
    loose = pile.losing_balance(frozenset({item_id}))
    level = {name for name in loose if pile.without(item_id, *lifted - {name}).lies_level(name, loose)}
    beside = {contact.b.name for contact in pile.touching[item_id]}
    return Removal(lifted, frozenset(loose - level), frozenset(level & beside))


def falling_without(scene: Scene, location: str, taken: Set[str]) -> frozenset[str]:
    """Find what loses its balance if several items are gone at once.

    Args:
        scene: The scene.
        location: Name of the place that they are in.
        taken: Their ids.

    Returns:
        Ids of other items there.
    """
    return pile_at(scene, location).losing_balance(frozenset(taken))


def lying_on(scene: Scene, item_id: str) -> frozenset[str]:
    """Find the items that lie on an item of a pile.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        Ids of items that lie on it, directly or through others, wholly or partly.
    """
    return pile_at(scene, scene.find(item_id).location).lying_on(item_id)


def carriers_of(scene: Scene, item_id: str) -> frozenset[str]:
    """Find the items that an item of a pile lies on.

    Args:
        scene: The scene.
        item_id: Id of the item.

    Returns:
        Ids of items that it touches from above, or may.
    """
    contacts = pile_at(scene, scene.find(item_id).location).touching[item_id]
    return frozenset(c.b.name for c in contacts if not c.b.is_firm and c.normal[2] >= CARRYING_NORMAL_Z)
