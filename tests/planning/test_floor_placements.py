"""Into another bin: a pick that ends on a free place of a floor, certified, or says why there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Failures, Reason, UnknownNameError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.floor_placements import (
    BEHIND_LIP,
    FROM_MOUTH,
    FROM_WALLS,
    STEP,
    floor_placements,
)
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.touching import PosedSolids, gaps
from pickcli.simulation.settle import settle
from pickcli.statics.balance import FREE_SLENDERNESS
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.release_check import check_release
from pickcli.verification.static_solids import release_pose
from pickcli.verification.verify import verify

SceneWith = Callable[..., Scene]

ITEM, FROM, INTO = "crayola_24_ct", "bin_B", "bin_F"


@pytest.fixture(scope="module")
def scene(scene_with: SceneWith) -> Scene:
    return scene_with((ITEM, FROM, 0.2, 0.0), ("dove_beauty_bar", INTO, 0.35, 0.03))


@pytest.fixture(scope="module")
def moved(context: PlanningContext, cell: Cell, scene: Scene) -> Plan:
    home = cell.configurations["home"]
    return plan_pick(context, scene, PickQuery(FROM, ITEM, into=INTO), Start(home.q, home.tool_state), seed=2)


def with_segment(plan: Plan, k: int, **changes: object) -> Plan:
    segments = list(plan.segments)
    segments[k] = replace(segments[k], **changes)  # type: ignore[arg-type]
    return replace(plan, segments=tuple(segments))


def test_what_would_not_stay_where_it_is_let_go_is_refused(
    context: PlanningContext, scene: Scene, moved: Plan
) -> None:
    """Over the floor it is set down; half over a box of 17 mm, as far over the floor, it would tumble."""
    T = pose_in_tool(moved, scene)
    assert T is not None
    there = release_pose(moved, scene, release(moved), T)
    higher = pose((0.0, 0.0, 0.017)) @ there
    T_higher = np.asarray(T @ inverse(there) @ higher)
    assert check_release(moved, scene, T_higher) == ()
    item = replace(scene.find(ITEM).item, shape=Shape(ShapeKind.BOX, (0.08, 0.2, 0.016)))
    low = float(scene.find(ITEM).item.shape.reach(there[:3, :3])[2])
    aside = pose((there[0, 3] + 0.045, there[1, 3], there[2, 3] - low + 0.008))
    box = PlacedItem("a box", item, INTO, aside)
    reasons = check_release(moved, replace(scene, items=(*scene.items, box)), T_higher)
    assert [reason.what for reason in reasons] == ["would fall over"]


def release(plan: Plan) -> int:
    return max(k for k, segment in enumerate(plan.segments) if segment.held is not None)


def set_down(context: PlanningContext, plan: Plan) -> Array:
    """Pose (4, 4) in the world of the item when it is let go."""
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    last = plan.segments[release(plan)]
    assert plan.grasp is not None

    def tip(s: Segment) -> Array:
        return context.arm.tip(plan.trajectory.sample(s.t_end)[0], s.tool_state)

    # It has not moved relative to the cup since the contact.
    return np.asarray(tip(last) @ inverse(tip(contact)))


def test_it_goes_in_straight_and_comes_out_empty_certified(moved: Plan, scene: Scene) -> None:
    kinds = list(dict.fromkeys(s.kind for s in moved.segments))
    after = kinds[kinds.index(SegmentKind.TRANSFER) :]
    assert after == [SegmentKind.TRANSFER, SegmentKind.INSERT, SegmentKind.PLACE, SegmentKind.DEPART]
    assert moved.segments[-1].held is None
    verdict = verify(moved, scene)
    assert verdict.reasons == ()
    assert "valve off" in {f"{e.device} {e.action}" for e in moved.events}


def test_it_is_let_go_just_over_the_floor_inside_the_bin(
    context: PlanningContext, moved: Plan, scene: Scene
) -> None:
    cell_bin, placed = scene.cell.pod.bins[INTO], scene.find(ITEM)
    T = inverse(scene.T_world_place(cell_bin)) @ set_down(context, moved) @ placed.T_world_item
    reach = placed.item.shape.reach(T[:3, :3])
    low, high = T[:3, 3] - reach, T[:3, 3] + reach
    assert low[0] > 0.02 and high[0] < cell_bin.room.depth
    assert cell_bin.room.y_range[0] < low[1] and high[1] < cell_bin.room.y_range[1]
    height, _ = cell_bin.room.rest(np.asarray(T[0, 3]), reach[0])
    assert 0.0 < T[2, 3] - reach[2] - float(height) < scene.noise.bound(placed.item) + 0.002


def test_the_item_stands_in_the_way_of_the_cup_that_left_it(moved: Plan, scene: Scene) -> None:
    """The verifier follows an item that is set down: without leave to touch it, the cup collides with it."""
    off = release(moved) + 1
    assert ITEM in moved.segments[off].touching
    verdict = verify(with_segment(moved, off, touching=()), scene)
    assert any(ITEM in reason.detail for reason in verdict.reasons)


@pytest.mark.parametrize("kind", [SegmentKind.INSERT, SegmentKind.TRANSFER])
def test_nothing_may_be_touched_before_the_last_stretch(moved: Plan, scene: Scene, kind: SegmentKind) -> None:
    k = next(k for k, s in enumerate(moved.segments) if s.kind is kind)
    floor = scene.cell.pod.bins[INTO].support
    reasons = verify(with_segment(moved, k, touching=floor), scene).reasons
    assert [r.what for r in reasons] == ["touching not allowed"] * len(reasons) != []


def test_every_place_is_clear_of_what_lies_there(context: PlanningContext, scene_with: SceneWith) -> None:
    scene = scene_with(
        (ITEM, FROM, 0.2, 0.0),
        ("dove_beauty_bar", INTO, 0.2, 0.05),
        ("expo_dry_erase_board_eraser", INTO, 0.35, -0.05),
    )
    placed = scene.items[0]
    spots = floor_placements(context, scene, placed, np.eye(3), scene.cell.pod.bins[INTO], n_most=50)
    assert not isinstance(spots, Failures) and len(spots) > 5
    for spot in spots:
        reach = spot.item.shape.reach(spot.T_world_item[:3, :3])
        for other in scene.items[1:]:
            theirs = other.item.shape.reach(other.T_world_item[:3, :3])
            gap = np.abs(spot.T_world_item[:3, 3] - other.T_world_item[:3, 3]) - reach - theirs
            assert gap.max() > scene.cell.clearance


def test_a_full_bin_and_a_thin_thing_say_why(context: PlanningContext, scene_with: SceneWith) -> None:
    full = scene_with(
        (ITEM, FROM, 0.2, 0.0),
        *(("dove_beauty_bar", INTO, x, y) for x in (0.1, 0.22, 0.34) for y in (-0.08, 0.0, 0.08)),
    )
    cell_bin = full.cell.pod.bins[INTO]
    none = floor_placements(context, full, full.items[0], np.eye(3), cell_bin)
    assert isinstance(none, Failures)
    assert {reason.what for reason in none} == {"no free place on the floor"}
    assert set(none.in_the_way) == {"dove_beauty_bar"}
    thin = replace(full.items[0], item=full.cell.item("i_am_a_bunny_book"))
    extents = thin.item.shape.extents
    thinnest = int(np.argmin(extents))
    R = np.roll(np.eye(3), 2 - (thinnest + 1), axis=0)  # another axis than the thinnest upwards
    reach = thin.item.shape.reach(R)
    assert reach[:2].min() < FREE_SLENDERNESS * reach[2]
    falls = floor_placements(context, full.moved(thin), thin, R, cell_bin)
    assert isinstance(falls, Failures)
    assert "would fall over" in [reason.what for reason in falls]


CARDS = "staples_index_cards"


def facing(scene: Scene, name: str) -> Array:
    """How an item stands (3, 3) with its largest side to the front, the longest edge upwards."""
    thin, middle, long = np.argsort(scene.find(name).item.shape.extents)
    R = np.zeros((3, 3))
    R[0, thin] = R[1, middle] = R[2, long] = 1.0
    R[0] *= np.linalg.det(R)
    return R


@pytest.mark.parametrize("bin_name", ["bin_B", "bin_F", "bin_H", "bin_J"])
def test_what_is_thin_leans_back_on_the_wall_and_stays_there(
    context: PlanningContext, scene_with: SceneWith, bin_name: str
) -> None:
    """Physics is the judge: what is let go there leans where it is, and does not slide down."""
    scene = scene_with((CARDS, "bin_A", 0.2, 0.0))
    placed, place = scene.items[0], scene.cell.pod.bins[bin_name]
    spots = floor_placements(context, scene, placed, facing(scene, CARDS), place)
    assert not isinstance(spots, Failures) and spots
    for spot in spots[:2]:
        rested = settle(scene, (spot,))
        assert not isinstance(rested, Reason)
        assert np.linalg.norm(rested[0].T_world_item[:3, 3] - spot.T_world_item[:3, 3]) < 0.012
        up = (inverse(spot.T_world_item) @ rested[0].T_world_item)[:3, :3]
        assert np.trace(up) > 1.0 + 2.0 * np.cos(np.radians(8.0))


def test_what_is_thin_leans_on_an_item_that_is_behind_it(
    context: PlanningContext, scene_with: SceneWith
) -> None:
    scene = scene_with((CARDS, "bin_A", 0.2, 0.0), ("kleenex_tissue_box", INTO, 0.35, 0.0))
    placed, place = scene.items[0], scene.cell.pod.bins[INTO]
    spots = floor_placements(context, scene, placed, facing(scene, CARDS), place, n_most=50)
    assert not isinstance(spots, Failures)
    box = scene.items[1]
    before = [s for s in spots if (inverse(scene.T_world_place(place)) @ s.T_world_item)[0, 3] < 0.3]
    assert before and box.location == INTO
    rested = settle(scene, (box, before[0]))
    assert not isinstance(rested, Reason)
    assert np.linalg.norm(rested[1].T_world_item[:3, 3] - before[0].T_world_item[:3, 3]) < 0.012


def test_what_leans_is_let_go_short_of_what_it_leans_on_by_the_errors_of_both(
    context: PlanningContext, scene_with: SceneWith
) -> None:
    """Otherwise the arm would press it on an item that is nearer than it was seen."""
    exact = scene_with((CARDS, "bin_A", 0.2, 0.0), ("kleenex_tissue_box", INTO, 0.35, 0.0))
    scene = replace(exact, noise=PoseNoise(0.002, float(np.radians(1.0))))
    (placed, box), place = scene.items, scene.cell.pod.bins[INTO]
    spots = floor_placements(context, scene, placed, facing(scene, CARDS), place, n_most=50)
    assert not isinstance(spots, Failures)
    before = [s for s in spots if (inverse(scene.T_world_place(place)) @ s.T_world_item)[0, 3] < 0.3]
    assert before
    shapes = [(item.item.shape, item.T_world_item) for item in (*before, box)]
    n = np.arange(len(before))
    apart = gaps(PosedSolids.standing(shapes), n, np.full(len(before), len(before))).width
    bounds = scene.noise.bound(placed.item) + scene.noise.bound(box.item)
    assert (apart > 0.9 * bounds).all()


@pytest.mark.parametrize("name", ["rawlings_baseball", "dasani_water_bottle"])
def test_what_rolls_is_set_down_on_level_ground_or_nowhere(
    context: PlanningContext, scene_with: SceneWith, name: str
) -> None:
    """Physics is the judge: on the slopes of the floors balls roll, and bottles that lie across them."""
    scene = scene_with((name, FROM, 0.2, 0.0))
    (placed,) = scene.items
    lying = rotation_axis_angle((1.0, 0.0, 0.0), np.pi / 2)
    for bin_name in ("bin_A", INTO, "bin_L"):
        spots = floor_placements(context, scene, placed, lying, scene.cell.pod.bins[bin_name], n_most=3)
        if isinstance(spots, Failures):
            assert [reason.what for reason in spots] == ["would fall over or roll"]
            continue
        assert spots
        for spot in spots:
            rested = settle(scene, (spot,))
            assert not isinstance(rested, Reason)
            assert np.linalg.norm(rested[0].T_world_item[:3, 3] - spot.T_world_item[:3, 3]) < 0.01


def test_an_item_that_leans_is_set_down_level(context: PlanningContext, scene: Scene) -> None:
    leaning = pose(rpy=(0.1, 0.0, 0.4))[:3, :3]
    spots = floor_placements(context, scene, scene.find(ITEM), leaning, scene.cell.pod.bins[INTO])
    assert not isinstance(spots, Failures) and spots
    T_world_bin = scene.T_world_place(scene.cell.pod.bins[INTO])
    for spot in spots:
        R = (inverse(T_world_bin) @ spot.T_world_item)[:3, :3]
        assert abs(R[1, 2]) < 1e-9  # no roll; its pitch is that of the floor


def test_a_place_that_is_not_in_the_cell_is_named(context: PlanningContext, cell: Cell, scene: Scene) -> None:
    home = Start(cell.configurations["home"].q, cell.configurations["home"].tool_state)
    with pytest.raises(UnknownNameError, match="unknown place 'bin_X'"):
        plan_pick(context, scene, PickQuery(FROM, ITEM, into="bin_X"), home)


@pytest.mark.parametrize(
    ("cell_name", "place_name", "least"),
    [("ur5e_crates", "shelf_2_1", FROM_MOUTH), ("apc2016_delft", "bin_F", BEHIND_LIP)],
)
def test_what_is_set_down_stays_behind_the_lip_and_where_there_is_none_just_behind_the_mouth(
    cell_name: str, place_name: str, least: float
) -> None:
    """All free places of an empty shelf: the first row begins there, and none before it."""
    cell = load_cell(cell_name)
    place = cell.places[place_name]
    elsewhere = next(other for other in cell.places.values() if other is not place)
    placed = PlacedItem(ITEM, cell.item(ITEM), elsewhere.name, cell.T_world_place(elsewhere))
    scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, float(np.radians(1.0))))
    spots = floor_placements(PlanningContext(cell), scene, placed, np.eye(3), place, n_most=1000)
    assert not isinstance(spots, Failures)
    T_place_items = [inverse(cell.T_world_place(place)) @ spot.T_world_item for spot in spots]
    fronts = [T[0, 3] - placed.item.shape.reach(T[:3, :3])[0] for T in T_place_items]
    assert least - 1e-3 <= min(fronts) < least + STEP


def test_what_is_set_down_may_stand_as_near_to_the_walls_as_they_have_to_be_kept_clear(
    context: PlanningContext, cell: Cell
) -> None:
    place, tote = cell.places["bin_F"], cell.places["tote"]
    placed = PlacedItem(ITEM, cell.item(ITEM), "tote", cell.T_world_place(tote))
    scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise())
    spots = floor_placements(context, scene, placed, np.eye(3), place, n_most=1000)
    assert not isinstance(spots, Failures)
    (_, back), (low, high) = place.room.x_range, place.room.y_range
    half = placed.item.shape.extents / 2
    x, y, _ = np.array([(inverse(cell.T_world_place(place)) @ s.T_world_item)[:3, 3] for s in spots]).T
    least = [(y - half[1]).min() - low, high - (y + half[1]).max(), back - (x + half[0]).max()]
    assert np.allclose(least, FROM_WALLS, atol=2e-3)


def test_a_gap_between_items_that_the_coarse_grid_misses_is_found(
    context: PlanningContext, cell: Cell
) -> None:
    """A bin full of boxes but for one gap, 20 mm longer and wider than the item."""
    place, tote = cell.places["bin_F"], cell.places["tote"]
    item, T = cell.item(ITEM), cell.T_world_place(place)
    placed = PlacedItem(ITEM, item, "tote", cell.T_world_place(tote))
    (front, back), (low, high) = place.room.x_range, place.room.y_range
    gap, tall = item.shape.extents[:2] + 0.02, 0.05
    for x, y in ((0.23, 0.013), (0.237, -0.021), (0.305, 0.031)):
        sides = (
            (front, x - gap[0] / 2, low, high), (x + gap[0] / 2, back, low, high),
            (x - gap[0] / 2, x + gap[0] / 2, low, y - gap[1] / 2),
            (x - gap[0] / 2, x + gap[0] / 2, y + gap[1] / 2, high),
        )  # fmt: skip
        boxes = []
        for k, (x0, x1, y0, y1) in enumerate(sides):
            shape = Shape(ShapeKind.BOX, (x1 - x0, y1 - y0, tall))
            at = pose([(x0 + x1) / 2, (y0 + y1) / 2, place.room.floor_back + tall / 2 + 0.001])
            boxes.append(PlacedItem(f"box{k}", replace(item, shape=shape), "bin_F", T @ at))
        scene = Scene(cell, cell.T_world_pod, (placed, *boxes), PoseNoise())
        spots = floor_placements(context, scene, placed, np.eye(3), place)
        assert not isinstance(spots, Failures), list(spots)
        found = (inverse(T) @ spots[0].T_world_item)[:2, 3]
        assert np.abs(found - (x, y)).max() < 0.01
