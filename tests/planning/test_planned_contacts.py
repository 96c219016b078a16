"""Planned contact is limited twice: planner and second opinion each refuse what goes deeper."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import extraction_of
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.verification.verify import verify
from support.handmade_piles import lying_on

BIN = "bin_K"
CASE, BOOK = "jane_eyre_dvd", "i_am_a_bunny_book"


@pytest.fixture(scope="module", params=[PoseNoise(), PoseNoise(0.002, float(np.radians(1.0)))])
def under(request: pytest.FixtureRequest, cell: Cell) -> Scene:
    """A thin box with a book on it."""
    return lying_on(cell, BIN, CASE, BOOK, request.param)


def told_to_touch(plan: Plan, scene: Scene, name: str) -> Plan:
    """The plan bound to another scene, with one more name that contact and lift may touch."""
    kinds = (SegmentKind.CONTACT, SegmentKind.LIFT)
    segments = tuple(
        replace(s, touching=tuple(sorted({*s.touching, name}))) if s.kind in kinds and s.touching else s
        for s in plan.segments
    )
    return replace(plan, segments=segments, scene_hash=scene_hash(scene))


def test_the_planner_refuses_to_lift_under_something(
    context: PlanningContext, under: Scene, home: Start
) -> None:
    with pytest.raises(NoPlanError, match="rests on the target") as caught:
        plan_pick(context, under, PickQuery(BIN, CASE), home)
    assert caught.value.in_the_way == (BOOK,)


def test_the_second_opinion_refuses_it_by_the_depth_alone(
    context: PlanningContext, under: Scene, home: Start
) -> None:
    alone = under.without(BOOK)
    plan = plan_pick(context, alone, PickQuery(BIN, CASE), home)
    assert verify(plan, alone).certificate is not None
    reasons = verify(told_to_touch(plan, under, BOOK), under).reasons
    assert any(r.what == "planned contact too deep" and BOOK in r.detail for r in reasons)


def test_the_second_opinion_refuses_to_take_away_what_others_need(
    context: PlanningContext, under: Scene, home: Start
) -> None:
    alone = under.without(BOOK)
    plan = plan_pick(context, alone, PickQuery(BIN, CASE), home)
    reasons = verify(replace(plan, scene_hash=scene_hash(under)), under).reasons
    assert BOOK in {r.in_the_way for r in reasons if r.what == "takes away what others need"}


def test_the_planner_would_not_sweep_through_it_even_if_it_could_stay(
    context: PlanningContext, under: Scene, cell: Cell
) -> None:
    """Nothing but the depth rule: no way out among those along which the case may touch the book."""
    problem = PickProblem(context, under, cell.pod.bins[BIN], under.find(CASE), cell.places["tote"])
    assert BOOK in problem.contacts.near_off_floor
    flying = extraction_of(problem).leaving
    up = np.array([0.0, 0.0, 0.02, 0.0, 0.0, 0.0])
    assert flying.is_valid(np.zeros(6))
    assert flying.first_blocked_edge(np.stack([np.zeros(6), up])) == 0


def test_the_floor_under_a_pressed_cup_gives_no_more_than_the_bellows(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    thin = lying_on(cell, BIN, BOOK, None, PoseNoise())
    plan = plan_pick(context, thin, PickQuery(BIN, BOOK), home)
    assert verify(plan, thin).certificate is not None
    for stroke, is_too_deep in ((0.008, False), (0.001, True)):  # the floor 3 mm inside of the pressed cup
        tool = replace(cell.robot.tool, grip=replace(cell.robot.tool.cup, stroke=stroke))
        stiff = replace(cell, robot=replace(cell.robot, tool=tool))
        raised = replace(thin, cell=stiff, T_world_pod=pose((0.0, 0.0, 0.006)))
        reasons = verify(replace(plan, scene_hash=scene_hash(raised)), raised).reasons
        deep = [r.detail for r in reasons if r.what == "planned contact too deep"]
        assert any(detail.startswith("cup and row_JKL_floor") for detail in deep) is is_too_deep


def test_poses_that_contradict_each_other_are_not_planned_with(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    scene = lying_on(cell, BIN, CASE, None, PoseNoise(0.001, 0.0))
    (case,) = scene.items
    sunk = scene.moved(replace(case, T_world_item=pose((0.0, 0.0, -0.01)) @ case.T_world_item))
    with pytest.raises(NoPlanError, match="poses contradict each other"):
        plan_pick(context, sunk, PickQuery(BIN, CASE), home)


def test_beside_a_neighbour_it_is_lifted_without_being_pushed_into_it(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    """Two neighbours that overlap the target as far as poses may be off: it comes out, certified."""
    noise = PoseNoise(0.002, float(np.radians(1.0)))
    scene = lying_on(cell, BIN, "crayola_24_ct", None, noise)
    target, bar = scene.items[0], cell.item("dove_beauty_bar")
    R = target.T_world_item[:3, :3]
    beside = []
    for side in (-1, 1):
        away = float((target.item.shape.reach(R) + bar.shape.reach(R))[1]) - 0.001
        low = (bar.shape.extents[2] - target.item.shape.extents[2]) / 2
        T = pose((0.0, side * away, low)) @ target.T_world_item
        beside.append(replace(target, id=f"bar{side}", item=bar, T_world_item=T))
    scene = replace(scene, items=(target, *beside))
    plan = plan_pick(context, scene, PickQuery(BIN, target.id), home)
    assert verify(plan, scene).reasons == ()
    lift = next(s for s in plan.segments if s.kind is SegmentKind.LIFT)
    assert {"bar-1", "bar1"} <= set(lift.touching)
