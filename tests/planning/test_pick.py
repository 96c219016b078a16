"""plan_pick on the default cell: what comes out is whole, certified, repeatable; what cannot be says why."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoPlanError, Reason, UnknownNameError
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import motion_hash
from pickcli.motion.segment import SegmentKind
from pickcli.planning import pick
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.planning.start_state import Start
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import Scene
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.load_check import held_wrenches
from pickcli.verification.verify import verify

SceneWith = Callable[..., Scene]

ORDER = [
    SegmentKind.TRANSIT, SegmentKind.PREAPPROACH, SegmentKind.APPROACH, SegmentKind.CONTACT, SegmentKind.LIFT,
    SegmentKind.RETREAT, SegmentKind.TRANSFER, SegmentKind.PLACE, SegmentKind.DEPART,
]  # fmt: skip


@pytest.mark.parametrize("bin_name", ["bin_A", "bin_E", "bin_L"])
def test_a_free_item_is_picked_and_certified(
    context: PlanningContext, scene_with: SceneWith, home: Start, bin_name: str
) -> None:
    scene = scene_with(("crayola_24_ct", bin_name, 0.25, 0.0))
    plan = plan_pick(context, scene, PickQuery(bin_name, "crayola_24_ct"), home, seed=3)
    kinds = [s.kind for s in plan.segments]
    assert list(dict.fromkeys(kinds)) == ORDER
    verdict = verify(plan, scene)
    assert verdict.reasons == ()
    assert verdict.certificate is not None and verdict.certificate.min_clearance > 0.0


def test_what_is_rejected_gives_way_to_the_next_grasp_and_its_reason_is_kept(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene, query = scene_with(("crayola_24_ct", "bin_A", 0.25, 0.0)), PickQuery("bin_A", "crayola_24_ct")
    proposed: list[Plan] = []

    def certify(plan: Plan, n_accepted: int) -> Plan | Failures:
        proposed.append(plan)
        return plan if len(proposed) == n_accepted else Failures.of(Reason("too close", f"{len(proposed)}"))

    plan = plan_pick(context, scene, query, home, 3, certify=lambda plan: certify(plan, 2))
    assert plan is proposed[1] and proposed[0].grasp != proposed[1].grasp
    assert motion_hash(proposed[0]) == motion_hash(plan_pick(context, scene, query, home, 3))
    proposed.clear()
    with pytest.raises(NoPlanError) as refused:
        plan_pick(context, scene, query, home, 3, certify=lambda plan: certify(plan, 0))
    told = [reason.where for reason in refused.value.reasons if reason.what == "too close"]
    assert told == [str(k + 1) for k in range(len(proposed))] and 2 <= len(proposed) <= pick.MOST_REJECTED


def test_no_other_grasp_is_tried_for_an_item_that_others_need(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene, query = scene_with(("crayola_24_ct", "bin_A", 0.25, 0.0)), PickQuery("bin_A", "crayola_24_ct")
    proposed: list[Plan] = []

    def certify(plan: Plan) -> Plan | Failures:
        proposed.append(plan)
        return Failures.of(Reason("takes away what others need", "crayola_24_ct", "it would fall", "book"))

    with pytest.raises(NoPlanError, match="takes away what others need"):
        plan_pick(context, scene, query, home, 3, certify=certify)
    assert len(proposed) == 1


def test_what_the_searches_found_is_handed_to_the_recorder(
    context: PlanningContext, scene_with: SceneWith, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also of a pick that fails after a search that did not."""
    scene, query = scene_with(("crayola_24_ct", "bin_A", 0.25, 0.0)), PickQuery("bin_A", "crayola_24_ct")
    named, recorder = context.cell.configurations["drop_12_down"], ExperienceRecorder()
    start = Start(named.q, named.tool_state)
    plan = plan_pick(context, scene, query, start, 3, recorder)
    assert motion_hash(plan) == motion_hash(plan_pick(context, scene, query, start, 3))
    transit, transfer = recorder.recorded
    np.testing.assert_array_equal(transit.q_start, start.q)
    assert (transit.payload, transfer.payload) == (PayloadClass.EMPTY, PayloadClass.CUBE)
    assert transit.polylines and transfer.polylines
    monkeypatch.setattr(pick, "plan_transfer", lambda *args: Failures())
    failed = ExperienceRecorder()
    with pytest.raises(NoPlanError):
        plan_pick(context, scene, query, start, 3, failed)
    np.testing.assert_array_equal(failed.recorded[0].q_goal, transit.q_goal)


def test_same_query_same_motion_and_with_another_seed_another(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(("dove_beauty_bar", "bin_H", 0.2, 0.03))
    first = plan_pick(context, scene, PickQuery("bin_H", "dove_beauty_bar"), home, seed=1)
    again = plan_pick(context, scene, PickQuery("bin_H", "dove_beauty_bar"), home, seed=1)
    assert motion_hash(first) == motion_hash(again)
    np.testing.assert_array_equal(first.trajectory.positions, again.trajectory.positions)
    other = plan_pick(context, scene, PickQuery("bin_H", "dove_beauty_bar"), home, seed=2)
    assert motion_hash(other) != motion_hash(first)
    assert verify(other, scene).reasons == ()


def test_an_excluded_grasp_is_not_used_again(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(("kleenex_tissue_box", "bin_B", 0.2, 0.0))
    first = plan_pick(context, scene, PickQuery("bin_B", "kleenex_tissue_box"), home)
    assert first.grasp is not None
    second = plan_pick(context, scene, PickQuery("bin_B", "kleenex_tissue_box", exclude=(first.grasp,)), home)
    assert second.grasp is not None
    apart = np.linalg.norm(first.grasp.T_item_tip[:3, 3] - second.grasp.T_item_tip[:3, 3])
    is_other = (first.grasp.face, first.grasp.kind) != (second.grasp.face, second.grasp.kind)
    assert apart >= 0.012 or is_other


def test_heavy_items_go_slower_than_the_cup_allows(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(("dasani_water_bottle", "bin_K", 0.2, 0.0))
    plan = plan_pick(context, scene, PickQuery("bin_K", "dasani_water_bottle"), home)
    tool = context.cell.robot.tool
    assert plan.grasp is not None
    assert plan.speed_scale <= 0.5
    assert plan.grasp.moment <= 0.8 * tool.cup.limits.max_moment + 1e-9
    assert verify(plan, scene).reasons == ()


def test_a_carry_takes_what_the_cup_bears_where_it_must_and_no_more_anywhere(
    cell: Cell, context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    """The same carry with a fraction of the limits, measured by the verifier's own load."""
    share, (box,) = 0.23, (scene := scene_with(("kleenex_tissue_box", "bin_B", 0.2, 0.0))).items
    airtight = dict.fromkeys(box.item.seals, 1.0)
    scene = scene.moved(replace(box, item=replace(box.item, seals=airtight)))
    careful = PlanningContext(cell, settings=replace(context.settings, load_ratio=share))
    fast = plan_pick(context, scene, PickQuery("bin_B", "kleenex_tissue_box"), home)
    plan = plan_pick(careful, scene, PickQuery("bin_B", "kleenex_tissue_box"), home)
    assert fast.grasp is not None and plan.grasp is not None
    assert plan.grasp.T_item_tip == pytest.approx(fast.grasp.T_item_tip)
    assert fast.grasp.load_ratio > 1.2 * share
    assert 0.95 * share <= plan.grasp.load_ratio <= share * (1.0 + 1e-3)
    assert verify(plan, scene).reasons == ()
    hanging = pose_in_tool(plan, scene)
    assert hanging is not None
    _, wrenches = held_wrenches(plan, scene, hanging)
    vacuum = scene.find("kleenex_tissue_box").item.seals[plan.grasp.face]
    assert cell.robot.tool.cup.limits.ratio(wrenches, vacuum).max() <= 1.01 * share
    # Slowing down all of it by the same factor of acceleration would take half as long again.
    assert plan.trajectory.duration < 1.2 * fast.trajectory.duration


def test_a_walled_in_item_names_its_neighbour(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(
        ("crayola_24_ct", "bin_E", 0.33, 0.0), ("kleenex_paper_towels", "bin_E", 0.12, 0.0)
    )  # fmt: skip
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene, PickQuery("bin_E", "crayola_24_ct"), home)
    assert "kleenex_paper_towels" in str(caught.value)
    ignoring = Neighbours.IGNORE
    assert (
        plan_pick(context, scene, PickQuery("bin_E", "crayola_24_ct", neighbours=ignoring), home).grasp
        is not None
    )


def test_what_lies_on_the_target_blocks_and_the_top_is_named_first(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    scene = scene_with(
        ("peva_shower_curtain_liner", "bin_K", 0.25, 0.0), ("i_am_a_bunny_book", "bin_K", 0.25, 0.0),
        ("dove_beauty_bar", "bin_K", 0.25, 0.0),
    )  # fmt: skip
    liner, book, bar = scene.items
    top = liner.T_world_item[2, 3] + liner.item.shape.extents[2] / 2
    for placed in (book, bar):
        height = float(placed.item.shape.extents[2])
        T = pose([*liner.T_world_item[:2, 3], top + height / 2], R=placed.T_world_item[:3, :3])
        scene, top = scene.moved(replace(placed, T_world_item=T)), top + height
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene, PickQuery("bin_K", liner.id), home)
    assert caught.value.in_the_way == (bar.id, book.id)
    with pytest.raises(NoPlanError) as caught:  # the bar hangs in the air: it would fall onto the liner
        plan_pick(context, scene.without(book.id), PickQuery("bin_K", liner.id), home)
    assert caught.value.in_the_way == (bar.id,)
    alone = scene.without(book.id).without(bar.id)
    assert (
        verify(plan_pick(context, alone, PickQuery("bin_K", liner.id), home), alone).certificate is not None
    )


def test_what_cannot_be_sucked_says_why(context: PlanningContext, scene_with: SceneWith, home: Start) -> None:
    scene = scene_with(("fitness_gear_3lb_dumbbell", "bin_B", 0.2, 0.0))
    with pytest.raises(NoPlanError, match="pinching"):
        plan_pick(context, scene, PickQuery("bin_B", "fitness_gear_3lb_dumbbell"), home)


def test_unknown_names_are_named(context: PlanningContext, scene_with: SceneWith, home: Start) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0))
    with pytest.raises(UnknownNameError, match="bin_Z"):
        plan_pick(context, scene, PickQuery("bin_Z", "crayola_24_ct"), home)
    with pytest.raises(UnknownNameError, match="crayola_24_ct"):
        plan_pick(context, scene, PickQuery("bin_B", "crayola_24"), home)


def test_a_move_arrives_and_a_blocked_goal_is_explained(
    context: PlanningContext, scene_with: SceneWith, home: Start, cell: Cell
) -> None:
    scene = scene_with()
    goal = cell.configurations["bin_K"].q
    plan = plan_move(context, scene, home, MoveGoal(goal))
    np.testing.assert_allclose(plan.trajectory.positions[-1], goal)
    assert verify(plan, scene).reasons == ()
    with pytest.raises(NoPlanError, match="goal"):
        plan_move(context, scene, home, MoveGoal(cell.configurations["tote_10h"].q))


def test_a_pick_starts_where_a_move_may_end(
    context: PlanningContext, scene_with: SceneWith, home: Start
) -> None:
    """Nearer to something than coarse motions pass, but at the cell's clearance."""
    scene = scene_with(("crayola_24_ct", "bin_B", 0.25, 0.0))
    plain = context.checker_for(scene, Mode(home.tool_state))
    coarse = context.checker_for(scene, Mode(home.tool_state, reserve=COARSE_RESERVE))
    rng = np.random.default_rng(0)
    Q = (context.arm.random_seeds(rng, 400) for _ in range(50))
    near = (q for some in Q for q in some if plain.is_valid(q) and not coarse.is_valid(q))
    planned = 0
    for q in islice(near, 6):
        try:
            plan = plan_pick(context, scene, PickQuery("bin_B", "crayola_24_ct"), Start(q, home.tool_state))
        except NoPlanError as error:
            assert not any(reason.where == "start" for reason in error.reasons)
            continue
        planned += 1
        assert verify(plan, scene).reasons == ()
    assert planned > 0
