"""A cup presses no item over the edge of what carries it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import GRAVITY, Array, inverse, pose, rotation_axis_angle
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.verification.tipping_check import MOST_THROWN, Press, beside_support, check_tipping, falls_over
from support.handmade_plans import CRAYOLA, Builder, cell, make_scene, move_plan, pick, tip
from support.tool_states import STRAIGHT

OVER_TOTE = np.asarray(cell().configurations["drop_01"].q)
BOARD, BAR = (0.25, 0.145, 0.02), (0.04, 0.2, 0.03)
PRESS = 0.004  # m by which the cup is pressed on
EDGE = 1.5e-4  # m within which the edge of a support is found, from inside


def lying(name: str, shape: Shape, T: Array, mass: float) -> PlacedItem:
    item = replace(cell().item("scotch_bubble_mailer"), shape=shape, mass=mass)
    return PlacedItem(name, item, TOTE, T)


def across_a_bar(
    mass: float = 0.0195, shape: Shape | None = None, noise: float = 0.0, at: float = 0.0
) -> Scene:
    """A board of 250 mm across a bar of 40 mm, whose upper side is where the cup over the tote points.

    at: m, of the bar from the middle of the board
    """
    top = tip(OVER_TOTE)[:3, 3] - (0.0, 0.0, 0.05)
    board = lying("board", shape or Shape(ShapeKind.BOX, BOARD), pose(top - (0.0, 0.0, 0.01)), mass)
    bar = lying("bar", Shape(ShapeKind.BOX, BAR), pose(top - (-at, 0.0, 0.035)), 1.0)
    return make_scene(board, bar, noise=PoseNoise(noise, 0.0))


def pressing(scene: Scene, aside: float, kind: str = "top-down", depth: float = PRESS) -> Plan:
    """The cup is pressed on the board, at a distance (m) from its middle along x."""
    R = tip(OVER_TOTE)[:3, :3]
    board = scene.find("board").T_world_item
    met = pose(board[:3, 3] + (aside, 0.0, 0.01), R=R)
    builder = Builder(OVER_TOTE)
    builder.line(SegmentKind.APPROACH, met, 1.0)
    builder.line(SegmentKind.CONTACT, met @ pose((0.0, 0.0, depth)), 1.0, touching=("board",))
    grasp = Grasp("board", kind, "+z", STRAIGHT, inverse(board) @ met, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    return replace(move_plan(scene, builder), grasp=grasp)


def told(scene: Scene, aside: float, **how: object) -> str:
    return "; ".join(map(str, check_tipping(pressing(scene, aside, **how), scene)))  # type: ignore[arg-type]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_press_beside_the_support_of_a_light_item_is_refused(side: float) -> None:
    """4 N at 60 mm and 0.17 N in the middle: their resultant is 57.5 mm out, 37.5 mm beside the bar."""
    scene = across_a_bar()
    assert told(scene, 0.0) == told(scene, 0.015 * side) == ""
    beside = float(told(scene, 0.06 * side).split(" lead ")[1].split(" mm beside")[0])
    assert "segment 1 (contact): tips the item: board: 4.0 N" in told(scene, 0.06 * side)
    assert beside == pytest.approx(37.5, abs=0.5 + 1e3 * EDGE)


def test_what_weighs_enough_is_not_tipped_nor_what_is_hardly_pressed() -> None:
    assert told(across_a_bar(mass=1.0), 0.06) == ""
    assert told(across_a_bar(), 0.06, depth=1e-5) == ""
    assert told(across_a_bar(mass=1.0), 0.12)


def test_a_press_that_poses_may_explain_is_not_refused() -> None:
    """The resultant is 38 mm out, 18 mm beside the bar: of board and bar each may be 10 mm elsewhere."""
    assert told(across_a_bar(), 0.04)
    assert told(across_a_bar(noise=0.010), 0.04) == ""


@pytest.mark.parametrize(
    ("lower", "noise", "is_refused"),
    [(0.004, 0.0, True), (0.004, 0.003, False), (0.0055, 0.003, False), (0.009, 0.003, True)],
)
def test_what_may_be_as_high_as_what_carries_bears_as_well(
    lower: float, noise: float, is_refused: bool
) -> None:
    """A second bar under one end of the board: board and bar that are 3 mm off each explain 6 mm."""
    scene = across_a_bar(noise=noise)
    below = scene.find("bar").T_world_item @ pose((0.08, 0.0, -lower))
    second = lying("second", Shape(ShapeKind.BOX, BAR), below, 1.0)
    assert told(scene, 0.06)
    assert bool(told(replace(scene, items=(*scene.items, second)), 0.06)) is is_refused


def test_a_plan_that_grasps_nothing_tips_nothing() -> None:
    plan, scene = pressing(across_a_bar(), 0.06), across_a_bar()
    assert len(list(check_tipping(plan, scene))) == 1
    assert list(check_tipping(replace(plan, grasp=None), scene)) == []


def test_what_rolls_is_not_judged() -> None:
    ball = across_a_bar(shape=Shape(ShapeKind.SPHERE, (0.01,)))
    assert told(ball, 0.06) == ""


def test_what_does_not_stand_by_its_weight_is_not_judged() -> None:
    """The bar carries one end of the board: something else must, too."""
    assert told(across_a_bar(at=0.06), 0.06) == told(across_a_bar(at=0.06), -0.06) == ""


@pytest.mark.parametrize("turn", [0.0, np.pi / 4])
@pytest.mark.parametrize(
    "shape", [Shape(ShapeKind.BOX, (0.06, 0.06, 0.1)), Shape(ShapeKind.CYLINDER, (0.03, 0.1))]
)
def test_a_support_ends_where_the_lower_face_ends(shape: Shape, turn: float) -> None:
    """Upright on a board, turned or not, a press of 100 N beside the face leads beside it, no further in."""
    R = rotation_axis_angle(np.array([0.0, 0.0, 1.0]), turn)
    item = lying("item", shape, pose((0.0, 0.0, 0.05), R=R), 0.1)
    floor = lying("floor", Shape(ShapeKind.BOX, (0.5, 0.5, 0.02)), pose((0.0, 0.0, -0.01)), 1.0)
    scene = make_scene(item, floor)
    push = np.array([0.0, 0.0, -100.0])
    assert beside_support(scene, item, push, R @ [0.029, 0.0, 0.1]) == 0.0
    weight = item.item.lightest * GRAVITY
    for x in (0.0295, 0.0305, 0.06):
        out = 100.0 / (100.0 + weight) * x - 0.03
        beside = beside_support(scene, item, push, R @ [x, 0.0, 0.1])
        assert 0.99 * max(0.0, out) <= beside <= max(0.0, out + EDGE)


def test_a_slanting_press_counts_where_it_meets_the_support() -> None:
    item = lying("item", Shape(ShapeKind.BOX, (0.06, 0.06, 0.1)), pose((0.0, 0.0, 0.05)), 1e-6)
    floor = lying("floor", Shape(ShapeKind.BOX, (0.5, 0.5, 0.02)), pose((0.0, 0.0, -0.01)), 1.0)
    scene, top = make_scene(item, floor), np.array([0.0, 0.0, 0.1])
    assert beside_support(scene, item, np.array([0.2, 0.0, -1.0]), top) == 0.0
    inwards = top - (0.04, 0.0, 0.0)  # meets the floor at 10 mm, from beside the face
    assert beside_support(scene, item, np.array([0.5, 0.0, -1.0]), inwards) == 0.0
    slanting = beside_support(scene, item, np.array([0.5, 0.0, -1.0]), top)  # meets the floor at 50 mm
    assert slanting == pytest.approx(0.02, abs=EDGE)


@pytest.mark.parametrize(("where", "off"), [("tote", 0.0), ("bin_E", 0.0), ("bin_E", 0.01)])
def test_floors_carry_too_and_the_pod_where_it_may_stand(where: str, off: float) -> None:
    """100 N, 30 mm beside the face of a box that weighs nothing."""
    place = cell().places[where]
    x = 0.4 if where == "bin_E" else 0.0
    T = cell().T_world_place(place) @ pose((x, 0.0, float(place.room.floor_at(x)) + 0.05))
    upright = lying("item", Shape(ShapeKind.BOX, (0.06, 0.06, 0.1)), T, 1e-6)
    item = replace(upright, location=where)
    scene = replace(make_scene(item), pod_error=Displacement(off, 0.0, 0.0))
    push, top = np.array([0.0, 0.0, -100.0]), T[:3, 3] + (0.0, 0.0, 0.05)
    assert beside_support(scene, item, push, top) == 0.0
    beside = beside_support(scene, item, push, top - (0.06, 0.0, 0.0))
    assert 0.03 - off - 1e-6 <= beside <= 0.03 - off + EDGE


# From aside

WEIGHT = 0.2 * 0.9 * GRAVITY  # N, as light as it may be
DEEP, TALL = 0.02, 0.1  # m
AHEAD = -0.4  # m, where it stands in front of the pod, far from any wall
STIFF = 1000.0  # N/m


def standing(
    noise: PoseNoise | None = None, turn: float = 0.0, depth: float = DEEP
) -> tuple[Scene, PlacedItem]:
    """A box on a floor, tall for its depth along x, turned about the vertical."""
    T = pose((AHEAD, 0.0, TALL / 2), rpy=(0.0, 0.0, turn))
    item = lying("item", Shape(ShapeKind.BOX, (depth, 0.08, TALL)), T, 0.2)
    floor = lying("floor", Shape(ShapeKind.BOX, (0.5, 0.5, 0.02)), pose((AHEAD, 0.0, -0.01)), 1.0)
    return make_scene(item, floor, noise=noise), item


def aside(item: PlacedItem, height: float, depth: float, speed: float = 0.0) -> Press:
    """A level press along the item's x, at a height over the floor."""
    R = item.T_world_item[:3, :3] @ np.column_stack([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    reach = depth - item.item.shape.extents[0] / 2
    at = item.T_world_item[:3, 3] + reach * R[:, 2] + (0.0, 0.0, height - TALL / 2)
    return Press(pose(at, R=R), depth, STIFF, speed)


def most_push(height: float, tilted: float = 0.0) -> float:
    """How far (m) a cup may push the box: until it stands still just where its centre is over the edge.

    There the bellows push no more, so the press point has come as far as they were pressed in.
    tilted: rad by which the box may lean that way already
    """
    b, z = DEEP / 2, TALL / 2
    angle = np.arctan2(b, z) - tilted
    return float(2 * b * (1.0 - np.cos(angle)) + height * np.sin(angle))


@pytest.mark.parametrize("height", [0.03, 0.06, 0.09])
@pytest.mark.parametrize("turn", [0.0, 0.5])
def test_what_is_pushed_farther_than_its_centre_is_inside_falls_over(height: float, turn: float) -> None:
    scene, item = standing(turn=turn)
    most = most_push(height)
    assert not falls_over(scene, item, aside(item, height, 0.95 * most))
    assert falls_over(scene, item, aside(item, height, 1.05 * most))


def test_poses_that_may_be_off_bring_the_item_nearer_and_tilt_it() -> None:
    height, most = 0.06, most_push(0.06)
    for noise in (PoseNoise(0.002, 0.0), PoseNoise(0.0, 0.03)):
        scene, item = standing(noise)
        off = noise.position + noise.angle * (height + 0.01)
        assert falls_over(scene, item, aside(item, height, 1.02 * most - noise.position))
        assert falls_over(scene, item, aside(item, height, most - 0.2 * off))
        assert not falls_over(scene, item, aside(item, height, most - 1.4 * off))


def test_a_pose_that_is_off_in_angle_brings_what_is_pressed_over_its_middle_nearer() -> None:
    """By the angle times the height over the middle, on top of how far it leans."""
    height, angle = 0.09, 0.005
    scene, item = standing(PoseNoise(0.0, angle))
    nearer = angle * (height - TALL / 2)
    most = most_push(height, tilted=angle) - nearer
    assert not falls_over(scene, item, aside(item, height, most - 0.3 * nearer))
    assert falls_over(scene, item, aside(item, height, most + 0.3 * nearer))


def test_soft_bellows_do_not_even_tip_a_heavy_item() -> None:
    scene, item = standing()
    heavy = replace(item, item=replace(item.item, mass=20.0))
    for placed, is_tipped in ((item, True), (heavy, False)):
        there = replace(scene, items=(placed, scene.items[1]))
        assert falls_over(there, placed, aside(placed, 0.06, 0.02)) is is_tipped


def test_a_cup_that_comes_too_fast_throws_it_over() -> None:
    """At twice the speed of the cup the turn has a share of the energy that lifts it over the edge."""
    scene, item = standing()
    b, z, height = DEEP / 2, TALL / 2, 0.06
    inertia = (b**2 + z**2) * 4.0 / 3.0
    turn = np.sqrt(2.0 * MOST_THROWN * GRAVITY * (np.hypot(b, z) - z) / inertia)
    speed = float(turn * height / 2.0)
    assert not falls_over(scene, item, aside(item, height, 0.0, 0.99 * speed))
    assert falls_over(scene, item, aside(item, height, 0.0, 1.01 * speed))


@pytest.mark.parametrize("height", [0.03, 0.05])
def test_the_lowest_part_of_the_lip_stays_on_the_longest_and_pushes_on(height: float) -> None:
    """At no more travel than a cup as small as a point, and no less than one at its lowest part."""
    scene, item = standing()
    most, radius = most_push(height), 0.015
    least = most_push(height - radius)
    for depth, falls in ((0.98 * least, False), (0.99 * most, True), (1.02 * most, True)):
        assert falls_over(scene, item, replace(aside(item, height, depth), radius=radius)) is falls


def test_a_cup_throws_by_the_lowest_part_of_its_lip() -> None:
    scene, item = standing()
    b, z, height, radius = DEEP / 2, TALL / 2, 0.06, 0.015
    lifting = MOST_THROWN * GRAVITY * (np.hypot(b, z) - z)
    turn = np.sqrt(2.0 * lifting / ((b**2 + z**2) * 4.0 / 3.0))
    speed = float(turn * (height - radius) / 2.0)
    for share, falls in ((0.99, False), (1.01, True)):
        press = replace(aside(item, height, 0.0, share * speed), radius=radius)
        assert falls_over(scene, item, press) is falls


@pytest.mark.parametrize("lean", [0.02, 0.06])
def test_what_leans_as_it_is_perceived_turns_about_its_own_edge(lean: float) -> None:
    """Its side faces down a little, as near to the floor as poses may be off, but carries nothing."""
    b, z, height, error = 0.02, 0.03, 0.045, 0.06
    R = rotation_axis_angle(np.array([0.0, 1.0, 0.0]), lean)
    centre = R @ [-b, 0.0, z]  # of a box with its edge at the origin
    item = lying(
        "item",
        Shape(ShapeKind.BOX, (2 * b, 0.08, 2 * z)),
        pose(centre + np.array([AHEAD, 0.0, 0.0]), R=R),
        0.2,
    )
    floor = lying("floor", Shape(ShapeKind.BOX, (0.5, 0.5, 0.02)), pose((AHEAD, 0.0, -0.01)), 1.0)
    scene = make_scene(item, floor, noise=PoseNoise(0.0, error))
    to_edge = np.arctan2(-centre[0], centre[2])
    lifting = GRAVITY * np.hypot(b, z) * (np.cos(error) - np.cos(to_edge))
    turn = np.sqrt(2.0 * MOST_THROWN * lifting / ((b**2 + z**2) * 4.0 / 3.0))
    across = np.column_stack([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])
    for share, falls in ((0.97, False), (1.03, True)):
        press = Press(
            pose((AHEAD - 2 * b, 0.0, height), R=across), 0.0, 1e-6, float(share * turn * height / 2.0)
        )
        assert falls_over(scene, item, press) is falls


def test_what_is_as_deep_as_the_press_is_high_slides() -> None:
    for depth, falls in ((0.11, True), (0.13, False)):
        scene, item = standing(depth=depth)
        assert falls_over(scene, item, aside(item, 0.06, 0.1, 2.0)) is falls


@pytest.mark.parametrize(
    ("depth", "is_refused"), [(0.025, False), (0.023, False), (0.012, True), (0.006, True)]
)
def test_a_plan_that_throws_over_what_it_takes_from_the_front_is_refused(
    depth: float, is_refused: bool
) -> None:
    """The box of crayons, upright, and thinner ones whose front is where its front is."""
    plan, scene = pick()
    target, grasp = scene.find(CRAYOLA), plan.grasp
    assert grasp is not None
    T = target.T_world_item @ pose((0.0, 0.0, (depth - 0.025) / 2))
    thin = replace(target.item, shape=Shape(ShapeKind.BOX, (*target.item.shape.size[:2], depth)))
    there = scene.moved(replace(target, item=thin, T_world_item=T))
    at = replace(grasp, T_item_tip=inverse(T) @ target.T_world_item @ grasp.T_item_tip)
    told = [reason.what for reason in check_tipping(replace(plan, grasp=at), there)]
    assert told == ["tips the item"] * is_refused
