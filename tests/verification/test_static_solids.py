"""What stands where and when: the places of a cell, what is seen, what is taken away and what is set down."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import TOTE, HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.static_solids import _beside, place_at, plan_fixtures, release_pose
from pickcli.verification.support_check import check_support
from support.cell_copies import CellCopy
from support.handmade_plans import CRAYOLA, cell, crayola_scene, make_scene, place, tip
from support.place_cells import CRATES, with_places
from support.rail_motions import HOME, rail
from support.tool_states import DOWN, STRAIGHT

T_ITEM_TIP = pose((0.0, 0.0, 0.02))


def plan_of(*kinds: SegmentKind, held: tuple[bool, ...]) -> Plan:
    """Segments of which each moves the rail on by 50 mm."""
    plan = rail(*[0.05] * len(kinds))
    parts = tuple(
        replace(segment, kind=kind, held=CRAYOLA if is_held else None)
        for segment, kind, is_held in zip(plan.segments, kinds, held, strict=True)
    )
    grasp = Grasp(CRAYOLA, "frontal", "-z", STRAIGHT, T_ITEM_TIP, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    return replace(plan, segments=parts, grasp=grasp)


def tip_after(ways: int) -> Array:
    return tip(HOME + 0.05 * ways * np.eye(len(HOME))[0])


# Places


def at(scene: Scene, name: str, xyz: tuple[float, float, float]) -> str | None:
    """The place that a point in the frame of a place is in."""
    found = place_at(scene, scene.T_world_place(scene.cell.places[name]) @ pose(xyz))
    return None if found is None else found.name


def test_a_bin_is_where_its_room_is_and_all_else_is_over_the_tote() -> None:
    scene = replace(make_scene(), T_world_pod=pose((0.1, 0.2, 0.0), rpy=(0.0, 0.0, 0.3)))
    for name, bin in cell().pod.bins.items():
        x = bin.room.depth / 2
        middle = float(bin.room.floor_at(x)) + 0.05
        assert [at(scene, name, (x, 0.99 * y, middle)) for y in bin.room.y_range] == [name, name]
        assert at(scene, name, (-0.01, 0.0, middle)) == TOTE
    assert at(scene, TOTE, (0.0, 0.0, 0.1)) == at(scene, TOTE, (3.0, 3.0, -0.5)) == TOTE
    bare = replace(scene, cell=replace(scene.cell, tote=None))
    assert at(bare, "bin_A", (-0.01, 0.0, 0.1)) is None


def test_of_places_that_are_open_above_the_one_below_counts_or_the_nearest(cell_copy: CellCopy) -> None:
    """Two crates side by side: between them the nearer one, whose walls what is let go there would meet."""
    own = with_places(cell_copy, CRATES).load()
    scene = replace(make_scene(), cell=own)
    right = own.places["crate_right"].room.high
    assert at(scene, "crate_right", (0.9 * right[0], 0.9 * right[1], 0.1)) == "crate_right"
    gap = scene.T_world_place(own.places["crate_left"])[:2, 3] - (-1.25, -0.62)
    towards = (0.3 * float(gap[0]), 0.3 * float(gap[1]), 0.3)
    assert at(scene, "crate_right", towards) == "crate_right"
    assert at(scene, "crate_right", (0.9 * float(gap[0]), 0.0, 0.3)) == "crate_left"
    assert at(scene, "crate_right", (-5.0, 0.0, 0.3)) == "crate_right"


def test_over_an_open_place_is_what_is_over_its_floor(cell_copy: CellCopy) -> None:
    """The floor lies 0.2 m below the origin of the frame."""
    place = with_places(cell_copy, CRATES).load().places["crate_left"]
    low = replace(place, room=replace(place.room, floor_front=-0.2, floor_back=-0.2))
    for z, over in ((0.3, 0.5), (-0.1, 0.1), (-0.2, np.inf), (-0.3, np.inf)):
        assert _beside(low, np.array([0.0, 0.0, z])) == pytest.approx((0.0, over))


# What is held, and where it is let go


def test_what_a_contact_takes_hangs_as_it_lay_and_what_was_held_as_the_scene_says() -> None:
    item = PlacedItem(CRAYOLA, cell().item(CRAYOLA), "bin_A", tip_after(1) @ pose((0.01, 0.02, 0.03)))
    taking = plan_of(SegmentKind.CONTACT, SegmentKind.LIFT, held=(False, True))
    hangs = pose_in_tool(taking, make_scene(item))
    assert hangs == pytest.approx(pose((0.01, 0.02, 0.03)), abs=1e-9)
    turned = replace(taking, segments=(replace(taking.segments[0], tool_state=DOWN), taking.segments[1]))
    expected = inverse(tip(HOME + 0.05 * np.eye(len(HOME))[0], DOWN)) @ item.T_world_item
    assert pose_in_tool(turned, make_scene(item)) == pytest.approx(expected, abs=1e-9)
    bringing = plan_of(SegmentKind.TRANSFER, held=(True,))
    held = HeldItem(CRAYOLA, item.item, pose((0.0, 0.0, 0.1)))
    assert pose_in_tool(bringing, replace(make_scene(), held=held)) is held.T_tip_item
    assert pose_in_tool(bringing, make_scene(item)) is None
    assert pose_in_tool(replace(taking, grasp=None), make_scene(item)) is None


def test_an_item_is_let_go_where_the_tool_has_it_at_the_end_of_a_segment() -> None:
    plan, T = plan_of(SegmentKind.TRANSFER, SegmentKind.PLACE, held=(True, True)), pose((0.0, 0.01, 0.1))
    for k in (0, 1):
        np.testing.assert_allclose(release_pose(plan, make_scene(), k, T), tip_after(k + 1) @ T, atol=1e-9)


# What stands


def names(plan: Plan, scene: Scene, T_tip_item: Array | None) -> list[list[str]]:
    """Names of items that stand in each segment."""
    world = plan_fixtures(plan, scene, T_tip_item)
    bodies = {body.name for body, _ in scene.standing}
    return [[f.name for f in world.of(k) if f.name not in bodies] for k in range(len(plan.segments))]


KINDS = SegmentKind.CONTACT, SegmentKind.LIFT, SegmentKind.PLACE, SegmentKind.DEPART, SegmentKind.TRANSIT
HELD = False, True, True, False, False
BAR = "dove_beauty_bar"


def test_what_is_taken_stands_until_then_and_where_it_is_set_down_from_then_on() -> None:
    scene, plan = crayola_scene(), plan_of(*KINDS, held=HELD)
    others = [item.id for item in scene.items if item.id != CRAYOLA]
    in_bin = scene.T_world_place(scene.cell.places["bin_H"]) @ pose((0.2, 0.0, 0.1))
    T = inverse(tip_after(3)) @ in_bin
    found = names(plan, scene, T)
    assert found[0] == [CRAYOLA, *others] and found[1] == found[2] == others
    assert sorted(found[3]) == sorted(found[4]) == sorted([CRAYOLA, *others])
    world = plan_fixtures(plan, scene, T)
    for k, there in ((0, scene.find(CRAYOLA).T_world_item), (3, in_bin)):
        (stands,) = [f for f in world.of(k) if f.name == CRAYOLA]
        np.testing.assert_allclose(stands.T_world_shape, there, atol=1e-9)
    over_tote = inverse(tip_after(3)) @ scene.T_world_place(scene.cell.places[TOTE]) @ pose((0, 0, 0.1))
    for falls, bare in ((over_tote, scene), (T, replace(scene, cell=replace(scene.cell, tote=None)))):
        is_in_a_place = bare is not scene
        assert names(plan, bare, falls)[4] == found[4] if is_in_a_place else others
    assert names(replace(plan, grasp=None), scene, T)[4] == names(plan, scene, None)[4] == others


@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_what_is_seen_where_the_cup_holds_it_is_what_the_cup_holds(noise: float) -> None:
    """Within 5 mm and what both poses may be off, any point of it."""
    T_tip_item, item = pose((0.0, 0.0, 0.1)), cell().item(CRAYOLA)
    half = float(np.linalg.norm(item.shape.extents)) / 2
    plan = plan_of(SegmentKind.TRANSFER, held=(True,))
    most = 0.005 + 2 * noise
    for off, is_it in (
        (pose((most - 1e-5, 0, 0)), True), (pose((0, 0, most + 1e-5)), False),
        (pose(rpy=(0, 0, (most - 1e-5) / half)), True), (pose(rpy=((most + 1e-5) / half, 0, 0)), False),
        (pose((0, most / 2, 0), rpy=(0, 0, 0.51 * most / half)), False),
    ):  # fmt: skip
        seen = PlacedItem(CRAYOLA, item, "bin_A", tip(HOME) @ T_tip_item @ off)
        scene = make_scene(seen, place(BAR, (2.0, 0.0, 0.0), "bin_B"), noise=PoseNoise(noise, 0.0))
        held = replace(scene, held=HeldItem(CRAYOLA, item, T_tip_item))
        assert names(plan, held, T_tip_item) == [[BAR] if is_it else [f"{CRAYOLA} as seen", BAR]]
    other = replace(held, held=HeldItem("kleenex_tissue_box", item, T_tip_item))
    assert names(plan_of(SegmentKind.TRANSIT, held=(False,)), other, None) == [[CRAYOLA, BAR]]


def test_nothing_is_taken_that_another_stands_on() -> None:
    scene = crayola_scene()
    target = scene.find(CRAYOLA)
    top = target.T_world_item[:3, 3] + (0.0, 0.0, 0.0475 + 0.017 + 4e-4)
    on_it = replace(scene, items=(*scene.items, place(f"{BAR}#2", tuple(top.tolist()), "bin_B")))
    taking = plan_of(SegmentKind.CONTACT, SegmentKind.LIFT, held=(False, True))
    assert check_support(taking, scene) == ()
    (reason,) = check_support(taking, on_it)
    assert (reason.what, reason.where) == ("takes away what others need", CRAYOLA)
    assert reason.in_the_way == f"{BAR}#2"
    for other in (replace(taking, grasp=None), plan_of(SegmentKind.LIFT, held=(True,))):
        assert check_support(other, on_it) == ()


@pytest.mark.parametrize(
    ("where", "x", "pier", "is_refused"),
    [("crate_left", 0.0, 0.05, False), ("crate_left", 0.0, 0.12, True), ("shelf_1_1", 0.17, 0.05, True)],
)
def test_what_loses_its_counterweight_may_slump_below_the_rim_of_an_open_box_only(
    where: str, x: float, pier: float, is_refused: bool
) -> None:
    """A plank with its middle past the edge of a pier, kept there by the block that is taken."""
    crates = load_cell("ur5e_crates")
    T_world_place = crates.T_world_place(crates.places[where])

    def box(name: str, size: tuple[float, ...], ahead: float, z: float) -> PlacedItem:
        item = replace(crates.item(CRAYOLA), shape=Shape(ShapeKind.BOX, size))
        return PlacedItem(name, item, where, T_world_place @ pose((ahead, 0.0, z)))

    items = (
        box("pier", (0.1, 0.1, pier), x, pier / 2),
        box("plank", (0.2, 0.1, 0.02), x - 0.06, pier + 0.01),
        box("block", (0.05, 0.05, 0.05), x + 0.02, pier + 0.045),
    )
    taking = plan_of(SegmentKind.CONTACT, SegmentKind.LIFT, held=(False, True))
    assert taking.grasp is not None
    plan = replace(taking, grasp=replace(taking.grasp, item="block"))
    found = check_support(plan, Scene(crates, crates.T_world_pod, items, PoseNoise()))
    assert [reason.in_the_way for reason in found] == (["plank"] if is_refused else [])
