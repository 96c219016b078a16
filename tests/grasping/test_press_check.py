"""How fast a cup may meet what it presses on from aside, so that it does not tip it over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import GRAVITY, pose
from pickcli.grasping.backing import is_backed
from pickcli.grasping.cup_press import max_press_depth, overtravel
from pickcli.grasping.press_check import MOST_SPEED
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.tipping_check import Press, beside_support, falls_over
from support import handmade_plans
from support.bin_piles import BIN, EXACT, at, shaped
from support.piles import pile
from support.tool_states import DOWN, STRAIGHT

TALL = 0.1  # m
NOISE = PoseNoise(0.002, float(np.radians(1.0)))
INTO_X = np.column_stack([(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)])


def upright(cell: Cell, depth: float, tall: float = TALL, mass: float = 0.1) -> PlacedItem:
    """A box on the flat part of a bin's floor, so deep along the way into the bin."""
    return at(cell, "box", shaped(cell, (depth, 0.08, tall), mass=mass), 0.35, 0.0, tall / 2)


def pressed(
    cell: Cell, item: PlacedItem, height: float, noise: PoseNoise = EXACT
) -> tuple[PickProblem, Grasp]:
    """A cup from the front on an item, at a height over the floor."""
    scene = Scene(cell, cell.T_world_pod, (item,), noise)
    problem = PickProblem(PlanningContext(cell), scene, cell.places[BIN], item, cell.places[TOTE])
    depth, _, tall = item.item.shape.size
    tip = pose((-depth / 2, 0.0, height - tall / 2), R=INTO_X)
    return problem, Grasp(item.id, "frontal", "-x", STRAIGHT, tip, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def contact_speed(problem: PickProblem, grasp: Grasp) -> float | None:
    """How fast the cup may meet it."""
    return problem.context.method.contact_speed(problem.contacts, grasp)


def test_what_stands_firmly_is_met_as_fast_as_the_tool_may(cell: Cell) -> None:
    assert contact_speed(*pressed(cell, upright(cell, 0.06), 0.06)) == cell.robot.tool.cup.contact_speed


@pytest.mark.parametrize("height", [0.04, 0.07])
def test_what_is_slender_is_met_so_slowly_that_its_turn_does_not_lift_it_over_its_edge(
    cell: Cell, height: float
) -> None:
    """Nearly without a push: it turns at twice the cup's speed over the height of the lip's lowest part."""
    b, z = 0.008, TALL / 2
    speed = contact_speed(*pressed(cell, upright(cell, 2 * b, mass=2.0), height))
    assert speed is not None
    turn = 2.0 * speed / MOST_SPEED / (height - cell.robot.tool.cup.radius)
    lift = (b**2 + z**2) * 4.0 / 3.0 * turn**2 / (2.0 * GRAVITY)
    assert lift == pytest.approx(np.hypot(b, z) - z, rel=0.1)


def test_what_the_push_alone_tips_over_is_not_pressed_on(cell: Cell) -> None:
    noise = PoseNoise(0.002, float(np.radians(1.0)))
    for depth, is_tipped in ((0.008, True), (0.02, False)):
        assert (contact_speed(*pressed(cell, upright(cell, depth), 0.06, noise)) is None) is is_tipped


def test_the_greatest_press_depth_is_that_on_an_item_that_is_nearer_than_it_is_seen(cell: Cell) -> None:
    noise, tool = PoseNoise(0.002, 0.0), cell.robot.tool
    problem, grasp = pressed(cell, upright(cell, 0.02), 0.06, noise)
    assert max_press_depth(grasp, tool, noise) == overtravel(grasp, tool, noise) + 0.002
    assert problem.scene.noise is noise


def at_back_wall(cell: Cell, gap: float, tall: float = TALL, depth: float = 0.009) -> PlacedItem:
    """A slender box at a gap (m) from the back wall of a bin."""
    item = shaped(cell, (depth, 0.08, tall), mass=0.1)
    return at(cell, "box", item, float(cell.pod.bins[BIN].room.high[0]) - gap - depth / 2, 0.0, tall / 2)


@pytest.mark.parametrize(("gap", "is_stopped"), [(0.0005, True), (0.02, False)])
def test_what_a_wall_stops_before_it_leans_is_pressed_on_at_full_speed(
    cell: Cell, gap: float, is_stopped: bool
) -> None:
    item = at_back_wall(cell, gap)
    problem, grasp = pressed(cell, item, 0.06, NOISE)
    speed = contact_speed(problem, grasp)
    assert speed == (cell.robot.tool.cup.contact_speed if is_stopped else None)
    tip = item.T_world_item @ grasp.T_item_tip @ pose((0.0, 0.0, 0.004))
    cup = cell.robot.tool.cup
    press = Press(tip, 0.004, cup.stiffness, cup.contact_speed, cup.radius)
    assert falls_over(problem.scene, item, press) is not is_stopped


def test_poses_that_may_be_off_bring_the_wall_farther_away(cell: Cell) -> None:
    """Of a box 100 mm high 6 mm make 0.06 rad: 2 mm of its gap, and 5 mm of its error."""
    item = at_back_wall(cell, 0.002)
    for off, is_stopped in ((0.002, True), (0.005, False)):
        speed = contact_speed(*pressed(cell, item, 0.06, PoseNoise(off, 0.0)))
        assert (speed is not None) is is_stopped


def test_a_neighbour_behind_an_item_does_not_stop_it(cell: Cell) -> None:
    item = upright(cell, 0.009)
    behind = at(cell, "other", shaped(cell, (0.05, 0.2, 0.2), mass=3.0), 0.381, 0.0, 0.1)
    problem, grasp = pressed(cell, item, 0.06, NOISE)
    assert contact_speed(replace(problem, scene=replace(problem.scene, items=(item, behind))), grasp) is None


def test_a_wall_that_ends_beside_the_press_does_not_stop_it(cell: Cell) -> None:
    """Half of the item is behind the wall of a bin that is as wide: it would turn about the wall's edge."""
    item = at_back_wall(cell, 0.0005)
    problem, grasp = pressed(cell, item, 0.06)
    tip = item.T_world_item @ grasp.T_item_tip
    edge, way = item.T_world_item[:3, 3] - (0.0, 0.0, TALL / 2), np.array([1.0, 0.0])
    assert is_backed(problem.contacts, edge, way, tip[:3, 3], 0.015)
    assert not is_backed(problem.contacts, edge, way, tip[:3, 3] + (0.0, 0.05, 0.0), 0.015)
    assert not is_backed(problem.contacts, edge, way, tip[:3, 3] + (0.0, 0.0, 0.05), 0.015)
    assert not is_backed(problem.contacts, edge, -way, tip[:3, 3], 0.015)


@given(
    gap=st.floats(0.0, 0.01), tall=st.floats(0.04, 0.2), share=st.floats(0.2, 0.9), off=st.floats(0.0, 0.003)
)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_what_the_planner_presses_on_a_wall_stands_by_the_verifier_s_rule_too(
    gap: float, tall: float, share: float, off: float
) -> None:
    cell, noise = handmade_plans.cell(), PoseNoise(off, 0.0)
    item = at_back_wall(cell, gap, tall)
    problem, grasp = pressed(cell, item, share * tall, noise)
    speed = contact_speed(problem, grasp)
    if speed is None:
        return
    push, cup = overtravel(grasp, cell.robot.tool, noise), cell.robot.tool.cup
    tip = item.T_world_item @ grasp.T_item_tip @ pose((0.0, 0.0, push))
    assert not falls_over(problem.scene, item, Press(tip, push, cup.stiffness, speed, cup.radius))


@given(
    st.floats(0.008, 0.05),
    st.floats(0.05, 0.2),
    st.floats(0.2, 0.9),
    st.floats(0.02, 1.5),
    st.floats(0.0, 0.003),
)
@settings(max_examples=40, deadline=None, derandomize=True)
def test_what_the_planner_presses_on_stands_by_the_verifier_s_rule_too(
    depth: float, tall: float, share: float, mass: float, off: float
) -> None:
    """And not by much: if the cup came 1.4 times as fast, the verifier refuses what tips."""
    cell, height = handmade_plans.cell(), share * tall
    item, noise = upright(cell, depth, tall, mass), PoseNoise(off, 0.0)
    problem, grasp = pressed(cell, item, height, noise)
    speed = contact_speed(problem, grasp)
    if speed is None:
        return
    push = overtravel(grasp, cell.robot.tool, noise)
    tip = item.T_world_item @ grasp.T_item_tip @ pose((0.0, 0.0, push))
    press = Press(tip, push, cell.robot.tool.cup.stiffness, speed, cell.robot.tool.cup.radius)
    assert not falls_over(problem.scene, item, press)
    if speed < cell.robot.tool.cup.contact_speed and depth / 2 < 0.99 * height:
        assert falls_over(problem.scene, item, replace(press, speed=1.4 * speed))


def test_what_stands_on_something_narrow_is_met_slowly_too(cell: Cell) -> None:
    """Poses may put it beside what carries it, and it stands there all the same."""
    noise, rail = PoseNoise(0.002, float(np.radians(1.0))), shaped(cell, (0.03, 0.3, 0.02))
    item = at(cell, "box", shaped(cell, (0.03, 0.08, 0.08), mass=1.0), 0.35, 0.0, 0.06)
    problem, grasp = pressed(cell, item, 0.06, noise)
    carried = replace(problem.scene, items=(item, at(cell, "rail", rail, 0.35, 0.0, 0.01)))
    on_the_rail = contact_speed(replace(problem, scene=carried), grasp)
    assert on_the_rail is not None and on_the_rail < cell.robot.tool.cup.contact_speed
    push = overtravel(grasp, cell.robot.tool, noise)
    tip = item.T_world_item @ grasp.T_item_tip @ pose((0.0, 0.0, push))
    cup = cell.robot.tool.cup
    assert not falls_over(carried, item, Press(tip, push, cup.stiffness, on_the_rail, cup.radius))


def test_what_stands_beside_what_surely_carries_it_is_met_slowly_too(cell: Cell) -> None:
    """Over a part of the rail that is not there for sure: it stands as poses say."""
    noise, rail = PoseNoise(0.002, float(np.radians(1.0))), shaped(cell, (0.03, 0.3, 0.02))
    item = at(cell, "box", shaped(cell, (0.03, 0.08, 0.08), mass=1.0), 0.35, 0.0, 0.06)
    problem, grasp = pressed(cell, item, 0.05, noise)
    carried = replace(problem.scene, items=(item, at(cell, "rail", rail, 0.341, 0.0, 0.01)))
    problem = replace(problem, scene=carried)
    footing = problem.contacts.supports.balance.footing(item.id)
    assert len(footing) and footing[:, 0].max() < item.T_world_item[0, 3]
    on_the_edge = contact_speed(problem, grasp)
    assert on_the_edge is None or on_the_edge < cell.robot.tool.cup.contact_speed


@pytest.mark.parametrize(
    ("pattern", "seed"),
    [("on", 4), ("on", 12), ("bridge", 10), ("heap", 0), ("heap", 4), ("counterweight", 2)],
)
def test_what_the_planner_presses_on_from_above_does_not_tip_by_the_verifier_s_rule(
    cell: Cell, pattern: str, seed: int
) -> None:
    """Anywhere on what lies across others, also where its balance is not sure as poses are known."""
    pile_there = pile(cell, pattern, seed)
    assert pile_there is not None
    scene, rng = perceive(pile_there, DEFAULT_NOISE, seed, 1), np.random.default_rng(seed)
    tool, verdicts = cell.robot.tool, []
    for placed in [item for item in scene.items if item.item.shape.kind is ShapeKind.BOX]:
        problem = PickProblem(PlanningContext(cell), scene, cell.places[BIN], placed, cell.places[TOTE])
        for grasp in [from_above(placed, rng) for _ in range(12)]:
            push = overtravel(grasp, tool, scene.noise)
            tip = placed.T_world_item @ grasp.T_item_tip @ pose((0.0, 0.0, push))
            beside = beside_support(scene, placed, tool.cup.stiffness * push * tip[:3, 2], tip[:3, 3])
            verdicts.append((contact_speed(problem, grasp) is not None, beside > 0.0))
    assert (True, True) not in verdicts
    assert (True, False) in verdicts and (False, True) in verdicts


def from_above(placed: PlacedItem, rng: np.random.Generator) -> Grasp:
    """A cup somewhere on the face of a box that is uppermost."""
    axis = int(np.argmax(np.abs(placed.T_world_item[2, :3])))
    out = np.eye(3)[axis] * np.sign(placed.T_world_item[2, axis])
    at = rng.uniform(-0.48, 0.48, 3) * placed.item.shape.extents
    at[axis] = out[axis] * placed.item.shape.extents[axis] / 2
    x = np.roll(out, 1)
    tip = pose(at, R=np.column_stack([x, np.cross(-out, x), -out]))
    return Grasp(placed.id, "top-down", "+z", DOWN, tip, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("degrees", "is_judged"), [(6.0, True), (20.0, False)])
def test_what_may_or_may_not_stand_by_its_weight_is_not_pressed_over_its_edge(
    cell: Cell, degrees: float, is_judged: bool
) -> None:
    """A slender box whose centre is 0.3 mm beside its footing, and one that something unseen keeps."""
    turn, thin = (0.0, float(np.radians(degrees)), 0.0), 0.01
    plate = at(cell, "plate", shaped(cell, (0.1, 0.1, 0.02)), 0.35, 0.0, 0.05, turn)
    T = plate.T_world_item @ pose((0.0, 0.0, 0.01 + TALL / 2))
    box = PlacedItem("box", shaped(cell, (thin, 0.08, TALL), mass=0.1), BIN, T)
    problem, grasp = pressed(cell, box, 0.06)
    scene = replace(problem.scene, items=(plate, box))
    speed = contact_speed(replace(problem, scene=scene), grasp)
    assert (speed is None) is is_judged
