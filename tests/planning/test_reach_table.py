"""What is said at once of items that are never met agrees with the whole search."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Failures, NoPlanError
from pickcli.motion.plan import Plan
from pickcli.planning.belt_picks import axis_intercept, axis_windows
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.belt_picks.reach_table import too_late_by
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.start_state import Start
from pickcli.scene.item_stream import ItemStream, RidingItem
from support.belt_picks import cell, context, home, stream

AT_ONCE, LATE = "at least, as the arm takes items there", "too late"


def at(k: int, travel: float, speed: float) -> tuple[ItemStream, str]:
    """A stream of one item alone, at a travel at 0 s."""
    riding = stream(speed).items[k]
    T = riding.T_belt_item.copy()
    T[0, 3] = travel
    return replace(stream(speed), items=(RidingItem(riding.id, riding.item, 0.0, T),)), riding.id


def answer(k: int, travel: float, speed: float, start: Start) -> Plan | str:
    items, name = at(k, travel, speed)
    try:
        return plan_intercept(context(), items, InterceptQuery(name, 0.0), start)
    except NoPlanError as error:
        return str(error)


def starts() -> tuple[Start, ...]:
    drop, belt = (cell().configurations[name] for name in ("drop_01", "belt"))
    return home(), Start(drop.q, drop.tool_state), Start(belt.q, belt.tool_state)


@pytest.mark.parametrize("speed", [0.1, 0.33, 0.5])
def test_never_is_not_said_where_the_whole_search_finds_a_plan(
    speed: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Among items that are about as far from the end of the window as the arm needs, from several starts."""
    rng, n_said = np.random.default_rng(31), 0
    for k in range(6):
        start = starts()[k % 3]
        travel = 2.85 - speed * float(rng.uniform(1.0, 4.0))
        if travel < 0.3:
            continue
        told = answer(k, travel, speed, start)
        if isinstance(told, str) and LATE in told:
            n_said += 1
            with monkeypatch.context() as patch:
                patch.setattr(axis_intercept, "too_late_by", lambda *args: -np.inf)
                patch.setattr(axis_intercept, "WIDELY_LATE", np.inf)
                patch.setattr(axis_windows, "least_times", lambda *args: np.array([-np.inf]))
                assert isinstance(answer(k, travel, speed, start), str)
    assert n_said > 0


def bound(items: ItemStream, name: str, start: Start) -> float:
    """S by which an item is too late at least, by the table."""
    told = list[float]()

    def listen(*args: Any) -> float:
        told.append(too_late_by(*args))
        return np.inf

    with pytest.MonkeyPatch.context() as patch, pytest.raises(NoPlanError):
        patch.setattr(axis_intercept, "too_late_by", listen)
        plan_intercept(context(), items, InterceptQuery(name, 0.0), start)
    return told[0]


def test_over_a_higher_neighbour_that_is_to_come_it_takes_longer() -> None:
    """Only beside the item in its lane, and upstream: then the item has to be lifted over it."""
    items, name = at(1, 2.0, 0.33)
    alone = bound(items, name, home())
    (riding,) = items.items
    half = riding.item.shape.reach(riding.T_belt_item[:3, :3])
    high = replace(riding.item, shape=Shape(ShapeKind.BOX, (0.1, 0.3, 0.25)))

    def with_neighbour(x: float, y: float) -> float:
        T = np.eye(4)
        T[:3, 3] = riding.T_belt_item[0, 3] + x, riding.T_belt_item[1, 3] + y, 0.125
        other = RidingItem("neighbour", high, 0.0, T)
        return bound(replace(items, items=(riding, other)), name, home())

    behind, aside = float(half[0]) + 0.07, float(half[1]) + 0.16
    assert alone + 0.15 < with_neighbour(-behind - 0.2, 0.0) < alone + 0.5
    assert with_neighbour(behind, 0.0) == with_neighbour(-behind, aside) == alone


def test_what_the_named_configurations_do_not_take_is_taken_from_others(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    items, name = at(1, 1.0, 0.33)
    seen, feasible = list[bool](), feasible_grasps

    def without_named(problem: PickProblem, exclude: Any) -> Any:
        seen.append(problem.by_named)
        return ((), Failures()) if problem.by_named else feasible(problem, exclude)

    monkeypatch.setattr(axis_intercept, "feasible_grasps", without_named)
    assert isinstance(plan_intercept(context(), items, InterceptQuery(name, 0.0), home()), Plan)
    assert seen[:3] == [True] * 3 and not any(seen[3:])


def test_what_is_about_to_leave_the_window_is_too_late_by_what_is_missing() -> None:
    near, far = (answer(1, travel, 0.33, home()) for travel in (2.8, 2.6))
    assert isinstance(near, str) and isinstance(far, str) and AT_ONCE in near and AT_ONCE in far
    by = [float(told.split("by ")[1].split(" ms")[0]) for told in (near, far)]
    assert by[0] - by[1] == pytest.approx(1e3 * 0.2 / 0.33, abs=2.0)


@pytest.mark.parametrize("travel", [1.0, 2.8, 3.0])
def test_what_is_never_met_is_told_without_a_search(travel: float) -> None:
    """With room to meet it, shortly before the end of the window, and past that."""
    items, name = at(1, travel, 0.33)
    told, asked = (
        why_never(context(), items, InterceptQuery(name, 0.0), home()),
        answer(1, travel, 0.33, home()),
    )
    assert (told is None) == isinstance(asked, Plan) == (travel == 1.0)
    if told is not None:
        assert str(told) == asked
