"""What to move aside so that a target can be picked, and where to.

Delft moved an item that hid a target into the emptiest bin after two attempts in vain (their task planner).
Here the failed plan says itself what is in the way, and planning without it says whether moving it helps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from pickcli.cell.scene import TOTE, Scene
from pickcli.errors import NoPlanError
from pickcli.trial.order import Target

MOST_IN_THE_WAY = 5  # items of which all must go before a target can be picked

WhatIf = Callable[[Scene], object]  # plans a pick of the target in a scene, or raises NoPlanError


def in_the_way(what_if: WhatIf, scene: Scene, bin_name: str, is_hopeful: bool = False) -> tuple[str, ...]:
    """Ids of items of the bin without which the target can be picked; () if nothing of the kind helps.

    The item that is blamed most is thought away, until there is a plan; then those that it can do with.

    Args:
        what_if: Plans the pick in a scene.
        scene: As it is seen.
        bin_name: Where the target lies.
        is_hopeful: Whether what is blamed is named even where moving it leaves something else that no item is
            to blame for: that may be another one once the target can be reached, or is seen anew.
    """
    here = {placed.id for placed in scene.in_location(bin_name)}
    away: list[str] = []
    while (error := _failure(what_if, scene, away)) is not None:
        blamed = next((name for name in error.in_the_way if name in here - set(away)), None)
        if blamed is None or len(away) == MOST_IN_THE_WAY:
            return tuple(away) if is_hopeful else ()
        away.append(blamed)
    for name in away[:-1]:  # what was blamed first need not be in the way of what was found in the end
        others = [other for other in away if other != name]
        if _failure(what_if, scene, others) is None:
            away = others
    return tuple(away)


def _failure(what_if: WhatIf, scene: Scene, away: Sequence[str]) -> NoPlanError | None:
    """Why there is no plan without some items; None if there is one."""
    for name in away:
        scene = scene.without(name)
    try:
        what_if(scene)
    except NoPlanError as error:
        return error
    return None


def destinations(scene: Scene, bin_name: str, still_open: Sequence[Target]) -> Iterator[str]:
    """Other bins, the emptiest first, those in which targets still lie after them; the tote if none takes it.

    The published penalties of 2016 name none for an item in the tote that was not ordered, as long as the
    output file says that it is there.
    """
    waiting = {target.bin for target in still_open}
    others = [name for name in scene.cell.pod.bins if name != bin_name]
    others.sort(key=lambda name: (name in waiting, len(scene.in_location(name)), name))
    yield from others
    yield TOTE
