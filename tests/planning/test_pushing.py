"""Out of a heap: what partly lies on the target, or stands beside it, is pushed aside; a rider is not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import plan_to_dict
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.pick_settings import DEFAULTS, Neighbours
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.statics.pushing import HEAVIEST, MARGIN, mass_above, pushable, pushed_height, riders
from pickcli.statics.supports import supports_of
from pickcli.verification.push_check import PushedHeap
from pickcli.verification.verify import certify, verify
from support.heaps import BOOK, BOX, OTHER, bridge, in_tote

OUTWARDS = (SegmentKind.LIFT, SegmentKind.RETREAT)
PUSH = PickQuery(TOTE, BOX, into="bin_E", neighbours=Neighbours.PUSH)


@pytest.fixture(scope="module")
def heap(cell: Cell) -> Scene:
    return bridge(cell)


@pytest.fixture(scope="module")
def pushing(context: PlanningContext, heap: Scene, home: Start) -> Plan:
    return certify(plan_pick(context, heap, PUSH, home), heap)


def test_the_book_is_in_the_way_unless_it_may_be_pushed(
    context: PlanningContext, heap: Scene, home: Start, pushing: Plan
) -> None:
    with pytest.raises(NoPlanError) as avoiding:
        plan_pick(context, heap, replace(PUSH, neighbours=Neighbours.AVOID), home)
    assert avoiding.value.in_the_way == (BOOK,)
    for segment in pushing.segments:
        assert segment.pushing == ((OTHER, BOOK) if segment.kind in OUTWARDS else ())


def test_it_slides_off_in_simulation_and_stays_in_the_tote(heap: Scene, home: Start, pushing: Plan) -> None:
    world = World(heap, home.q)
    heights: list[float] = []
    run = execute(
        pushing, world, on_step=lambda now: heights.append(float(now.placed(BOOK).T_world_item[2, 3]))
    )
    assert run.has_item and not run.stopped and not run.limit_violations
    assert world.placed(BOX).location == "bin_E" and not world.contacts.collisions
    assert [world.placed(name).location for name in (OTHER, BOOK)] == [TOTE, TOTE]
    assert max(heights) > float(heap.find(BOOK).T_world_item[2, 3]) + 0.005  # it was lifted by one side
    world.close()


def test_the_file_says_what_is_pushed_where_something_is(pushing: Plan) -> None:
    written = [segment.get("pushing") for segment in plan_to_dict(pushing)["segments"]]
    assert [OTHER, BOOK] in written
    assert [each is not None for each in written] == [bool(s.pushing) for s in pushing.segments]


def test_what_lies_over_the_target_must_be_moved_first(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    with pytest.raises(NoPlanError) as error:
        plan_pick(context, bridge(cell, book=-0.015), PUSH, home)
    assert error.value.in_the_way == (BOOK,)
    assert "carried along" in str(error.value)


def test_a_rider_has_its_centre_over_the_edge_or_inside_of_it(cell: Cell) -> None:
    edge = -0.09 + float(cell.item(BOX).shape.extents[0]) / 2
    for book in np.linspace(-0.06, 0.08, 15).tolist():
        scene = bridge(cell, book)
        bounds = sum(scene.noise.bound(scene.find(name).item) for name in (BOX, BOOK))
        is_rider = riders(supports_of(scene), BOX) == (BOOK,)
        if book - edge < bounds:
            assert is_rider
        elif book - edge > bounds + MARGIN:
            assert not is_rider


def leaning(cell: Cell) -> Scene:
    """A plank (the target) that leans over the edge of a pillar, whose centre may be the higher one."""
    lean, edge, height = np.radians(60.0), 0.05, 0.2
    box, book = (in_tote(cell, name, 0.0, 0.0, 0.0) for name in (OTHER, BOOK))
    shape = Shape(ShapeKind.BOX, (0.02, 0.06, height))
    T = in_tote_at(cell, [edge + 0.01, 0.0, height / 2 + 0.0002])
    pillar = replace(box, item=replace(box.item, shape=shape), T_world_item=T)
    along, over = np.array([np.cos(lean), 0.0, np.sin(lean)]), np.array([-np.sin(lean), 0.0, np.cos(lean)])
    foot = np.array([edge, 0.0, height + 0.0004]) - along * height / np.sin(lean)
    R = rotation_axis_angle((0.0, 1.0, 0.0), -lean)
    T = in_tote_at(cell, foot + 0.116 * along + 0.0052 * over) @ pose([0.0, 0.0, 0.0], R=R)
    shape = Shape(ShapeKind.BOX, (0.234, 0.09, 0.01))
    plank = replace(book, item=replace(book.item, shape=shape), T_world_item=T)
    return Scene(cell, cell.T_world_pod, (plank, pillar), PoseNoise(0.002, float(np.radians(1.0))))


def in_tote_at(cell: Cell, xyz: Sequence[float]) -> Array:
    return cell.T_world_place(cell.places[TOTE]) @ pose(xyz)


def test_what_carries_the_target_does_not_ride_on_it(cell: Cell) -> None:
    scene = leaning(cell)
    supports, plank, pillar = supports_of(scene), scene.find(BOOK), scene.find(OTHER)
    assert pillar.T_world_item[2, 3] > plank.T_world_item[2, 3] - scene.noise.bound(plank.item)
    assert OTHER in supports.graph.carriers(BOOK)
    assert riders(supports, BOOK) == ()
    heap = PushedHeap(scene, cell.places[TOTE], plank)
    assert list(heap.carried_along(frozenset({OTHER}))) == []
    # Higher and apart, it may be met as the plank rises.
    higher = scene.moved(replace(pillar, T_world_item=pose([-0.05, 0.0, 0.12]) @ pillar.T_world_item))
    assert riders(supports_of(higher), BOOK) == (OTHER,)


def test_what_is_heavy_or_high_or_below_such_an_item_may_not_be_pushed(cell: Cell, heap: Scene) -> None:
    assert pushable(supports_of(heap), BOX) == {OTHER, BOOK}
    book = heap.find(BOOK)
    heavy = heap.moved(replace(book, item=replace(book.item, mass=HEAVIEST / 1.09)))
    assert pushable(supports_of(heavy), BOX) == frozenset()
    high = heap.moved(replace(book, T_world_item=pose([0.0, 0.0, 0.2]) @ book.T_world_item))
    assert BOOK not in pushable(supports_of(high), BOX)
    aside = replace(heap, items=(*heap.items, in_tote(cell, "dove_beauty_bar", 0.2, 0.12, 0.0002)))
    assert "dove_beauty_bar" in pushable(supports_of(aside), BOX)


def propped(cell: Cell, height: float) -> Scene:
    """A board (m high) that leans by 5 degrees against a box, and the target on the far side of that."""
    lean, top, thick = np.radians(5.0), 0.12, 0.01
    far, box, book = (in_tote(cell, name, 0.0, 0.0, 0.0) for name in (BOX, OTHER, BOOK))
    R = rotation_axis_angle((0.0, 1.0, 0.0), lean)
    along, off = np.array([np.sin(lean), 0.0, np.cos(lean)]), np.array([np.cos(lean), 0.0, -np.sin(lean)])
    at = along * height / 2 - off * thick / 2 + (0.0, 0.0, 0.0002)
    T = in_tote_at(cell, at.tolist()) @ pose([0.0, 0.0, 0.0], R=R)
    shape = Shape(ShapeKind.BOX, (thick, 0.09, height))
    board = replace(book, item=replace(book.item, shape=shape), T_world_item=T)
    edge = top * np.tan(lean) + 0.0003
    shape = Shape(ShapeKind.BOX, (0.06, 0.09, top))
    T = in_tote_at(cell, [edge + 0.03, 0.0, top / 2 + 0.0002])
    prop = replace(box, item=replace(box.item, shape=shape), T_world_item=T)
    target = replace(far, T_world_item=in_tote_at(cell, [0.2, 0.0, float(far.item.shape.extents[2]) / 2]))
    return Scene(cell, cell.T_world_pod, (target, prop, board), PoseNoise(0.001, float(np.radians(0.5))))


@pytest.mark.parametrize(("height", "may_be_pushed"), [(0.36, True), (0.46, False)])
def test_what_keeps_a_high_item_from_falling_may_not_be_pushed(
    cell: Cell, height: float, may_be_pushed: bool
) -> None:
    scene = propped(cell, height)
    supports, heap = supports_of(scene), PushedHeap(scene, cell.places[TOTE], scene.find(BOX))
    assert BOOK in supports.falling(OTHER)
    assert BOOK not in supports.graph.lying_on(OTHER)
    assert (OTHER in pushable(supports, BOX)) is may_be_pushed
    told = "; ".join(map(str, heap.not_pushable(frozenset({OTHER}))))
    assert ("would fall without them, and may fall over the rim" in told) is not may_be_pushed


def test_two_that_hold_a_high_item_together_may_not_be_pushed_at_once(cell: Cell) -> None:
    scene = propped(cell, 0.46)
    prop, board = scene.find(OTHER), scene.find(BOOK)
    half = Shape(ShapeKind.BOX, (0.06, 0.04, prop.item.shape.size[2]))
    apart = [
        replace(prop, id=name, item=replace(prop.item, shape=half), T_world_item=prop.T_world_item @ pose(at))
        for name, at in ((OTHER, [0.0, -0.025, 0.0]), (f"{OTHER}_2", [0.0, 0.025, 0.0]))
    ]
    scene = replace(scene, items=(scene.find(BOX), *apart, board))
    pushed = frozenset(each.id for each in apart)
    supports, heap = supports_of(scene), PushedHeap(scene, cell.places[TOTE], scene.find(BOX))
    assert not pushable(supports, BOX) & pushed
    assert "may fall over the rim" in "; ".join(map(str, heap.not_pushable(pushed)))
    for name in pushed:
        assert "over the rim" not in "; ".join(map(str, heap.not_pushable(frozenset({name}))))


def test_nothing_is_pushed_in_a_bin_or_into_a_place(
    context: PlanningContext, cell: Cell, home: Start, heap: Scene
) -> None:
    shelf = bridge(cell, place="bin_E")
    problem = PickProblem.of(context, shelf, replace(PUSH, out_of="bin_E", into=TOTE), 0)
    assert problem.pushed == frozenset() and problem.settings is context.settings
    problem = PickProblem.of(context, heap, PUSH, 0)
    assert problem.pushed == {OTHER, BOOK}
    back = problem.back_from(replace(heap.find(BOX), location="bin_E"))
    assert back.pushed == frozenset() and back.settings is context.settings


def test_it_is_slow_and_leaves_a_reserve_for_all_that_lies_on_the_target(
    context: PlanningContext, heap: Scene, home: Start
) -> None:
    problem = PickProblem.of(context, heap, PUSH, 0)
    assert problem.mass_on_target == pytest.approx(heap.find(BOOK).item.heaviest)
    assert problem.settings.load_ratio == DEFAULTS.push_load_ratio
    assert max(problem.settings.lift_speed, problem.settings.retreat_speed) == DEFAULTS.push_speed
    book = heap.find(BOOK)
    heavy = heap.moved(replace(book, item=replace(book.item, mass=0.5)))
    with pytest.raises(NoPlanError, match=r"does not hold: with 0.55 kg on it"):
        plan_pick(context, heavy, PUSH, home)


def test_what_would_be_met_above_counts_though_nothing_touches_it(cell: Cell, heap: Scene) -> None:
    """A book 20 mm over the target, as if a third item held it up there."""
    book = heap.find(BOOK)
    for aside, is_rider in ((0.0, False), (-0.085, True)):
        T = pose([aside, 0.0, 0.02]) @ book.T_world_item
        supports = supports_of(heap.moved(replace(book, T_world_item=T)))
        assert mass_above(supports, BOX) == pytest.approx(book.item.heaviest)
        assert (riders(supports, BOX) == (BOOK,)) is is_rider
    beside = pose([0.05, 0.0, 0.02]) @ book.T_world_item
    assert mass_above(supports_of(heap.moved(replace(book, T_world_item=beside))), BOX) == 0.0


def beside(cell: Cell, lean: float) -> Scene:
    """A tall plank beside the target; it leans over that by an angle in rad."""
    box, other = (in_tote(cell, name, 0.0, 0.0, 0.0) for name in (BOX, OTHER))
    size = box.item.shape.extents
    box = replace(box, T_world_item=in_tote_at(cell, [0.0, 0.0, size[2] / 2 + 0.0002]))
    shape, R = Shape(ShapeKind.BOX, (0.02, 0.06, 0.2)), rotation_axis_angle((0.0, 1.0, 0.0), -lean)
    edge = np.array([size[0] / 2 + 0.0005, 0.0, size[2] * np.sign(lean) + 0.0002])
    middle = edge + R @ [0.01, 0.0, 0.1 - size[2] * np.sign(lean)]
    T = in_tote_at(cell, middle) @ pose([0.0, 0.0, 0.0], R=R)
    plank = replace(other, item=replace(other.item, shape=shape), T_world_item=T)
    return Scene(cell, cell.T_world_pod, (box, plank), PoseNoise(0.002, float(np.radians(1.0))))


def test_what_stands_beside_the_target_is_not_met_as_it_rises(cell: Cell) -> None:
    """Within the errors of poses it is over the target, but the target passes it; unless it leans over."""
    for lean, is_met in ((0.0, False), (np.radians(1.0), False), (np.radians(6.0), True)):
        scene = beside(cell, lean)
        supports, box = supports_of(scene), scene.find(BOX)
        heap, pushed = PushedHeap(scene, cell.places[TOTE], box), pushable(supports, BOX)
        assert pushed == {OTHER}
        mass = scene.find(OTHER).item.heaviest if is_met else 0.0
        assert mass_above(supports, BOX) == pytest.approx(mass)
        assert heap.mass_on_it(pushed) == pytest.approx(mass)


def test_a_plan_is_the_same_if_there_is_nothing_to_push(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    alone = replace(bridge(cell), items=bridge(cell).items[:1])
    plans = [
        plan_to_dict(replace(plan_pick(context, alone, replace(PUSH, neighbours=way), home), statistics={}))
        for way in (Neighbours.AVOID, Neighbours.PUSH)
    ]
    assert plans[0] == plans[1]


def test_the_retreat_ends_above_what_may_rear_up_beside_the_target(heap: Scene, pushing: Plan) -> None:
    """The book, lifted by one side, could stand on a corner when the item is gone."""
    book = heap.find(BOOK)
    bottom = float(book.T_world_item[2, 3] - book.item.shape.extents[2] / 2)
    top = bottom + float(np.linalg.norm(book.item.shape.extents))
    supports = supports_of(heap)
    assert top < pushed_height(supports, BOX) < top + 0.03
    box = heap.find(BOX)  # nothing lies on the book, and the box stands beside or below it
    assert pushed_height(supports, BOOK) == pytest.approx(
        float(box.T_world_item[2, 3] + box.item.shape.reach(box.T_world_item[:3, :3])[2]), abs=0.01
    )
    retreat = max(k for k, s in enumerate(pushing.segments) if s.kind is SegmentKind.RETREAT)
    assert lowest_held(pushing, heap, pushing.segments[retreat].t_end) > top


def test_a_retreat_that_ends_lower_is_refused(
    context: PlanningContext, heap: Scene, home: Start, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(PickProblem, "above_pushed", -np.inf)
    low = plan_pick(context, heap, PUSH, home)
    found = [str(reason) for reason in verify(low, heap).reasons]
    assert len(found) == 1 and "lower than what it pushed may stand up" in found[0]


def lowest_held(plan: Plan, scene: Scene, t: float) -> float:
    """Height in m of the lowest point of the held item at a time."""
    robot = scene.cell.robot
    held = next(s for s in plan.segments if s.t_start <= t <= s.t_end and s.held is not None)
    assert plan.grasp is not None
    T = Arm(robot).tip(plan.trajectory.sample(t)[0], held.tool_state) @ inverse(plan.grasp.T_item_tip)
    return float(T[2, 3] - scene.item(plan.grasp.item).shape.reach(T[:3, :3])[2])
