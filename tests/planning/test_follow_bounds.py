"""What is said at once of items that an arm cannot follow agrees with the whole search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import NoPlanError, Reason
from pickcli.grasping.antipodal import pinch_turns, pinches
from pickcli.planning.belt_picks import arm_intercept
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.follow_bounds import RideTimes, why_unreached
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.item_stream import ItemStream
from support.pr2_picks import context, home, stream

SPEED = 0.33


def told(planned_by: PlanningContext, travel: float, first: float = 2.0, last: float = 20.0) -> Reason | None:
    """What is said of the first item, with its middle at a travel at the start."""
    items, name = stream(), stream().items[0].id
    now = items.items[0].stamp + (travel - float(items.items[0].T_belt_item[0, 3])) / SPEED
    return why_unreached(
        planned_by, items.carrier, items.scene_at(now), name, RideTimes(SPEED, first, last)
    )  # fmt: skip


def test_an_item_that_rides_out_of_reach_is_told() -> None:
    reason = told(context(), 1.0)
    assert reason is not None and reason.what == "out of reach" and "ride along" in reason.detail


def test_an_item_in_reach_is_not_told() -> None:
    assert told(context(), 0.0) is None


def test_the_far_arm_reaches_farther() -> None:
    assert told(context("right"), 1.0) is None


def test_an_item_that_leaves_before_it_is_lifted_is_too_late() -> None:
    reason = told(context(), 0.0, 2.0, 2.5)  # closing and the lift take 0.72 s
    assert reason is not None and str(reason).endswith(
        "too late: by 222 ms for the first contact that is tried"
    )


@pytest.mark.parametrize("arm", ["left", "right"])
def test_never_is_not_said_where_the_search_without_bounds_finds_a_plan(
    arm: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    items = replace(stream(), cell=context(arm).cell)
    n_told = 0
    for k, left in ((0, 3.3), (1, 3.0), (3, 2.7)):
        riding = items.items[k]
        now = riding.stamp + (2.0 - left * SPEED - float(riding.T_belt_item[0, 3])) / SPEED
        query = InterceptQuery(riding.id, now, f"bin_{arm}")
        if why_never(context(arm), items, query, home(arm)) is None:
            continue
        n_told += 1
        assert _searched(items, query, arm, monkeypatch)
    assert n_told > 0


def _searched(items: ItemStream, query: InterceptQuery, arm: str, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether the search without bounds finds no plan either."""
    with monkeypatch.context() as patch:
        patch.setattr(arm_intercept, "why_unreached", lambda *args: None)
        patch.setattr(arm_intercept, "SOONEST", 0.7)
        try:
            plan_intercept(context(arm), items, query, home(arm))
        except NoPlanError:
            return True
    return False


def test_nothing_is_said_of_grasps_that_are_not_sampled() -> None:
    """Recorded grasps, and those of a region, may be in any orientation."""
    assert told(replace(context(), recorded=()), 1.0) is None
    assert told(context().with_approach(GraspApproach.REGION), 1.0) is None


def test_pinches_have_no_other_orientations() -> None:
    shape, fan = stream().items[0].item.shape, (0.0, 0.25, -0.25)
    for way_in in np.eye(3):
        turns = pinch_turns(shape, way_in, fan)
        for pinch in pinches(shape, (0.02, 0.02), way_in, fan, 2, np.random.default_rng(1), 2):
            off = np.abs(turns - pinch.T_item_tip[:3, :3]).max(axis=(1, 2))
            assert off.min() < 1e-12
