"""Picks that keep their item upright: planned within the bound, proven between samples, or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.tool import MOVING
from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.planning.assembly.tilt_bound import tilts, why_tilted
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.trajectory_sampling import states_at
from pickcli.verification.upright_check import check_upright
from pickcli.verification.verify import certifier
from support.belt_picks import context, home, stream
from support.command_line import apc, misused

ALLOWED = float(np.radians(30.0))


def planned(upright: float | None) -> Plan:
    items = stream()
    query = InterceptQuery(items.items[0].id, items.items[0].stamp + 0.1)
    return plan_intercept(context().keeping_upright(upright), items, query, home())


def tilt(plan: Plan, times: Array) -> Array:
    """Tilt (N,) in rad while the item is held, by forward kinematics at some times."""
    held = [each for each in plan.segments if each.held is not None]
    assert len({each.tool_state for each in held}) == 1
    times = np.append(held[0].t_start, times[(times > held[0].t_start) & (times < held[-1].t_end)])
    R = context().arm.tips(states_at(plan.trajectory, times, highest=0)[0], held[0].tool_state)[:, :3, :3]
    return tilts(R[0].T @ (0.0, 0.0, 1.0), R)


def dense(plan: Plan) -> Array:
    return np.random.default_rng(2).uniform(0.0, plan.trajectory.duration, 20_000)


def test_an_item_is_tilted_where_nobody_asks() -> None:
    plan = planned(None)
    assert plan.upright is None and float(tilt(plan, dense(plan)).max()) > ALLOWED


def test_an_item_stays_as_upright_as_asked_and_the_verifier_accepts_it() -> None:
    plan = planned(ALLOWED)
    assert plan.upright == ALLOWED and float(tilt(plan, dense(plan)).max()) <= ALLOWED
    items = stream()
    assert isinstance(certifier(items.scene_at(items.items[0].stamp + 0.1))(plan), Plan)


def as_stated(max_tilt: float) -> ItemStream:
    """The stream with items that may be tilted by that, as their item file says."""
    items = stream()
    return replace(
        items,
        items=tuple(replace(each, item=replace(each.item, max_tilt=max_tilt)) for each in items.items),
    )


@pytest.mark.parametrize("asked", [None, 2.0 * ALLOWED])
def test_an_item_stays_as_upright_as_its_file_states_whatever_else_is_asked(asked: float | None) -> None:
    items = as_stated(ALLOWED)
    query = InterceptQuery(items.items[0].id, items.items[0].stamp + 0.1)
    plan = plan_intercept(context().keeping_upright(asked), items, query, home())
    assert plan.upright == ALLOWED and float(tilt(plan, dense(plan)).max()) <= ALLOWED


def test_the_verifier_judges_by_the_item_file_where_the_plan_states_nothing() -> None:
    plan, items = planned(None), as_stated(ALLOWED)
    scene = items.scene_at(items.items[0].stamp + 0.1)
    (fault,) = check_upright(plan, scene)
    assert "tilts the item" in str(fault) and "30.00 are allowed" in str(fault)
    assert not [*check_upright(replace(plan, recovery=RecoveryLevel.BACKWARDS), scene)]


def test_a_plan_is_stale_where_the_bound_of_its_item_changes() -> None:
    hashes = {scene_hash(each.scene_at(0.0)) for each in (stream(), as_stated(ALLOWED), as_stated(0.1))}
    assert len(hashes) == 3


def test_the_bound_covers_all_that_is_between_the_samples_and_little_more() -> None:
    plan = planned(None)
    most = float(tilt(plan, dense(plan)).max())
    assert why_tilted(context().arm, plan, most) is not None
    assert why_tilted(context().arm, plan, most + np.radians(0.5)) is None


def test_a_bound_that_no_way_keeps_is_a_reason() -> None:
    with pytest.raises(NoPlanError, match="tilts the item"):
        planned(float(np.radians(1e-3)))


def test_a_tool_that_turns_with_the_item_is_refused() -> None:
    plan = planned(None)
    k = next(k for k, each in enumerate(plan.segments) if each.held is not None)
    segments = list(plan.segments)
    segments[k] = replace(segments[k], tool_state=MOVING)
    reason = why_tilted(context().arm, replace(plan, segments=tuple(segments)), ALLOWED)
    assert reason is not None and "the tool turns it" in str(reason)


@pytest.mark.parametrize("degrees", ["0", "-5", "91", "nan", "level"])
def test_what_is_no_bound_of_a_tilt_is_a_usage_error(degrees: str) -> None:
    named = "--scene", "s.json", "--bin", "bin_A", "--item", "soap"
    misused(apc("plan-pick", *named, "--upright", degrees), "--upright")
