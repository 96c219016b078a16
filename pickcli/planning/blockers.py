"""Blockers of a pick: the items without which it has a plan, found by planning without them.

Failed plans report the item that was in the way of each candidate; planning in a scene without an item shows
whether moving it helps.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from pickcli.cell.tool import Tool
from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.grasping.method_choice import may_hold
from pickcli.motion.plan import Plan
from pickcli.planning.destination_choice import plan_into_first
from pickcli.planning.pick_problem import PickQuery
from pickcli.scene.scene import TOTE, PlacedItem, Scene

MOST_BLOCKERS = 5  # largest number of items that may have to be moved for one target

WhatIf = Callable[[Scene], object]  # plans a pick of the target in a scene, or raises NoPlanError
PlanIn = Callable[[Scene, PickQuery], Plan]  # plans any pick in a scene, or raises NoPlanError


def blocking_items(
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
        if first is None or len(away) == MOST_BLOCKERS:
            return tuple(away) if is_hopeful else ()
        away.append(first)
        blamed = _blamed(what_if, scene, away)
    for name in away[:-1]:  # items blamed first need not block the plan found at last
        others = [other for other in away if other != name]
        if _blamed(what_if, scene, others) is None:
            away = others
    return tuple(away)


def worth_moving(what_if: WhatIf, scene: Scene, target: PlacedItem, tools: Sequence[Tool]) -> tuple[str, ...]:
    """List the other items in the target's place that a tool might hold.

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
    """Sort items by their distance from the mouth of their place.

    Args:
        scene: The scene, for the poses of the places.
        items: The items.

    Returns:
        The items, the one nearest to the mouth first.
    """

    def depth(placed: PlacedItem) -> tuple[float, str]:
        place = scene.cell.places[placed.location]
        T_world_entry = scene.T_world_place(place) @ place.T_place_entry
        return float((inverse(T_world_entry) @ placed.T_world_item)[0, 3]), placed.id

    return sorted(items, key=depth)


def with_blockers(
    error: NoPlanError, plan_in: PlanIn, scene: Scene, queries: Sequence[PickQuery]
) -> NoPlanError:
    """Add the blockers to the error of a pick, and which of them have no plan themselves.

    The reasons of a failed plan name the item beside each candidate; planning without them shows which of
    them have to be moved.

    Args:
        error: The error of the pick in the scene.
        plan_in: Plans a pick in any scene, or raises NoPlanError.
        scene: The scene.
        queries: The pick, by its destination, in their order; at least one.

    Returns:
        The error with the advice in its message; the same error if removing items does not help.
    """
    if not error.in_the_way:
        return error
    query, into = queries[0], {query.into: query for query in queries}

    def what_if(left: Scene) -> object:
        return plan_into_first(error.query, list(into), lambda name: plan_in(left, into[name]))

    target = scene.find(query.item, query.out_of)
    names = blocking_items(what_if, scene, target, blamed=error.in_the_way)
    if not names:
        return error
    away = list(into) if query.out_of == TOTE or TOTE not in scene.cell.places else [TOTE]

    def is_stuck(name: str) -> bool:
        def bring(place: str) -> object:
            return plan_in(scene, PickQuery(query.out_of, name, place, neighbours=query.neighbours))

        try:
            plan_into_first(name, away, bring)
        except NoPlanError:
            return True
        return False

    stuck = [name for name in names if is_stuck(name)]
    advice = f"{error.text}\nwithout {' and '.join(names)} there is a plan"
    if stuck:
        advice += f", but {' and '.join(stuck)} cannot be picked either"
    return type(error)(error.query, error.reasons, advice, names)
