"""Advice on a pick without a plan: the items without which there is one, found by planning without them."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from pickcli.errors import NoPlanError

if TYPE_CHECKING:
    from collections.abc import Callable

    from pickcli.motion.plan import Plan
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import Scene


PlanIn: TypeAlias = "Callable[[Scene, PickQuery], Plan]"


def with_blockers(error: NoPlanError, plan_in: PlanIn, scene: Scene, query: PickQuery) -> NoPlanError:
    """Add the blocking items to the error of a pick, and which of them have no plan themselves.

    Reasons name the item beside each candidate; this tells what removing them is worth.

    Args:
        error: The error of the pick in the scene.
        plan_in: Plans a pick in any scene, or raises NoPlanError.
        scene: The scene.
        query: The pick.

    Returns:
        The error with the advice in its message; the same error if removing items does not help.
    """
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import TOTE
    from pickcli.trial.blocking_items import in_the_way

    if not error.in_the_way:
        return error
    target = scene.find(query.item, query.out_of)
    names = in_the_way(lambda left: plan_in(left, query), scene, target, blamed=error.in_the_way)
    if not names:
        return error
    away = query.into if query.out_of == TOTE or TOTE not in scene.cell.places else TOTE
    stuck = [name for name in names if not _has_plan(plan_in, scene, PickQuery(query.out_of, name, away))]
    told = f"{error.summary()}\nwithout {' and '.join(names)} there is a plan"
    if stuck:
        told += f", but {' and '.join(stuck)} {'has' if len(stuck) == 1 else 'have'} none either"
    return NoPlanError(error.query, error.reasons, told, names)


def _has_plan(plan_in: PlanIn, scene: Scene, query: PickQuery) -> bool:
    try:
        plan_in(scene, query)
    except NoPlanError:
        return False
    return True
