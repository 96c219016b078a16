"""What is said at once of items that are never met agrees with the whole search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan
from pickcli.planning import intercept
from pickcli.planning.intercept import InterceptQuery, plan_intercept
from pickcli.planning.start_state import Start
from pickcli.scene.item_stream import ItemStream, RidingItem
from support.belt_picks import cell, context, home, stream

AT_ONCE = "at least, whatever the grasp"


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
        if isinstance(told, str) and AT_ONCE in told:
            n_said += 1
            with monkeypatch.context() as patch:
                patch.setattr(intercept, "too_late_by", lambda *args: -np.inf)
                assert isinstance(answer(k, travel, speed, start), str)
    assert n_said > 0


def test_what_is_about_to_leave_the_window_is_too_late_by_what_is_missing() -> None:
    near, far = (answer(1, travel, 0.33, home()) for travel in (2.8, 2.6))
    assert isinstance(near, str) and isinstance(far, str) and AT_ONCE in near and AT_ONCE in far
    by = [float(told.split("by ")[1].split(" ms")[0]) for told in (near, far)]
    assert by[0] - by[1] == pytest.approx(1e3 * 0.2 / 0.33, abs=2.0)
