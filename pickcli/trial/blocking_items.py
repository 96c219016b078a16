"""What to move aside so that a target can be picked, and where to.

Delft moved an item that hid a target into the emptiest bin after two attempts in vain (their task planner).
Here the failed plan says itself what is in the way, and planning without it says whether moving it helps.
What no bin takes goes into the tote: the published penalties of 2016 name none for an item there that was not
ordered, as long as the output file says that it is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.grasping.method_choice import may_hold
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.order import Target

MOST_IN_THE_WAY = 5  # items of which all must go before a target can be picked
MOST_DESTINATIONS = 4  # bins that are asked to take what is moved aside

WhatIf = Callable[[Scene], object]  # plans a pick of the target in a scene, or raises NoPlanError


def in_the_way(
    what_if: WhatIf,
    scene: Scene,
    target: PlacedItem,
    is_hopeful: bool = False,
    blamed: Sequence[str] | None = None,
) -> tuple[str, ...]:
    """Find items of the bin without which the target can be picked.

    The item that is blamed most is thought away, until there is a plan; then those that it can do with.

    Args:
        what_if: Plans the pick in a scene.
        scene: The scene as it is seen.
        target: The target as it is seen; it is never in its own way, though the tool may not reach it for it.
        is_hopeful: Whether what is blamed is named even where moving it leaves something else that no item is
            to blame for: that may be another one once the target can be reached, or is seen again.
        blamed: Items that a plan blamed in this very scene, the most blamed first, if one was refused in it.

    Returns:
        Ids of the items; () if nothing of the kind helps.
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
    for name in away[:-1]:  # what was blamed first need not be in the way of what was found in the end
        others = [other for other in away if other != name]
        if _blamed(what_if, scene, others) is None:
            away = others
    return tuple(away)


def worth_moving(what_if: WhatIf, scene: Scene, target: PlacedItem, tools: Sequence[Tool]) -> tuple[str, ...]:
    """List the other items of the bin that a tool might hold.

    Any of them that can be moved may give room to what cannot be yet.

    Args:
        what_if: Plans the pick in a scene.
        scene: The scene as it is seen.
        target: The target as it is seen.
        tools: Of every arm.

    Returns:
        Ids, the item nearest to the mouth first; () where the target cannot be picked without all of them
        either.
    """
    here = from_the_mouth(scene, scene.in_location(target.location))
    others = tuple(p.id for p in here if p.id != target.id and may_hold(tools, p.item))
    return others if others and _blamed(what_if, scene, others) is None else ()


def _blamed(what_if: WhatIf, scene: Scene, away: Sequence[str]) -> Sequence[str] | None:
    """What is in the way of a plan without some items, the most blamed first; None if there is one."""
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
    """Choose other bins to put something aside into.

    Args:
        scene: The scene as it is seen.
        bin_name: The bin that something is taken out of.
        still_open: Targets that are still to be picked.

    Yields:
        Names of bins, the emptiest first, those in which targets still lie after them; a few at most.
    """
    waiting = {target.bin for target in still_open}
    others = [name for name in scene.cell.pod.bins if name != bin_name]
    others.sort(key=lambda name: (name in waiting, len(scene.in_location(name)), name))
    yield from others[:MOST_DESTINATIONS]
