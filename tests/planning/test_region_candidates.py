"""Candidates of a region query are in envelopes and keep the rules of grasps; their plans are certified."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import LEAST_SHARE
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array, inverse, pose, rotation_angle
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.grasp_target import CandidateSet
from pickcli.grasping.holding import HoldLimits
from pickcli.grasping.lip_coverage import kept_vacuum
from pickcli.motion.plan import Grasp, Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.region_query import RegionSearch
from pickcli.planning.stages import grasp_selection
from pickcli.planning.stages import region_candidates as region_stage
from pickcli.planning.stages.extraction import CorridorSet, extraction_of
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.region_candidates import region_candidates
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.verification.verify import verify
from planning.conftest import SceneWith
from support.cans import can

SEARCH = RegionSearch(400, 4)
ON_BOUND = 2e-5  # m or difference of cosines: what inverse kinematics leaves
NAMES = ("crayola_24_ct", "rawlings_baseball", "folgers_classic_roast_coffee", "staples_index_cards")


def candidates_of(problem: PickProblem, explains: bool = True) -> CandidateSet:
    ways_out = extraction_of(problem).transforms(CorridorSet.MANY)
    assert not isinstance(ways_out, Failures)
    return region_candidates(problem, SEARCH, ways_out, np.random.default_rng(0), explains=explains)


def problem_of(context: PlanningContext, scene: Scene, into: str = TOTE) -> PickProblem:
    target = scene.items[0]
    return PickProblem.of(context, scene, PickQuery(target.location, target.id, into), seed=0)


def envelope_of(problem: PickProblem, grasp: Grasp) -> Envelope:
    """The envelope that a grasp names."""
    state = Mode(grasp.tool_state)
    axes = problem.T_world_entry[:3, :3]
    depth = problem.context.checkers.tool(problem.scene, state.tool_state, axes, state.contacts).depth
    envelopes = problem.context.method.envelopes(problem.target.item, depth)
    return next(each for each in envelopes if each.name == grasp.envelope)


def can_on_mat(cell: Cell) -> Scene:
    """A can that two fingers can hold, standing on a table."""
    placed = can(cell, "can", 0.46, 0.1)
    placed = replace(placed, item=replace(placed.item, mass=0.1))
    return Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, 0.01))


def has_the_pose(grasp: Grasp, others: tuple[Array, ...]) -> bool:
    off = [inverse(T) @ grasp.T_item_tip for T in others]
    return any(np.linalg.norm(T[:3, 3]) < 1e-3 and rotation_angle(T[:3, :3]) < 1e-2 for T in off)


@pytest.mark.parametrize("name", NAMES)
def test_cups_are_in_an_envelope_seal_and_hold(
    context: PlanningContext, scene_with: SceneWith, name: str
) -> None:
    problem = problem_of(context, scene_with((name, "bin_B", 0.2, 0.0)))
    item, cup = problem.target.item, context.cell.robot.tool.cup
    noise = problem.scene.noise_of(problem.target)
    grasps = candidates_of(problem).grasps
    assert len(grasps) > 5
    for grasp in grasps:
        envelope, tip = envelope_of(problem, grasp), grasp.T_item_tip[:3, 3]
        assert envelope.contains(grasp.T_item_tip[None], ON_BOUND).all()
        assert grasp.face == envelope.face and np.isfinite(grasp.score)
        # On the inset face to the last digit, as the verifier asks.
        np.testing.assert_allclose(envelope.clipped(grasp.T_item_tip[None])[0], grasp.T_item_tip, atol=1e-9)
        assert kept_vacuum(item, grasp.face, tip, cup, noise) >= LEAST_SHARE
        assert grasp.load_ratio <= problem.settings.load_ratio


def test_pads_are_flat_on_the_item_and_in_an_envelope() -> None:
    context = PlanningContext(load_cell("panda_table"))
    problem = problem_of(context, can_on_mat(context.cell), "tray")
    grasps = candidates_of(problem).grasps
    assert {grasp.face for grasp in grasps} == {"mantle"} and len(grasps) > 5
    for grasp in grasps:
        assert envelope_of(problem, grasp).contains(grasp.T_item_tip[None], ON_BOUND).all()
        closing, middle = grasp.T_item_tip[:3, 1], grasp.T_item_tip[:3, 3]
        assert abs(closing[2]) < 1e-9 and np.abs(middle[:2]).max() < 1e-9  # across the axis, on the axis
        bears = context.method.bears(problem.target.item, grasp.face, grasp.T_item_tip)
        assert isinstance(bears, HoldLimits) and grasp.load_ratio <= problem.settings.load_ratio


@pytest.mark.parametrize("name", NAMES[:2])
def test_a_plan_by_region_query_is_certified_and_names_its_envelope(
    context: PlanningContext, scene_with: SceneWith, home: Start, name: str
) -> None:
    scene = scene_with((name, "bin_B", 0.2, 0.0))
    by_region = context.with_approach(GraspApproach.REGION)
    plan, again = (plan_pick(by_region, scene, PickQuery("bin_B", name), home, seed=4) for _ in range(2))
    assert plan.grasp is not None and plan.grasp.envelope
    assert verify(plan, scene).certificate is not None
    assert np.array_equal(
        plan.trajectory.positions, again.trajectory.positions
    )  # the same seed gives the same plan


def planned_on_table(approach: GraspApproach) -> tuple[Plan, Scene]:
    context = PlanningContext(load_cell("panda_table")).with_approach(approach)
    scene = can_on_mat(context.cell)
    named = context.cell.configurations["home"]
    target = scene.items[0]
    query = PickQuery(target.location, target.id, "tray")
    return plan_pick(context, scene, query, Start(named.q, named.tool_state), seed=2), scene


def test_a_plan_of_two_fingers_by_region_query_is_certified() -> None:
    plan, scene = planned_on_table(GraspApproach.REGION)
    assert plan.grasp is not None and plan.grasp.envelope
    assert verify(plan, scene).certificate is not None


def test_an_item_is_stowed_out_of_the_tote_by_region_query(
    cell: Cell, context: PlanningContext, home: Start
) -> None:
    item = cell.item("crayola_24_ct")
    T = cell.T_world_place(cell.places[TOTE]) @ pose((0.1, 0.0, float(item.shape.extents[2]) / 2 + 0.0005))
    placed = PlacedItem(item.name, item, TOTE, T)
    scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))
    by_region = context.with_approach(GraspApproach.REGION)
    plan = plan_pick(by_region, scene, PickQuery(TOTE, item.name, into="bin_H"), home)
    assert plan.grasp is not None and plan.grasp.envelope
    assert verify(plan, scene).certificate is not None


def test_the_region_is_asked_only_where_no_fixed_candidate_succeeds(
    context: PlanningContext, scene_with: SceneWith, home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0))
    query, then = PickQuery("bin_B", "crayola_24_ct"), context.with_approach(GraspApproach.LINES_THEN_REGION)
    by_lines, first = (plan_pick(each, scene, query, home, seed=1) for each in (context, then))
    assert np.array_equal(by_lines.trajectory.positions, first.trajectory.positions)

    # Nothing that the usual and the wide search try succeeds.
    tried, n_calls = grasp_selection._tried, count()
    monkeypatch.setattr(
        grasp_selection,
        "_tried",
        lambda *args: ((), Failures()) if next(n_calls) < 2 else tried(*args),
    )
    plan = plan_pick(then, scene, query, home, seed=1)
    assert plan.grasp is not None and plan.grasp.envelope
    assert verify(plan, scene).certificate is not None


def test_grasps_that_failed_are_not_proposed_again(context: PlanningContext, scene_with: SceneWith) -> None:
    by_region = context.with_approach(GraspApproach.REGION)
    problem = problem_of(by_region, scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0)))
    found = [motion.grasp for motion in feasible_grasps(problem, ())[0]]
    others = [motion.grasp for motion in feasible_grasps(problem, found)[0]]
    assert found and others
    assert not any(has_the_pose(grasp, tuple(each.T_item_tip for each in found)) for grasp in others)


@pytest.fixture
def behind_another(cell: Cell) -> Scene:
    """A box with a higher one before it, past which it has no way out."""
    there = cell.pod.bins["bin_E"]
    floor = float(there.room.rest(np.array(0.05), np.array(0.0))[0]) + 0.0005
    at = partial(_standing, cell, cell.T_world_place(there), floor)
    items = (at("crayola_24_ct", 0.3), at("kleenex_tissue_box", 0.1))
    return Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, 0.01))


def why_not(context: PlanningContext, scene: Scene, approach: GraspApproach) -> NoPlanError:
    named = context.cell.configurations["home"]
    start, query = Start(named.q, named.tool_state), PickQuery("bin_E", "crayola_24_ct")
    with pytest.raises(NoPlanError) as error:
        plan_pick(context.with_approach(approach), scene, query, start, seed=3)
    return error.value


def test_what_keeps_the_item_in_its_place_is_named(context: PlanningContext, behind_another: Scene) -> None:
    assert why_not(context, behind_another, GraspApproach.REGION).in_the_way == ("kleenex_tissue_box",)


def test_an_envelope_without_room_yields_poses_to_tell_what_is_in_the_way_or_nothing(
    context: PlanningContext, scene_with: SceneWith, monkeypatch: pytest.MonkeyPatch
) -> None:
    problem = problem_of(context, scene_with(("crayola_24_ct", "bin_B", 0.2, 0.0)))
    nowhere: NDArray[np.bool_] = np.zeros(SEARCH.n_poses, dtype=bool)
    monkeypatch.setattr(region_stage, "room_for_tool", lambda *args: lambda T: nowhere)
    found = candidates_of(problem)
    assert {grasp.envelope for grasp in found.grasps} == {"+x", "-x", "+y", "-y", "+z", "-z"}
    assert candidates_of(problem, explains=False).batches == ()


def test_a_region_query_that_fails_too_adds_no_reasons(
    context: PlanningContext, scene_with: SceneWith, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A trial decides by the most frequent reasons; without the third search they are those of lines."""
    monkeypatch.setattr(grasp_selection, "MOST_TRIED", 0)
    scene = scene_with(("crayola_24_ct", "bin_E", 0.2, 0.0))
    told = {each: list(why_not(context, scene, each).reasons) for each in GraspApproach}
    assert told[GraspApproach.LINES_THEN_REGION] == told[GraspApproach.LINES] != []


def test_an_item_without_envelopes_has_a_reason_for_having_no_plan(
    cell: Cell, context: PlanningContext, home: Start, scene_with: SceneWith
) -> None:
    held_by_none = next(
        name for (name, year), item in cell.items.items() if year == 2016 and not item.suction
    )
    scene = scene_with((held_by_none, "bin_B", 0.2, 0.0))
    with pytest.raises(NoPlanError, match="nothing to grasp"):
        query = PickQuery("bin_B", held_by_none)
        plan_pick(context.with_approach(GraspApproach.REGION), scene, query, home, seed=3)


def _standing(cell: Cell, T_bin: Array, floor: float, name: str, x: float) -> PlacedItem:
    item = cell.item(name)
    return PlacedItem(name, item, "bin_E", T_bin @ pose((x, 0.0, floor + item.shape.extents[2] / 2)))
