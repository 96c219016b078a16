"""A pick by the bottom of a hollow: found, verified, refused where its walls are met, and carried out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError
from pickcli.files.packed_array import unpacked
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.page.plan_page import plan_page
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.verify import verify

BRUSH, BIN = "dr_browns_bottle_brush", "bin_H"


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    """A bottle brush that lies flat, its handle towards the mouth, seen with small errors."""
    found = make_scene({BIN: [BRUSH]}, cell, seed=0)
    assert found.items[0].T_world_item[0, 0] > 0.99
    return replace(found, noise=PoseNoise(0.001, float(np.radians(0.5))))


@pytest.fixture(scope="module")
def plan(context: PlanningContext, scene: Scene, home: Start) -> Plan:
    return plan_pick(context, scene, PickQuery(BIN, BRUSH), home)


def moved(plan: Plan, scene: Scene, by: float) -> tuple[Plan, Scene]:
    """The plan, in a scene with the brush m farther to the left."""
    (brush,) = scene.items
    there = replace(scene, items=(replace(brush, T_world_item=pose([0.0, by, 0.0]) @ brush.T_world_item),))
    return replace(plan, scene_hash=scene_hash(there)), there


def changed(plan: Plan, scene: Scene, **figures: object) -> tuple[Plan, Scene]:
    """The plan, in a scene in which the hollow that it uses is another."""
    assert plan.grasp is not None
    (brush,) = scene.items
    hollows = tuple(
        replace(hollow, **figures) if hollow.bottom == plan.grasp.face else hollow  # type: ignore[arg-type]
        for hollow in brush.item.hollows
    )
    there = replace(scene, items=(replace(brush, item=replace(brush.item, hollows=hollows)),))
    return replace(plan, scene_hash=scene_hash(there)), there


def why_refused(plan: Plan, scene: Scene) -> set[str]:
    """Kinds of faults of a plan that concern where it touches; none if it is accepted."""
    verdict = verify(plan, scene)
    assert (verdict.certificate is None) == bool(verdict.reasons)
    return {reason.what for reason in verdict.reasons}


def test_a_card_beside_the_handle_is_reached_and_the_plan_is_certified(plan: Plan, scene: Scene) -> None:
    assert plan.grasp is not None
    assert plan.grasp.face in ("+z/left", "+z/right")
    assert plan.grasp.T_item_tip[2, 3] == pytest.approx(0.029 - 0.0285, abs=1e-9)
    assert why_refused(plan, scene) == set()


def test_there_is_no_plan_without_the_hollows(context: PlanningContext, scene: Scene, home: Start) -> None:
    (brush,) = scene.items
    seals = {face: brush.item.seals[face] for face in brush.item.shape.face_names}
    filled = replace(brush.item, hollows=(), seals=seals)
    without = replace(scene, items=(replace(brush, item=filled),))
    with pytest.raises(NoPlanError):
        plan_pick(context, without, PickQuery(BIN, BRUSH), home)


def test_a_wall_nearer_than_stated_is_found_by_the_verifier(plan: Plan, scene: Scene) -> None:
    """The handle is so wide that the cup is too near to it, or in it."""
    assert plan.grasp is not None
    (low, high), is_left = (0.0125, 0.0525), plan.grasp.face == "+z/left"
    for wider, faults in ((0.005, {"too close"}), (0.015, {"collision"})):
        side = (low + wider, high) if is_left else (-high, -low - wider)
        assert faults <= why_refused(*changed(plan, scene, sides=((-0.139, 0.0), side)))


def test_a_wall_at_the_end_of_the_hollow_is_found_by_the_verifier(plan: Plan, scene: Scene) -> None:
    """The hollow ends beside the cup, 1 mm from it, or under it."""
    assert plan.grasp is not None
    hollow = next(each for each in scene.items[0].item.hollows if each.bottom == plan.grasp.face)
    least = float(plan.grasp.T_item_tip[0, 3]) - scene.cell.robot.tool.cup.radius
    for beyond, fault in ((-0.001, "too close"), (0.005, "collision")):
        sides = ((least + beyond, 0.0), hollow.sides[1])
        assert fault in why_refused(*changed(plan, scene, sides=sides))


def test_an_item_elsewhere_is_found_by_the_verifier(plan: Plan, scene: Scene) -> None:
    assert plan.grasp is not None
    aside = 0.008 if plan.grasp.face == "+z/right" else -0.008
    assert {"too close", "collision"} & why_refused(*moved(plan, scene, -aside))


def test_a_bottom_that_is_higher_is_found_by_the_verifier(plan: Plan, scene: Scene) -> None:
    assert why_refused(*changed(plan, scene, depth=0.03)) & {"planned contact too deep", "wrong face"}


def test_the_certificate_is_for_the_hollows_of_the_scene(plan: Plan, scene: Scene) -> None:
    _, other = changed(plan, scene, depth=0.027)
    assert scene_hash(other) != scene_hash(scene)


def test_its_page_shows_a_clearance_that_is_kept(plan: Plan, scene: Scene) -> None:
    """In the hollow the walls count there, not the outer shape that the cup is deep in."""
    shown = plan_page(plan, scene).clearance
    assert shown is not None
    assert float(unpacked(shown.values).min()) > 0.0


@pytest.mark.slow
def test_it_is_carried_out_without_a_contact_that_is_not_planned(
    plan: Plan, scene: Scene, home: Start
) -> None:
    world = World(scene, home.q, home.tool_state)
    run = execute(plan, world)
    assert run.collisions == ()
    assert run.trouble == ""
    assert world.placed(BRUSH).location == "tote"
    world.close()


@pytest.mark.slow
def test_a_wall_that_is_met_is_a_contact_that_is_seen(plan: Plan, scene: Scene, home: Start) -> None:
    """The handle is where the cup goes down."""
    assert plan.grasp is not None
    _, real = moved(plan, scene, 0.014 if plan.grasp.face == "+z/left" else -0.014)
    world = World(real, home.q, home.tool_state)
    run = execute(plan, world)
    assert {(each.a, each.b) for each in run.collisions} == {("cup", BRUSH)}
    assert "unexpected contact" in run.trouble
    world.close()
