"""Search for blocking items that must be moved before a target can be picked, and for their destinations.

Delft moved an item that hid a target into the emptiest bin after two failed attempts (their task planner).
Here failed plans report blocking items, and planning without an item shows whether moving it helps. Items
that fit in no other bin go into the tote: the published penalties of 2016 include none for an item there that
was not ordered, provided that the output file lists it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.grasping.method_choice import may_hold
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.order import Target

MOST_IN_THE_WAY = 5  # largest number of items that may have to be moved for one target
MOST_DESTINATIONS = 4  # number of bins tried as destinations of a blocking item

WhatIf = Callable[[Scene], object]  # plans a pick of the target in a scene, or raises NoPlanError


def in_the_way(
    what_if: WhatIf,
    scene: Scene,
    target: PlacedItem,
    is_hopeful: bool = False,
    blamed: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """Find items of the bin without which the target can be picked.

    The most blamed item is removed from the scene until there is a plan; then items that need not be moved
    are dropped from the list.

    Args:
        what_if: Plans the pick in a scene.
        scene: The perceived scene.
        target: The perceived target; it never counts as blocking, even if plans blame it.
        is_hopeful: Whether to return blamed items even if, without them, plans fail for reasons other than
            items: the plan may succeed once the target is accessible or seen again.
        blamed: Items blamed by a failed plan in this scene, the most blamed first; None without one.

    Returns:
        Ids of the items; () if moving items does not help.
    """
    here = {placed.id for placed in scene.in_location(target.location)} - {target.id}
    away: list[str] = []
    if blamed is None:
        blamed = _blamed(what_if, scene, away)
    while blamed is not None:
        first = next((name for name in blamed if name in here - set(away)), None)
        if first is None or len(away) == MOST_IN_THE_WAY:
            return tuple(away) if is_hopeful else ()
        away.append(first)
        blamed = _blamed(what_if, scene, away)
    for name in away[:-1]:  # items blamed first need not block the plan found at last
        others = [other for other in away if other != name]
        if _blamed(what_if, scene, others) is None:
            away = others
    return tuple(away)


def worth_moving(what_if: WhatIf, scene: Scene, target: PlacedItem, tools: Sequence[Tool]) -> tuple[str, ...]:
    """List the other items of the bin that a tool might hold.

    Moving any of them may free space for others.

    Args:
        what_if: Plans the pick in a scene.
        scene: The perceived scene.
        target: The perceived target.
        tools: Tools of all arms.

    Returns:
        Ids, the item nearest to the mouth first; () if the target cannot be picked even without all of them.
    """
    here = from_the_mouth(scene, scene.in_location(target.location))
    others = tuple(p.id for p in here if p.id != target.id and may_hold(tools, p.item))
    return others if others and _blamed(what_if, scene, others) is None else ()


def _blamed(what_if: WhatIf, scene: Scene, away: Sequence[str]) -> Sequence[str] | None:
    """Blocking items of a plan without some items, the most blamed first; None if a plan was found."""
    for name in away:
        scene = scene.without(name)
    try:
        what_if(scene)
    except NoPlanError as error:
        return error.in_the_way
    return None


def from_the_mouth(scene: Scene, items: Iterable[PlacedItem]) -> list[PlacedItem]:
    """Sort items in bins by their distance from the mouth.

    Args:
        scene: The scene, for the pose of the pod.
        items: The items.

    Returns:
        The items, the one nearest to the mouth first.
    """
    T_pod_world = inverse(scene.T_world_pod)
    return sorted(items, key=lambda placed: (float((T_pod_world @ placed.T_world_item)[0, 3]), placed.id))


def destinations(scene: Scene, bin_name: str, still_open: Sequence[Target]) -> Iterator[str]:
    """Choose other bins as destinations of a blocking item.

    Args:
        scene: The perceived scene.
        bin_name: The bin from which the item is removed.
        still_open: Targets still to be picked.

    Yields:
        Names of bins, at most MOST_DESTINATIONS: the emptiest first, bins with open targets last.
    """
    waiting = {target.bin for target in still_open}
    others = [name for name in scene.cell.pod.bins if name != bin_name]
    others.sort(key=lambda name: (name in waiting, len(scene.in_location(name)), name))
    yield from others[:MOST_DESTINATIONS]
