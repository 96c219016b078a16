"""The way out from where a motion stopped: home, whatever the cup touches, certified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.collision.motion_segment import Mode
from pickcli.errors import NoPlanError
from pickcli.geometry import pose
from pickcli.grasping import suction_grasping
from pickcli.grasping.suction_candidates import sample_suctions
from pickcli.motion.plan import RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.recovery_plan import plan_recovery
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.verification.verify import verify

SceneWith = Callable[..., Scene]


def stopped_at_contact(
    context: PlanningContext, scene: Scene, home: Start, bin_name: str, item: str
) -> Start:
    plan = plan_pick(context, scene, PickQuery(bin_name, item), home)
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    return Start(plan.trajectory.sample(contact.t_end)[0], contact.tool_state)


def test_the_way_out_of_a_bin_leads_home(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    out = plan_recovery(context, scene, stopped_at_contact(context, scene, home, "bin_B", "crayola_24_ct"))
    np.testing.assert_allclose(out.trajectory.positions[-1], home.q)
    assert out.segments[0].kind is SegmentKind.DEPART
    assert verify(out, scene).reasons == ()


@pytest.mark.parametrize("moved", [0.0, 0.004])
def test_beside_a_tall_item_the_cup_goes_back_first(
    context: PlanningContext,
    scene_with: SceneWith,
    home: Start,
    monkeypatch: pytest.MonkeyPatch,
    moved: float,
) -> None:
    """Upwards it would scrape along; moved: m that the item has come towards the cup since."""

    def from_the_side(*args: Any) -> Any:
        found = sample_suctions(*args)
        return found.select([batch.kinds == "side" for batch in found.batches])

    monkeypatch.setattr(suction_grasping, "sample_suctions", from_the_side)
    scene = scene_with(("kleenex_tissue_box", "bin_D", 0.2, 0.04))
    stuck = stopped_at_contact(context, scene, home, "bin_D", "kleenex_tissue_box")
    tip = context.arm.tip(stuck.q, stuck.tool_state)
    (box,) = scene.items
    T = pose(-moved * tip[:3, 2]) @ box.T_world_item
    scene = replace(scene, items=(replace(box, T_world_item=T),))
    out = plan_recovery(context, scene, stuck)
    np.testing.assert_allclose(out.trajectory.positions[-1], home.q)
    freed = context.arm.tip(out.trajectory.sample(out.segments[0].t_end)[0], stuck.tool_state)
    assert (freed - tip)[:3, 3] @ tip[:3, 2] < -0.015
    assert verify(out, scene).reasons == ()


@pytest.fixture(scope="module")
def squeezed(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> tuple[Scene, StoppedMotion, Start]:
    """Stopped at contact, with a soap bar seen 1 mm from the lance, where 3 mm are wanted."""
    free = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    plan = plan_pick(context, free, PickQuery("bin_B", "crayola_24_ct"), home)
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0), ("dove_beauty_bar", "bin_B", 0.16, 0.043))
    bar = scene.find("dove_beauty_bar")
    T = bar.T_world_item.copy()
    T[2, 3] = scene.find("crayola_24_ct").T_world_item[2, 3] + 0.0245
    scene = scene.moved(replace(bar, T_world_item=T))
    start = Start(plan.trajectory.sample(contact.t_end)[0], contact.tool_state)
    return scene, StoppedMotion(plan, contact.t_end), start


def test_what_is_nearer_than_the_clearance_stops_only_the_strictest_level(
    context: PlanningContext, squeezed: tuple[Scene, StoppedMotion, Start]
) -> None:
    scene, stopped, start = squeezed
    with pytest.raises(NoPlanError, match="dove_beauty_bar"):
        plan_recovery(context, scene, start)
    for level in RecoveryLevel:
        if level is RecoveryLevel.AS_PLANNED:
            continue
        out = plan_recovery(context, scene, start, level=level, stopped=stopped)
        assert out.recovery is level
        assert verify(out, scene).reasons == ()
        if level in (RecoveryLevel.OPENING, RecoveryLevel.SLOWLY):
            # A bent lip touches what it was pressed on until it has come free.
            assert "crayola_24_ct" in out.segments[0].touching
        assert not any(segment.touching for segment in out.segments[1:])


@pytest.mark.parametrize("level", [RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING])
def test_the_strict_levels_lead_home(
    context: PlanningContext, scene_with: SceneWith, home: Start, level: RecoveryLevel
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    stuck = stopped_at_contact(context, scene, home, "bin_B", "crayola_24_ct")
    out = plan_recovery(context, scene, stuck, level=level)
    np.testing.assert_allclose(out.trajectory.positions[-1], home.q)


def test_a_motion_that_stopped_where_it_began_has_not_moved(
    squeezed: tuple[Scene, StoppedMotion, Start],
) -> None:
    _, stopped, _ = squeezed
    assert stopped.has_moved
    assert [replace(stopped, path_time=t).has_moved for t in (0.0, 5e-4, 0.01)] == [False] * 3


def test_backwards_is_the_way_it_came(
    context: PlanningContext, squeezed: tuple[Scene, StoppedMotion, Start]
) -> None:
    scene, stopped, start = squeezed
    back = plan_recovery(context, scene, start, level=RecoveryLevel.BACKWARDS, stopped=stopped)
    np.testing.assert_allclose(back.trajectory.positions[0], start.q, atol=1e-9)
    np.testing.assert_allclose(back.trajectory.positions[-1], stopped.plan.trajectory.positions[0], atol=1e-9)
    way = stopped.plan.trajectory.sample(np.linspace(0.0, stopped.path_time, 20_000))
    for q in back.trajectory.sample(np.linspace(0.0, back.trajectory.duration, 60)):
        assert np.abs(way - q).max(axis=1).min() < 2e-4
    with pytest.raises(NoPlanError, match="nothing to go back along"):
        plan_recovery(context, scene, start, level=RecoveryLevel.BACKWARDS)


def test_a_jog_is_short_and_takes_what_is_nearest_apart(
    context: PlanningContext, squeezed: tuple[Scene, StoppedMotion, Start]
) -> None:
    scene, _, start = squeezed
    jog = plan_recovery(context, scene, start, level=RecoveryLevel.JOG)
    nearest = context.checker_for(scene, Mode(start.tool_state))
    before, after = (nearest.clearance(q).distance for q in jog.trajectory.positions[[0, -1]])
    assert after > before
    tips = context.arm.tips(jog.trajectory.positions, start.tool_state)[:, :3, 3]
    assert np.linalg.norm(np.diff(tips, axis=0), axis=1).sum() < 0.03


@pytest.mark.parametrize("bringing", list(ItemRecovery))
@pytest.mark.parametrize("share", [0.05, 0.3, 0.6, 0.9, 0.97])
@pytest.mark.parametrize("into", ["tote", "bin_H"])
def test_what_may_be_in_the_cup_is_brought_on_or_back(
    context: PlanningContext,
    scene_with: SceneWith,
    home: Start,
    bringing: ItemRecovery,
    share: float,
    into: str,
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    plan = plan_pick(context, scene, PickQuery("bin_B", "crayola_24_ct", into), home)
    whole = StoppedMotion(plan, 0.0)
    assert whole.taken_at is not None and whole.let_go_at is not None
    moving_until = whole.let_go_at - 0.1 - context.settings.release_time
    stopped = StoppedMotion(plan, whole.taken_at + share * (moving_until - whole.taken_at))
    placed = scene.find("crayola_24_ct")
    scene = replace(scene.without(placed.id), held=stopped.held_item(context.cell.robot, placed))
    brought = bring_item(stopped, bringing, scene, context.arm.limits, 0)
    assert verify(brought, scene, plan.trajectory).reasons == ()
    assert {segment.held for segment in brought.segments} == {"crayola_24_ct"} and brought.events == ()
    np.testing.assert_allclose(
        brought.trajectory.positions[0], plan.trajectory.sample(stopped.path_time)[0], atol=1e-9
    )
    end = {ItemRecovery.ON: stopped.let_go_at, ItemRecovery.BACK: stopped.taken_at}[bringing]
    assert end is not None
    np.testing.assert_allclose(brought.trajectory.positions[-1], plan.trajectory.sample(end)[0], atol=1e-9)


def test_where_nothing_is_carried_there_is_nothing_to_bring(
    context: PlanningContext, squeezed: tuple[Scene, StoppedMotion, Start]
) -> None:
    scene, stopped, _ = squeezed
    with pytest.raises(NoPlanError, match="not carried"):
        bring_item(stopped, ItemRecovery.BACK, scene, context.arm.limits, 0)
