"""Toppling: the plan's segments and its certificate, and that boxes fall in simulation onto another face."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ToolState
from pickcli.errors import NoPlanError, UnknownNameError
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import plan_to_dict, read_plan, write_plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery, plan_topple
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.world import World
from pickcli.statics.supports import supports_of
from pickcli.verification.straightness_check import tip_points
from pickcli.verification.verify import TOPPLE_CHECKS, certify
from support.standing import BOX, CRATE, CRATES, NOISE, SHELF, box, crate, lying, standing

CONTEXT = PlanningContext(CRATES)
HOME = Start(CRATES.configurations["home"].q, CRATES.configurations["home"].tool_state)
ERASER = "expo_dry_erase_board_eraser"  # 20 g, 35 mm wide and 54 mm high on its edge: nearly too wide to turn
FACES = CRATES.item(BOX).shape.face_names
CARDS = "mead_index_cards"
HIGH = float(CRATES.item(CARDS).shape.extents[2]) + 0.0002  # m, lower side of what lies on it
PLUGS = "mommys_helper_outlet_plugs"  # 80 g, 55 mm wide and 60 mm high on its edge: too wide


def topple(scene: Scene, item: str = BOX) -> Plan:
    return certify(plan_topple(CONTEXT, scene, TopplingQuery(CRATE, item), HOME), scene)


def played(scene: Scene, plan: Plan) -> tuple[World, Scene]:
    """The world after a plan, and its scene with the noise of the first."""
    world = World(scene, HOME.q, HOME.tool_state)
    run = execute(plan, world)
    assert not run.stopped and not run.limit_violations
    world.wait(0.5)
    assert not world.contacts.collisions
    return world, replace(world.now(), noise=scene.noise)


def height_of_face(placed: PlacedItem, face: str) -> float:
    """Vertical part of the outward normal of a face."""
    up: Array = placed.T_world_item[2, :3]
    return float(up["xyz".index(face[1])] * (1.0 if face[0] == "+" else -1.0))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return crate(standing(BOX, 0.02, 0.0, 0.4), lying("mead_index_cards", -0.12, 0.05))


@pytest.fixture(scope="module")
def plan(scene: Scene) -> Plan:
    return topple(scene)


def test_it_comes_in_pushes_twice_and_leaves_upwards(plan: Plan) -> None:
    kind = SegmentKind
    kinds = [segment.kind for segment in plan.segments]
    assert kinds == [kind.TRANSIT, kind.PREAPPROACH, kind.PUSH, kind.PUSH, kind.DEPART]
    assert [segment.pushing for segment in plan.segments] == [(), (), (BOX,), (BOX,), (BOX,)]
    assert all(segment.held is None and not segment.touching for segment in plan.segments)
    assert plan.grasp is None and not plan.events and plan.query == f"topple {BOX} in {CRATE}"


def test_the_certificate_names_the_check_and_the_file_is_read_again(plan: Plan, tmp_path: Path) -> None:
    assert plan.certificate is not None and set(TOPPLE_CHECKS) <= set(plan.certificate.checks)
    write_plan(plan, tmp_path / "plan.json")
    assert plan_to_dict(read_plan(tmp_path / "plan.json")) == plan_to_dict(plan)


def test_afterwards_there_is_a_plan_to_pick_it(scene: Scene, plan: Plan) -> None:
    query = PickQuery(CRATE, BOX, into=SHELF)
    with pytest.raises(NoPlanError, match="no face within reach"):
        plan_pick(CONTEXT, scene, query, HOME)
    world, now = played(scene, plan)
    assert abs(height_of_face(now.find(BOX), "+z")) > 0.95
    assert plan_pick(CONTEXT, now, query, Start(world.q, world.tool_state)).grasp is not None
    world.close()


@pytest.mark.parametrize("seed", range(5))
def test_a_box_of_random_size_falls_onto_another_side(seed: int) -> None:
    rng = np.random.default_rng(seed)
    width = float(rng.uniform(0.015, 0.03))
    item = box(float(rng.uniform(0.06, 0.12)), float(rng.uniform(0.06, 0.085)), width, rng.uniform(0.02, 0.3))
    x, y = rng.uniform((-0.06, -0.03), (0.06, 0.03))
    scene = crate(standing(BOX, float(x), float(y), float(rng.uniform(0.0, 2 * np.pi)), item=item))
    world, now = played(scene, topple(scene))
    assert abs(height_of_face(now.find(BOX), "+z")) > np.cos(np.radians(60.0))
    assert now.find(BOX).location == CRATE
    world.close()


def test_a_light_wide_item_is_lifted_by_its_near_side() -> None:
    scene = crate(standing(ERASER, -0.05, 0.0, 0.3))
    world, now = played(scene, topple(scene, ERASER))
    assert height_of_face(now.find(ERASER), "+z") > 0.95  # the face that seals better, of the two
    world.close()


def test_the_same_query_gives_the_same_plan(scene: Scene, plan: Plan) -> None:
    again = topple(scene)
    assert plan_to_dict(replace(again, statistics={})) == plan_to_dict(replace(plan, statistics={}))


def test_what_cannot_be_toppled_says_why() -> None:
    flat = crate(lying("mead_index_cards", 0.0, 0.0))
    with pytest.raises(NoPlanError, match="no upright face of it seals"):
        topple(flat, "mead_index_cards")
    shelf = crate(standing(BOX, 0.1, 0.0, place=SHELF))
    with pytest.raises(NoPlanError, match="only a cup across its lance turns items over in a bin"):
        plan_topple(CONTEXT, shelf, TopplingQuery(SHELF, BOX), HOME)
    with pytest.raises(UnknownNameError):
        plan_topple(CONTEXT, shelf, TopplingQuery("nowhere", BOX), HOME)


def test_it_comes_in_presses_turns_with_the_item_and_leaves_upwards() -> None:
    """Too near to a wall for a cup beside it, it is turned away from there by friction on its upper side."""
    scene = crate(standing(ERASER, 0.165, 0.0))
    plan = topple(scene, ERASER)
    kind = SegmentKind
    first, *turning = [segment for segment in plan.segments if segment.kind is kind.PUSH]
    assert len(turning) == 5 and plan.segments[-1].kind is kind.DEPART
    tips = [
        tip_points(plan, CRATES.robot, s.tool_state, np.array([s.t_start, s.t_end]))
        for s in (first, *turning)
    ]
    press = tips[0][1] - tips[0][0]
    top = scene.find(ERASER).T_world_item[2, 3] + 0.027
    assert np.hypot(*press[:2]) < 1e-3 and tips[0][0][2] > top > tips[0][1][2]
    # Where the press ends its corner is rounded, by a fraction of a millimetre.
    assert top - tips[0][1][2] == pytest.approx(CRATES.robot.tool.cup.stroke / 2, abs=6e-4)
    assert all(b[0] < a[0] - 0.005 for a, b in tips[1:])  # away from the wall
    world, now = played(scene, plan)
    assert abs(height_of_face(now.find(ERASER), "+z")) > 0.95
    world.close()


def test_what_a_push_from_beside_would_slide_is_turned_from_above() -> None:
    """60 mm high and 55 wide: after the first push it leans on its edge, or lies on a face that seals."""
    scene = crate(standing(PLUGS, -0.05, 0.0, 0.3))
    plan = topple(scene, PLUGS)
    world, now = played(scene, plan)
    assert abs(height_of_face(now.find(PLUGS), "+z")) > 0.95
    world.close()


@pytest.mark.parametrize("seed", range(5))
def test_a_box_of_random_size_beside_a_wall_falls_away_from_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    width = float(rng.uniform(0.03, 0.05))
    item = box(
        float(rng.uniform(0.06, 0.12)), float(rng.uniform(0.055, 0.08)), width, rng.uniform(0.02, 0.12)
    )
    gap = float(rng.uniform(0.001, 0.03))
    scene = crate(standing(BOX, 0.197 - width / 2 - gap, float(rng.uniform(-0.05, 0.05)), item=item))
    world, now = played(scene, topple(scene))
    assert abs(height_of_face(now.find(BOX), "+z")) > np.cos(np.radians(60.0))
    assert now.find(BOX).location == CRATE
    world.close()


def test_no_room_for_the_tool_between_item_and_wall_is_said() -> None:
    """A thin box at the wall: there is less room than the cup is wide beside it and above it."""
    thin = crate(standing(BOX, 0.1965 - 0.005, 0.0, item=box(0.095, 0.07, 0.01)))
    with pytest.raises(NoPlanError) as error:
        topple(thin)
    assert any("pre-approach" in r.where and "crate_right_wall" in r.detail for r in error.value.reasons)


def test_from_another_state_of_the_tool_the_cup_turns_on_the_way() -> None:
    cell = load_cell("apc2016_delft")
    T = cell.T_world_place(cell.places["tote"]) @ np.linalg.inv(CRATES.T_world_place(CRATES.places[CRATE]))
    placed = standing(BOX, 0.0, 0.0, 0.4)
    placed = replace(placed, item=cell.item(BOX), location="tote", T_world_item=T @ placed.T_world_item)
    scene = Scene(cell, cell.T_world_pod, (placed,), NOISE)
    query, start = TopplingQuery("tote", BOX), Start(cell.home.q, ToolState("down"))
    plan = certify(plan_topple(PlanningContext(cell), scene, query, start), scene)
    assert [event.action for event in plan.events] == ["straight"]


@pytest.mark.parametrize("seed", range(4))
def test_what_lies_on_another_item_is_pushed_off_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    under = lying("mead_index_cards", 0.0, 0.0)
    item = replace(box(0.06, 0.05, 0.05, rng.uniform(0.02, 0.3)), seals=dict.fromkeys(FACES, 0.0))
    x, y, yaw = rng.uniform((-0.02, -0.02, -3.0), (0.02, 0.02, 3.0)).tolist()
    above = standing(BOX, x, y, yaw, item=item)
    up = pose((0.0, 0.0, float(under.item.shape.extents[2])))
    above = replace(above, T_world_item=up @ above.T_world_item)
    scene = crate(above, under)
    plan = topple(scene)
    kind = SegmentKind
    kinds = [segment.kind for segment in plan.segments]
    assert kinds == [kind.TRANSIT, kind.PREAPPROACH, kind.PUSH, kind.DEPART]
    world, now = played(scene, plan)
    fallen = now.find(BOX)
    off = (inverse(under.T_world_item) @ fallen.T_world_item)[:2, 3]
    assert fallen.location == CRATE and (np.abs(off) > under.item.shape.extents[:2] / 2).any()
    assert now.find(under.id).T_world_item == pytest.approx(under.T_world_item, abs=0.003)
    world.close()


def test_what_no_push_turns_over_is_pushed_off_what_it_lies_on() -> None:
    on_it = lying(BOX, 0.0, 0.0, up=HIGH, item=box(0.09, 0.07, 0.045))
    scene = crate(on_it, lying(CARDS, 0.0, 0.0))
    assert supports_of(scene).graph.lying_on(CARDS) == (BOX,)
    plan = topple(scene)
    assert plan.query == f"push {BOX} off others in {CRATE}"
    world, now = played(scene, plan)
    cards = now.find(CARDS)
    beside = np.abs((inverse(cards.T_world_item) @ now.find(BOX).T_world_item)[:2, 3])
    assert (beside > cards.item.shape.extents[:2] / 2).any()
    assert now.find(BOX).location == now.find(CARDS).location == CRATE
    world.close()


def test_what_cannot_be_pushed_off_stops_the_cup() -> None:
    """The side of the cup is rigid: it knocks at an item that is a hundred times too heavy, and stops."""
    on_it = lying(BOX, 0.0, 0.0, up=HIGH, item=box(0.09, 0.07, 0.045))
    scene = crate(on_it, lying(CARDS, 0.0, 0.0))
    plan = topple(scene)
    heavy = scene.moved(replace(on_it, item=replace(on_it.item, mass=4.0)))
    world = World(heavy, HOME.q, HOME.tool_state)
    run = execute(plan, world)
    assert run.stop_cause is StopCause.CONTACT and "cup" in run.stopped
    assert max(c.t_end - c.t_start for c in world.contacts.collisions) < 0.03
    moved = (world.placed(BOX).T_world_item - on_it.T_world_item)[:3, 3]
    assert float(np.linalg.norm(moved)) < 0.005
    world.close()
