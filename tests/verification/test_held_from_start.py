"""A plan that begins with an item in the cup: what is in it says the scene, and not the plan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.scene.scene import HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.structure_check import check_structure
from pickcli.verification.verify import verify
from support.handmade_plans import CRAYOLA, Builder, bound, cell, loaded, make_scene, pick, place, tip

Q = np.asarray(cell().configurations["home"].q)
WAY = (0.0, 0.0, 0.1)  # m that the tool goes up


def in_the_cup() -> HeldItem:
    plan, scene = pick()
    T = pose_in_tool(plan, scene)
    assert T is not None
    return HeldItem(CRAYOLA, scene.find(CRAYOLA).item, T)


def holding(*items: PlacedItem, held: HeldItem | None = None, noise: PoseNoise | None = None) -> Scene:
    return replace(make_scene(*items, noise=noise), held=held or in_the_cup())


def carried(scene: Scene, touching: tuple[str, ...] = (), way: Array | None = None) -> Plan:
    """A way with the item in the cup, from where something stopped."""
    T, grasp = tip(Q), pick()[0].grasp
    builder = Builder(Q)
    there = pose(T[:3, 3] + np.asarray(WAY if way is None else way), R=T[:3, :3])
    builder.line(SegmentKind.LIFT, there, 2.0, held=CRAYOLA, touching=touching)
    plan = Plan("bring", "", "", 0, tuple(builder.segments), builder.trajectory(), (), grasp,
                recovery=RecoveryLevel.AS_PLANNED)  # fmt: skip
    return bound(loaded(plan, in_the_cup().T_tip_item), scene)


def told(plan: Plan, scene: Scene) -> str:
    return "; ".join(map(str, verify(plan, scene).reasons))


def seen_at(T: Array) -> PlacedItem:
    return PlacedItem(CRAYOLA, cell().item(CRAYOLA), "bin_A", T)


def test_what_the_scene_says_is_in_the_cup_may_be_carried() -> None:
    scene = holding()
    assert told(carried(scene), scene) == ""


def test_what_only_the_plan_says_is_in_the_cup_is_not() -> None:
    seen = make_scene(seen_at(tip(Q) @ in_the_cup().T_tip_item))
    assert "not in the cup: the plan begins holding crayola" in told(carried(seen), seen)
    other = holding(seen.items[0], held=replace(in_the_cup(), id="dove_beauty_bar"))
    assert "the cup holds dove_beauty_bar" in told(carried(other), other)


def test_no_plan_forgets_what_the_cup_holds() -> None:
    scene = holding()
    builder = Builder(Q)
    builder.wait(SegmentKind.TRANSIT, 0.5)
    empty = bound(Plan("move", "", "", 0, tuple(builder.segments), builder.trajectory(), ()), scene)
    assert "the plan begins holding nothing; by `held` of the scene the cup holds crayola" in told(
        empty, scene
    )


def test_it_hangs_as_the_grasp_says() -> None:
    aside = replace(in_the_cup(), T_tip_item=pose((0.0, 0.006, 0.0)) @ in_the_cup().T_tip_item)
    scene = holding(held=aside)
    assert "misses the item" in told(carried(scene), scene)


def test_what_is_seen_in_the_way_stands_there_whatever_the_sensor_says() -> None:
    hand = tip(Q) @ in_the_cup().T_tip_item
    scene = holding(seen_at(pose((0.0, 0.0, 0.05)) @ hand))
    assert f"{CRAYOLA} and {CRAYOLA} as seen" in told(carried(scene), scene)
    scene = holding(seen_at(pose((0.0, 0.0, 0.003)) @ hand))
    assert told(carried(scene), scene) == ""


def test_a_lift_that_starts_clear_explains_nothing_by_where_it_ends() -> None:
    """A bar known to 3 mm stands near over the item: it may be come to, and not gone into."""
    noise, held = PoseNoise(0.003, 0.0), in_the_cup()
    hand = tip(Q) @ held.T_tip_item
    up = float(held.item.shape.reach(hand[:3, :3])[2]) + float(
        cell().item("dove_beauty_bar").shape.reach(np.eye(3))[2]
    )
    bar = place("dove_beauty_bar", tuple(hand[:3, 3] + (0.0, 0.0, up + 0.004)), "bin_A")
    scene = holding(bar, noise=noise)
    for way, is_refused in ((0.004, False), (0.009, True)):
        plan = carried(scene, ("dove_beauty_bar",), np.array([0.0, 0.0, way]))
        assert ("planned contact too deep" in told(plan, scene)) is is_refused


@pytest.mark.parametrize("bringing", list(ItemRecovery))
@pytest.mark.parametrize("kind", [SegmentKind.LIFT, SegmentKind.TRANSFER])
def test_a_carry_that_stopped_goes_on_with_the_item_as_it_hangs(
    bringing: ItemRecovery, kind: SegmentKind
) -> None:
    """The cup is pressed 2 mm beyond the surface: so much nearer than the grasp says hangs the item."""
    plan, before = pick()
    at = next(s for s in plan.segments if s.kind is kind)
    stopped = StoppedMotion(plan, (at.t_start + at.t_end) / 2)
    held = stopped.held_item(before.cell.robot, before.find(CRAYOLA))
    assert held.T_tip_item == pytest.approx(pose_in_tool(plan, before), abs=1e-9)
    scene = replace(before.without(CRAYOLA), held=held)
    brought = bring_item(stopped, bringing, scene, scene.cell.robot.limits, 0)
    assert verify(brought, scene, plan.trajectory).reasons == ()


def test_what_is_let_go_is_not_taken_once_more() -> None:
    """A pick whose first segment carries the item already, and lets it go before the contact."""
    plan, scene = pick()
    first = replace(plan.segments[0], held=CRAYOLA)
    again = replace(plan, segments=(first, *plan.segments[1:]))
    assert "more than once" in "; ".join(map(str, check_structure(again, scene)))
    assert "more than once" not in "; ".join(map(str, check_structure(plan, scene)))
