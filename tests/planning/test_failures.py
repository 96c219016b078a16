"""An item that any stage of a pick meets is named when the pick fails, and without it there is a plan."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoExtractionError, NoPlanError, Reason
from pickcli.geometry import pose
from pickcli.io_events import event_binding
from pickcli.io_events.resolve import ResolvedEvents
from pickcli.motion.segment import SegmentKind
from pickcli.planning.assembly import carried_motion
from pickcli.planning.assembly.proven_timing import CarriedRun, carried_run, proven_run
from pickcli.planning.blockers import blocking_items
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from support.tool_states import STRAIGHT

SceneWith = Callable[..., Scene]

ITEM, FROM, INTO, BLOCKER = "crayola_24_ct", "bin_B", "bin_F", "dove_beauty_bar"


def with_crate(
    scene: Scene, place: str, at: tuple[float, float, float], size: tuple[float, float, float]
) -> Scene:
    """The scene with the blocker as a crate of a size, its centre at a point in the frame of a place."""
    item = replace(scene.cell.item(BLOCKER), shape=Shape(ShapeKind.BOX, size))
    T = scene.T_world_place(scene.cell.places[place]) @ pose(at)
    return replace(scene, items=(*scene.items, PlacedItem(BLOCKER, item, place, T)))


def refusal(context: PlanningContext, scene: Scene, query: PickQuery, start: Start) -> NoPlanError:
    """Why a pick fails that succeeds without the blocker."""
    assert plan_pick(context, scene.without(BLOCKER), query, start).segments
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene, query, start)
    return caught.value


def test_a_start_that_is_not_free_is_the_only_reason(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with((ITEM, FROM, 0.2, 0.0))
    tip = PlanningContext(scene.cell).arm.tip(home.q, home.tool_state)[:3, 3]
    T_place_world = np.linalg.inv(scene.T_world_place(scene.cell.places[INTO]))
    x, y, z = (T_place_world @ (*tip, 1.0))[:3].tolist()
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, with_crate(scene, INTO, (x, y, z), (0.1, 0.1, 0.1)), PickQuery(FROM, ITEM), home)
    (reason,) = caught.value.reasons
    assert reason.what == "collision" and reason.where == "start" and BLOCKER in str(reason)


def test_what_fills_the_floor_of_the_destination(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    room = context.cell.places[INTO].room
    size = (room.depth - 0.06, room.y_range[1] - room.y_range[0] - 0.02, 0.1)
    at = (room.depth / 2, sum(room.y_range) / 2, room.floor_front + 0.052)
    scene = with_crate(scene_with((ITEM, FROM, 0.2, 0.0)), INTO, at, size)
    error = refusal(context, scene, PickQuery(FROM, ITEM, into=INTO), home)
    assert error.in_the_way == (BLOCKER,)
    assert "no free place on the floor" in {r.what for r in error.reasons if r.in_the_way == BLOCKER}
    assert not isinstance(error, NoExtractionError)  # it may be brought elsewhere


def test_what_no_cup_holds_leaves_its_bin_for_no_destination(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(("fitness_gear_3lb_dumbbell", FROM, 0.2, 0.0))
    with pytest.raises(NoExtractionError, match="cannot be held by suction"):
        plan_pick(context, scene, PickQuery(FROM, "fitness_gear_3lb_dumbbell", into=INTO), home)


def test_what_fills_the_tote(context: PlanningContext, scene_with: SceneWith, home: Start) -> None:
    x, y, _ = context.cell.places[TOTE].room.size
    scene = with_crate(scene_with((ITEM, FROM, 0.2, 0.0)), TOTE, (0.0, 0.0, 0.25), (x - 0.02, y - 0.02, 0.5))
    error = refusal(context, scene, PickQuery(FROM, ITEM), home)
    assert "would drop too far" in {reason.what for reason in error.reasons}
    assert error.in_the_way == (BLOCKER,)


def test_what_hangs_over_the_tote(context: PlanningContext, scene_with: SceneWith, home: Start) -> None:
    """It is no part of the pile, and met by the arm alone."""
    x, y, z = context.cell.places[TOTE].room.size
    piled = with_crate(scene_with((ITEM, FROM, 0.2, 0.0)), TOTE, (0.0, 0.0, z + 0.17), (x, y, 0.3))
    crate = replace(piled.find(BLOCKER), location=INTO)
    scene = replace(piled, items=(*piled.without(BLOCKER).items, crate))
    error = refusal(context, scene, PickQuery(FROM, ITEM), home)
    assert "no free place in the tote" in {reason.what for reason in error.reasons}
    assert error.in_the_way == (BLOCKER,)


def test_what_stands_before_the_target_is_cleared(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = with_crate(scene_with((ITEM, FROM, 0.3, 0.0)), FROM, (0.12, 0.0, 0.07), (0.08, 0.24, 0.12))
    query = PickQuery(FROM, ITEM)
    assert BLOCKER in refusal(context, scene, query, home).in_the_way
    cleared = blocking_items(lambda seen: plan_pick(context, seen, query, home), scene, scene.find(ITEM))
    assert cleared == (BLOCKER,)


def in_front(context: PlanningContext, scene: Scene) -> tuple[MotionSegment, Scene]:
    """An edge between two named configurations, and the scene with a crate around the tool half-way."""
    named = context.cell.configurations
    edge = np.stack([named["bin_D"].q, named["bin_G"].q])
    T = context.arm.tip(edge.mean(axis=0), STRAIGHT)
    item = replace(scene.cell.item(BLOCKER), shape=Shape(ShapeKind.BOX, (0.1, 0.1, 0.1)))
    blocked = replace(scene, items=(*scene.items, PlacedItem(BLOCKER, item, FROM, T)))
    return MotionSegment(SegmentKind.TRANSIT, edge, mode=Mode(STRAIGHT)), blocked


def test_what_a_timed_run_meets(context: PlanningContext, scene_with: SceneWith) -> None:
    """The proof after the timing names it; that no blend is free says nothing of what stands there."""
    scene = scene_with()
    segment, blocked = in_front(context, scene)
    assert not isinstance(proven_run(context, scene, [segment]), Failures)
    failures = proven_run(context, blocked, [segment])
    assert isinstance(failures, Failures)
    assert failures.in_the_way == (BLOCKER,)


def test_what_a_timed_run_with_an_item_meets(
    context: PlanningContext, scene_with: SceneWith, home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    carried = []

    def kept(*args):  # type: ignore[no-untyped-def]
        carried.append(args)
        return carried_run(*args)

    monkeypatch.setattr(carried_motion, "carried_run", kept)
    plan_pick(context, scene_with((ITEM, FROM, 0.2, 0.0)), PickQuery(FROM, ITEM), home)
    context, scene, segments, grasp, hold, most = carried[0]
    run = carried_run(context, scene, segments, grasp, hold, most)
    assert isinstance(run, CarriedRun)
    transfer = next(segment for segment in segments if segment.kind is SegmentKind.TRANSFER)
    longest = int(np.argmax(np.linalg.norm(np.diff(transfer.waypoints, axis=0), axis=1)))
    T = context.arm.tip(transfer.waypoints[longest : longest + 2].mean(axis=0), grasp.tool_state)
    item = replace(scene.cell.item(BLOCKER), shape=Shape(ShapeKind.BOX, (0.1, 0.1, 0.1)))
    blocked = replace(scene, items=(*scene.items, PlacedItem(BLOCKER, item, TOTE, T)))
    failures = carried_run(context, blocked, segments, grasp, hold, most)
    assert isinstance(failures, Failures)
    assert failures.in_the_way == (BLOCKER,)


def test_every_event_that_cannot_be_bound(
    context: PlanningContext, scene_with: SceneWith, home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    unbound = (Reason("anchor off the path", "pump on"), Reason("anchor off the path", "valve off", "", "x"))
    monkeypatch.setattr(event_binding, "resolve", lambda *args: ResolvedEvents((), 0.0, unbound))
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene_with((ITEM, FROM, 0.2, 0.0)), PickQuery(FROM, ITEM), home)
    assert set(unbound) <= set(caught.value.reasons)
