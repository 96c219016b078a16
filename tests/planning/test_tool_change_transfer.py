"""Items from the tote are laid down flat: the cup turns with the item while the arm is at rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import inverse, pose
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.planning.stages import transfer
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.verify import certify, verify
from support.tool_states import DOWN, STRAIGHT

FLAT = ["jane_eyre_dvd", "scotch_bubble_mailer", "dove_beauty_bar"]
INTO = "bin_E"


def in_tote(cell: Cell, name: str) -> Scene:
    item = cell.item(name)
    at = pose([0.0, 0.0, float(item.shape.extents[2]) / 2 + 0.0005], rpy=[0.0, 0.0, 0.4])
    placed = PlacedItem(name, item, TOTE, cell.T_world_place(cell.places[TOTE]) @ at)
    return Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))


def stow(context: PlanningContext, scene: Scene, home: Start) -> Plan:
    return plan_pick(context, scene, PickQuery(TOTE, scene.items[0].id, INTO), home)


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    return in_tote(cell, FLAT[0])


@pytest.fixture(scope="module")
def plan(context: PlanningContext, scene: Scene, home: Start) -> Plan:
    return stow(context, scene, home)


@pytest.mark.parametrize("name", FLAT)
def test_it_lies_with_its_upper_side_up_and_parallel_to_the_walls(
    cell: Cell, context: PlanningContext, home: Start, name: str
) -> None:
    scene = in_tote(cell, name)
    plan = certify(stow(context, scene, home), scene)
    world = World(scene, home.q)
    run = execute(plan, world)
    stowed = world.placed(name)
    assert not run.stopped and not run.collisions and stowed.location == INTO
    R = (inverse(scene.T_world_pod) @ stowed.T_world_item)[:3, :3]
    assert R[2, 2] > np.cos(np.radians(8.0))  # the floor drops by five degrees
    assert np.abs(R[:2, :2]).max(axis=0).min() > np.cos(np.radians(5.0))
    assert plan.grasp is not None and run.max_load < 1.1 * plan.grasp.load_ratio
    world.close()


def test_the_arm_rests_while_the_cup_turns(plan: Plan) -> None:
    (turn,) = (segment for segment in plan.segments if segment.held and segment.tool_state == MOVING)
    q = plan.trajectory.sample(np.linspace(turn.t_start, turn.t_end, 50))
    assert np.ptp(q, axis=0).max() < 1e-12
    (command,) = (event for event in plan.events if event.action == "down")
    assert (command.t_trigger, command.t_anchor) == pytest.approx((turn.t_start, turn.t_end))
    states = [segment.tool_state for segment in plan.segments if segment.held]
    assert states == [STRAIGHT] * states.index(MOVING) + [MOVING] + [DOWN] * states[::-1].index(MOVING)


def with_turn(plan: Plan, **changes: object) -> Plan:
    segments = list(plan.segments)
    k = next(k for k, s in enumerate(segments) if s.held and s.tool_state == MOVING)
    segments[k] = replace(segments[k], **changes)  # type: ignore[arg-type]
    if "t_start" in changes:
        segments[k - 1] = replace(segments[k - 1], t_end=segments[k].t_start)
    return replace(plan, segments=tuple(segments))


def moved(event: Event, by: float) -> Event:
    assert event.t_trigger is not None and event.t_anchor is not None
    anchor = replace(event.anchor, offset=event.anchor.offset + by)
    return replace(event, anchor=anchor, t_trigger=event.t_trigger + by, t_anchor=event.t_anchor + by)


def test_the_verifier_wants_the_arm_at_rest_and_the_command_with_the_turn(plan: Plan, scene: Scene) -> None:
    assert verify(plan, scene).reasons == ()
    turn = next(s for s in plan.segments if s.held and s.tool_state == MOVING)
    events = tuple(  # their anchors move with the segment
        replace(e, t_trigger=e.t_trigger - 0.1, t_anchor=e.t_anchor - 0.1)
        if e.action in ("down", "read") and e.t_trigger is not None and e.t_anchor is not None
        else e
        for e in plan.events
    )
    early = with_turn(replace(plan, events=events), t_start=turn.t_start - 0.1)
    details = [r.detail for r in verify(early, scene).reasons if r.what.startswith("tool changes its state")]
    assert any("a joint moves" in detail for detail in details)
    assert any("no command" in detail for detail in details)
    events = tuple(moved(e, -0.05) if e.action == "down" else e for e in plan.events)
    found = {r.what for r in verify(replace(plan, events=events), scene).reasons}
    assert {"tool changes its state while holding", "wrong tool state"} <= found


def test_a_change_of_state_that_ends_the_hold_is_refused(plan: Plan, scene: Scene) -> None:
    """Its load is known only if the item is held in one state before it and in another one after it."""
    turn = next(k for k, s in enumerate(plan.segments) if s.held and s.tool_state == MOVING)
    for changed in (turn - 1, turn + 1):
        segments = list(plan.segments)
        segments[changed] = replace(segments[changed], tool_state=MOVING)
        found = verify(replace(plan, segments=tuple(segments)), scene).reasons
        assert any("known only between two segments" in reason.detail for reason in found)
    segments = [replace(s, held=None) if k > turn else s for k, s in enumerate(plan.segments)]
    assert verify(replace(plan, segments=tuple(segments)), scene).certificate is None


@pytest.mark.parametrize("share", [0.2, 0.8])
def test_a_stopped_motion_is_retraced_in_the_state_that_the_tool_is_in(
    context: PlanningContext, plan: Plan, scene: Scene, share: float
) -> None:
    """Back until the tool changes its state, on from then on: the item ends where it was taken or goes."""
    turn = next(s for s in plan.segments if s.held and s.tool_state == MOVING)
    item = scene.items[0]
    for segment in (s for s in plan.segments if s.held):
        t = segment.t_start + share * (segment.t_end - segment.t_start)
        stopped = StoppedMotion(plan, t)
        assert stopped.holding_state == (STRAIGHT if t < turn.t_start else DOWN)
        held = replace(scene, items=(), held=stopped.held_item(context.cell.robot, item))
        way, other = (
            (ItemRecovery.BACK, ItemRecovery.ON) if t < turn.t_start else (ItemRecovery.ON, ItemRecovery.BACK)
        )
        if segment.kind is not SegmentKind.PLACE:
            brought = bring_item(stopped, way, held, context.arm.limits, 0)
            assert verify(brought, held, plan.trajectory).reasons == ()
        with pytest.raises(NoPlanError, match="no way with this state of the tool"):
            bring_item(stopped, other, held, context.arm.limits, 0)


def test_the_load_of_the_turn_is_checked_by_the_verifier(plan: Plan, scene: Scene) -> None:
    """Beside the cup the item loads it across; a plan that states only the load below it is refused."""
    assert plan.grasp is not None
    assert plan.grasp.shear > 0.9 * 9.81 * scene.items[0].item.mass
    stated = replace(plan.grasp, shear=plan.grasp.shear / 2)
    reasons = verify(replace(plan, grasp=stated), scene).reasons
    assert ("load not as stated", "grasp.shear") in [(r.what, r.where) for r in reasons]


def test_an_item_that_the_cup_would_lose_in_the_turn_is_stood_up_instead(
    context: PlanningContext, scene: Scene, home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    def lost(*args: object) -> Failures:
        return Failures.of(Reason("does not hold", "change of the tool's state"))

    monkeypatch.setattr(transfer, "plan_transfer_with_tool_change", lost)
    standing = certify(stow(context, scene, home), scene)
    assert {s.tool_state for s in standing.segments if s.held} == {STRAIGHT}
    world = World(scene, home.q)
    execute(standing, world)
    outward = (inverse(scene.T_world_pod) @ world.placed(FLAT[0]).T_world_item)[:3, 2]
    assert outward[0] < -0.9 and not world.contacts.collisions
    world.close()


def test_a_heavy_item_is_not_turned(cell: Cell, context: PlanningContext, home: Start) -> None:
    """Socks hang below a cup with two fifths of the vacuum; beside it their weight would peel it off."""
    scene = in_tote(cell, "hanes_tube_socks")
    socks = scene.items[0]
    leaking = replace(socks.item, seals=dict.fromkeys(socks.item.seals, 0.4))
    with pytest.raises(NoPlanError) as caught:
        stow(context, scene.moved(replace(socks, item=leaking)), home)
    assert ("does not hold", "change of the tool's state") in {
        (r.what, r.where) for r in caught.value.reasons
    }


def test_a_place_segment_follows_the_turn(plan: Plan) -> None:
    kinds = [segment.kind for segment in plan.segments if segment.tool_state == DOWN and segment.held]
    assert kinds[0] is SegmentKind.TRANSFER and kinds[-1] is SegmentKind.PLACE
