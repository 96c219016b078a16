"""From any place into any other, by its access: crates that stand turned, a table top, a shelf by a grid."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.place import Place
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.recovery.recovery_plan import plan_recovery
from pickcli.planning.stages.drop_placements import ABOVE_PILE, LEAST_WALL_DISTANCE, MAX_DROP, drop_placements
from pickcli.planning.stages.floor_placements import floor_placements
from pickcli.planning.start_state import Start
from pickcli.scene.scene import CarrierPose, PlacedItem, PoseNoise, Scene
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth
from pickcli.simulation.execute import execute
from pickcli.simulation.settle import settle
from pickcli.simulation.world import World
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.release_check import check_release
from pickcli.verification.static_solids import place_at, release_pose
from pickcli.verification.verify import verify
from support.cell_copies import CellCopy
from support.place_cells import BENCH, CRATES, RACK, with_places
from support.tool_states import STRAIGHT

BAR = "dove_beauty_bar"
NEAR_BENCH = BENCH.replace("[-0.55, -1.0, 0.75]", "[-0.85, 0.35, 0.75]")  # within the arm's reach
NOISE = PoseNoise(0.002, float(np.radians(1.0)))


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Cell:
    """The default cell with two crates, one of them turned, a bench and a shelf in the stead of its tote."""
    folder = tmp_path_factory.mktemp("own") / "cell"
    shutil.copytree(data_path() / "cells" / "apc2016_delft", folder)
    return with_places(CellCopy(folder), CRATES, NEAR_BENCH, RACK).load()


@pytest.fixture(scope="module")
def context(own: Cell) -> PlanningContext:
    return PlanningContext(own)


def lying(cell: Cell, place: str, at: tuple[float, float], name: str = BAR) -> PlacedItem:
    """An item on the floor of a place, at (x, y) in its frame, m."""
    item, where = cell.item(name), cell.places[place]
    floor, pitch = where.room.rest(np.asarray(at[0]), item.shape.extents[0] / 2)
    # A hair over what it will lie on.
    z = float(floor) + float(item.shape.extents[2]) / 2 + 5e-4
    T = cell.T_world_place(where) @ pose((*at, z), rpy=(0.0, float(pitch), 0.0))
    return PlacedItem(f"{name} in {place} {at}", item, place, T)


def scene_of(cell: Cell, *items: PlacedItem) -> Scene:
    return Scene(cell, cell.T_world_pod, items, NOISE)


def box_in(scene: Scene, place: Place, placed: PlacedItem) -> tuple[Array, Array]:
    """Corners (3,) of the box around an item, along the axes of the place."""
    T = inverse(scene.T_world_place(place)) @ placed.T_world_item
    reach = placed.item.shape.reach(T[:3, :3])
    return T[:3, 3] - reach, T[:3, 3] + reach


# Where an item can be put


@pytest.fixture
def held(own: Cell) -> AttachedItem:
    """A box that hangs from the middle of its top."""
    item = own.item("crayola_24_ct")
    half = float(item.shape.extents[2]) / 2
    return AttachedItem(item, pose([0.0, 0.0, half], R=np.diag([1.0, -1.0, -1.0])), 0.003)


@pytest.mark.parametrize("name", ["crate_left", "crate_right"])
def test_what_is_dropped_into_a_crate_is_between_its_walls_and_over_the_pile(
    own: Cell, held: AttachedItem, name: str
) -> None:
    scene, place = scene_of(own, lying(own, name, (0.05, 0.03))), own.places[name]
    spots = drop_placements(scene, place, held, STRAIGHT)
    assert not isinstance(spots, Failures) and spots
    bottom, top = box_in(scene, place, scene.items[0])
    for spot in spots:
        dropped = PlacedItem("one", held.item, name, spot.release @ held.T_tip_item)
        low, high = box_in(scene, place, dropped)
        beside = np.maximum(high[:2] - place.room.high[:2], place.room.low[:2] - low[:2])
        assert beside.max() <= -LEAST_WALL_DISTANCE + 1e-9
        assert ABOVE_PILE - 1e-9 <= low[2] <= MAX_DROP + 1e-9
        is_over = (np.minimum(high, top)[:2] > np.maximum(low, bottom)[:2]).all()
        assert not is_over or low[2] >= top[2] + ABOVE_PILE - 1e-9


def test_drops_go_along_with_a_crate_that_was_moved(own: Cell, held: AttachedItem) -> None:
    """Seen from the crate they are the same, wherever it stands and however it is turned."""
    place = own.places["crate_right"]
    nominal = drop_placements(scene_of(own), place, held, STRAIGHT)
    turned = own.T_world_place(place) @ pose((0.01, 0.02, 0.0), rpy=(0.0, 0.0, 0.7))
    moved = replace(scene_of(own), carriers={"crate_right": CarrierPose(turned)})
    there = drop_placements(moved, place, held, STRAIGHT)
    assert not isinstance(nominal, Failures) and not isinstance(there, Failures)
    for a, b in zip(nominal, there, strict=True):
        assert np.allclose(inverse(own.T_world_place(place)) @ a.release, inverse(turned) @ b.release)


@pytest.mark.parametrize(("name", "at"), [("bench", (0.05, -0.1)), ("rack_1_2", (0.2, 0.05))])
def test_what_is_set_down_is_wholly_there_clear_of_the_rest_and_stays(
    own: Cell, context: PlanningContext, name: str, at: tuple[float, float]
) -> None:
    other, item = lying(own, name, at), lying(own, "crate_left", (0.0, 0.0))
    scene, place = scene_of(own, other, item), own.places[name]
    spots = floor_placements(context, scene, item, rotation_axis_angle((0.0, 0.0, 1.0), 0.3), place, 6)
    assert not isinstance(spots, Failures) and len(spots) == 6
    for spot in spots:
        low, high = box_in(scene, place, spot)
        assert (low[:2] >= place.room.low[:2]).all() and (high[:2] <= place.room.high[:2]).all()
        assert low[2] >= place.room.floor_back - 1e-9
        there, beside = (PosedSolid(each.item.shape, each.T_world_item) for each in (spot, other))
        assert overlap_depth(there, beside) == 0.0
    rested = settle(scene, (other, spots[0]))
    assert isinstance(rested, tuple), rested
    assert np.linalg.norm((rested[1].T_world_item - spots[0].T_world_item)[:3, 3]) < 0.02


def test_a_thin_mat_does_not_bring_what_lies_on_it_too_near_to_the_table_below() -> None:
    cell = load_cell("panda_table")
    place, item = cell.places["mat_right"], lying(cell, "mat_front", (0.0, 0.0))
    spots = floor_placements(PlanningContext(cell), scene_of(cell, item), item, np.eye(3), place)
    assert not isinstance(spots, Failures) and spots


# Whole motions


WAYS = [
    pytest.param("crate_left", "crate_right", (0.02, 0.01), marks=pytest.mark.slow),
    ("crate_right", "bench", (0.02, 0.01)),
    ("bench", "crate_left", (0.02, 0.01)),
    pytest.param("crate_left", "rack_1_1", (0.02, 0.01), marks=pytest.mark.slow),
    pytest.param("rack_2_2", "crate_right", (0.15, 0.0), marks=pytest.mark.slow),
]


def moved(context: PlanningContext, scene: Scene, into: str) -> Plan:
    home, placed = scene.cell.configurations["home"], scene.items[0]
    start = Start(home.q, home.tool_state)
    return plan_pick(context, scene, PickQuery(placed.location, placed.id, into=into), start)


@pytest.mark.parametrize(("out_of", "into", "at"), WAYS)
def test_an_item_goes_from_any_place_into_any_other(
    own: Cell, context: PlanningContext, out_of: str, into: str, at: tuple[float, float]
) -> None:
    scene = scene_of(own, lying(own, out_of, at))
    plan = moved(context, scene, into)
    assert verify(plan, scene).reasons == ()
    world = World(scene, own.configurations["home"].q)
    try:
        done = execute(plan, world)
        assert not done.stopped and not world.contacts.collisions
        assert world.placed(scene.items[0].id).location == into
    finally:
        world.close()


@pytest.mark.slow
def test_what_leans_in_a_crate_stands_straight_in_a_shelf() -> None:
    """Its top leans by 35 degrees to any side; the cup leans with it, and points straight into the bin."""
    cell = load_cell("ur5e_crates")
    context, crate = PlanningContext(cell), cell.places["crate_left"]
    for yaw in (0.3, 2.0):
        R = rotation_axis_angle((0.0, 0.0, 1.0), yaw) @ rotation_axis_angle((1.0, 0.0, 0.0), 0.6)
        item = cell.item("soft_white_lightbulb")
        at = pose((0.0, 0.0, float(item.shape.reach(R)[2])), R=R)
        scene = scene_of(cell, PlacedItem("bulb", item, "crate_left", cell.T_world_place(crate) @ at))
        plan = moved(context, scene, "shelf_1_1")
        assert verify(plan, scene).reasons == ()
        held, k = pose_in_tool(plan, scene), max(k for k, s in enumerate(plan.segments) if s.held is not None)
        assert plan.grasp is not None and held is not None
        tip = release_pose(plan, scene, k, held) @ plan.grasp.T_item_tip
        assert (cell.T_world_place(cell.places["shelf_1_1"])[:3, 0] @ tip[:3, 2]) > np.cos(np.radians(2.0))


# What the verifier refuses


def reasons_where_it_is_let_go(plan: Plan, scene: Scene, T_place_moved: Array, place: str) -> list[str]:
    """What the verifier says of a release that is moved in the frame of a place, its segments as they are."""
    held, k = pose_in_tool(plan, scene), max(k for k, s in enumerate(plan.segments) if s.held is not None)
    assert held is not None
    there, T_world_place = release_pose(plan, scene, k, held), scene.T_world_place(scene.cell.places[place])
    elsewhere = T_world_place @ T_place_moved @ inverse(T_world_place) @ there
    return [
        reason.what for reason in check_release(plan, scene, np.asarray(held @ inverse(there) @ elsewhere))
    ]


def test_a_release_beyond_walls_edge_or_mouth_or_too_high_is_refused(
    own: Cell, context: PlanningContext
) -> None:
    scene = scene_of(own, lying(own, "crate_left", (0.02, 0.01)))
    for into, faults in {
        "crate_right": {
            (0.0, 0.0, 0.0): [],
            (-0.3, 0.0, 0.0): ["released beyond the crate_right's walls"],
            (0.0, -0.28, 0.0): ["released beyond the crate_right's walls"],
            (0.0, 0.0, 0.31): ["released too high"],
        },
        "bench": {
            (0.0, 0.0, 0.0): [],
            (0.26, 0.0, 0.0): ["released beyond the bench's edge", "would fall over"],
            (0.0, 0.0, 0.04): ["released too high"],
        },
    }.items():  # fmt: skip
        plan = moved(context, scene, into)
        for shift, told in faults.items():
            assert reasons_where_it_is_let_go(plan, scene, pose(shift), into) == told, (into, shift)


def test_what_is_let_go_in_front_of_a_shelf_is_in_no_place(cell_copy: CellCopy) -> None:
    """Where shelves are all there is; over a floor it counts for the nearest place that is open above."""
    scene = scene_of(with_places(cell_copy, "places:\n", RACK).load())
    place = scene.cell.places["rack_1_1"]
    T_world_place = scene.T_world_place(place)
    inside = place_at(scene, T_world_place @ pose((0.1, 0.0, 0.05)))
    assert inside is place
    assert place_at(scene, T_world_place @ pose((-0.1, 0.0, 0.05))) is None


# Out of a place after a stop, in cells without a pod


def stopped_over(cell: Cell, place: str) -> tuple[Scene, Start]:
    """An empty scene, and the tool at rest 20 mm over the middle of a place's floor."""
    arm, tool_state = Arm(cell.robot), cell.robot.tool.default_state
    where, scene = cell.places[place], scene_of(cell)
    floor, _ = where.room.rest(np.asarray(0.0), np.asarray(0.01))
    down = scene.T_world_place(where) @ pose((0.0, 0.0, float(floor) + 0.02))
    seeds = np.stack([named.q for named in cell.configurations.values()])
    checker = PlanningContext(cell).checker_for(scene, Mode(tool_state))
    for yaw in np.radians(np.arange(0.0, 360.0, 30.0)):
        T = down @ pose(R=rotation_axis_angle((0.0, 0.0, 1.0), yaw) @ np.diag([1.0, -1.0, -1.0]))
        solutions = arm.solve(T, tool_state, seeds)
        free = solutions[checker.are_valid(solutions)] if len(solutions) else solutions
        if len(free):
            return scene, Start(free[0], tool_state)
    raise AssertionError(f"nothing reaches {place}")


@pytest.mark.parametrize(("name", "place"), [("panda_table", "tray"), ("ur5e_crates", "crate_right")])
def test_a_stopped_arm_rises_out_of_a_place_that_is_open_above(name: str, place: str) -> None:
    cell = load_cell(name)
    scene, start = stopped_over(cell, place)
    context, arm = PlanningContext(cell), Arm(cell.robot)
    for level in (RecoveryLevel.AS_PLANNED, RecoveryLevel.OPENING, RecoveryLevel.SLOWLY):
        out = plan_recovery(context, scene, start, level=level)
        line = next(s for s in reversed(out.segments) if s.kind is SegmentKind.RETREAT)
        before, after = (
            arm.tip(out.trajectory.sample(t)[0], start.tool_state)[:3, 3] for t in (0.0, line.t_end)
        )
        mouth = (scene.T_world_place(cell.places[place]) @ cell.places[place].access.T_place_mouth)[2, 3]
        assert after[2] > mouth + 0.05 > before[2] and abs(after - before)[:2].max() < 0.001
        assert verify(out, scene).reasons == ()


def test_a_slow_way_out_leads_no_deeper_into_any_place() -> None:
    """The way out of a tray, driven backwards, is a way in."""
    cell = load_cell("panda_table")
    scene, start = stopped_over(cell, "tray")
    out = plan_recovery(PlanningContext(cell), scene, start, level=RecoveryLevel.SLOWLY)
    into = replace(out, trajectory=replace(out.trajectory, positions=out.trajectory.positions[::-1]))
    found = {reason.what for reason in verify(into, scene).reasons}
    assert "leads into the place" in found
