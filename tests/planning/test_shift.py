"""Shifts within a bin: certified, where they should end, refused where they must be, and in simulation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickProblem, PickQuery, Shift
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import extraction_of
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.world import World
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.quintic import positions_at
from pickcli.verification.verify import certifier, verify

SceneWith = Callable[..., Scene]
PlanShift = Callable[..., Plan]
ITEM = "dove_beauty_bar"


@pytest.fixture(scope="session")
def plan_shift(context: PlanningContext, home: Start) -> PlanShift:
    """plan_shift(scene, bin_name, by): the plan that the verifier accepts."""

    def plan(scene: Scene, bin_name: str, by: Shift) -> Plan:
        query = PickQuery(bin_name, ITEM, bin_name, by=by)
        return plan_pick(context, scene, query, home, 3, certify=certifier(scene))

    return plan


def _resting(scene: Scene) -> Scene:
    """The scene with its item parallel to the floor below it, 0.5 mm over it."""
    (placed,) = scene.items
    place, extents = scene.cell.places[placed.location], placed.item.shape.extents
    height, pitch = place.room.rest(np.array(0.25), extents[0] / 2)
    above = extents[2] / 2 + 0.0005
    at = [0.25 + above * np.sin(pitch), 0.0, height + above * np.cos(pitch)]
    T = scene.T_world_place(place) @ pose(at, R=rotation_axis_angle((0.0, 1.0, 0.0), float(pitch)))
    return scene.moved(replace(placed, T_world_item=T))


def _held_poses(plan: Plan, scene: Scene) -> np.ndarray:
    """Poses (N, 4, 4) of the held item in the frame of its place, by the verifier's kinematics."""
    held = [segment for segment in plan.segments if segment.held is not None]
    times = np.linspace(held[0].t_start, held[-1].t_end, 200)
    robot = scene.cell.robot
    tips = tip_poses(robot, link_poses(robot, positions_at(plan.trajectory, times)), held[0].tool_state)
    T_tip_item = pose_in_tool(plan, scene)
    assert T_tip_item is not None
    place = scene.cell.places[scene.items[0].location]
    return np.asarray(inverse(scene.T_world_place(place)) @ tips @ T_tip_item)


@pytest.mark.parametrize(
    ("bin_name", "by"),
    [
        ("bin_B", Shift(-0.03, 0.02)),
        ("bin_E", Shift(0.06, 0.0)),
        ("bin_H", Shift(0.0, -0.02, np.radians(25.0))),
        ("bin_K", Shift(-0.15, 0.0)),
    ],
    ids=["aside", "over the bend of the floor", "turned", "far"],
)
def test_an_item_ends_displaced_as_requested_and_just_over_the_floor(
    scene_with: SceneWith, plan_shift: PlanShift, bin_name: str, by: Shift
) -> None:
    scene = _resting(scene_with((ITEM, bin_name, 0.25, 0.0)))
    plan = plan_shift(scene, bin_name, by)
    assert plan.certificate is not None
    kinds = [segment.kind for segment in plan.segments if segment.held is not None]
    assert set(kinds) == {SegmentKind.LIFT, SegmentKind.PLACE}
    poses = _held_poses(plan, scene)
    np.testing.assert_allclose((poses[-1] - poses[0])[:2, 3], [by.x, by.y], atol=1e-3)
    place, shape = scene.cell.places[bin_name], scene.items[0].item.shape
    above = float(shape.extents[2]) / 2
    pitch = np.arcsin(poses[-1][0, 2])
    half = shape.reach(poses[-1][:3, :3])[0]
    height, floor_pitch = place.room.rest(poses[-1][0, 3] - above * np.sin(pitch), half)
    assert pitch == pytest.approx(floor_pitch, abs=0.01)
    assert poses[-1][2, 3] - height - above * np.cos(pitch) == pytest.approx(0.002, abs=0.001)
    assert np.ptp(poses[:, 2, 3]) < 0.06  # it stays low


def test_a_shift_into_a_wall_or_a_neighbour_or_out_of_the_mouth_is_refused(
    scene_with: SceneWith, plan_shift: PlanShift
) -> None:
    scene = scene_with((ITEM, "bin_B", 0.25, 0.0), ("crayola_24_ct", "bin_B", 0.25, 0.11))
    for by, what, in_the_way in (
        (Shift(0.0, -0.2), "no room to shift", ()),
        (Shift(0.0, 0.08), "too close", ("crayola_24_ct",)),
        (Shift(-0.28, 0.0), "no such shift", ()),
        (Shift(0.001, 0.0), "no such shift", ()),
    ):
        with pytest.raises(NoPlanError) as caught:
            plan_shift(scene, "bin_B", by)
        assert caught.value.reasons[0].what == what
        assert caught.value.in_the_way == in_the_way


def beside_a_bottle(cell: Cell, y: float) -> Scene:
    """The item in bin_B at y, and 6 mm beside it a bottle, which lies and can roll."""
    place = cell.places["bin_B"]
    T_world_place, lying = cell.T_world_place(place), rotation_axis_angle((0.0, 1.0, 0.0), np.pi / 2)

    def on_floor(name: str, y: float, R: Array) -> PlacedItem:
        above = float(cell.item(name).shape.reach(R)[2]) + 0.0005
        height, pitch = place.room.rest(np.array(0.25), cell.item(name).shape.reach(R)[0])
        at = np.array([0.25 + above * np.sin(pitch), y, height + above * np.cos(pitch)])
        T = pose(at, R=rotation_axis_angle((0.0, 1.0, 0.0), float(pitch)) @ R)
        return PlacedItem(name, cell.item(name), place.name, T_world_place @ T)

    widths = cell.item(ITEM).shape.extents[1] / 2 + cell.item("up_glucose_bottle").shape.reach(lying)[1]
    items = on_floor(ITEM, y, np.eye(3)), on_floor("up_glucose_bottle", y - 0.006 - widths, lying)
    return Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0))))


def test_a_neighbour_that_could_roll_after_the_item_is_named(
    context: PlanningContext, cell: Cell, home: Start
) -> None:
    """What is in the way is not what happens to be nearest."""
    scene = beside_a_bottle(cell, 0.05)
    with pytest.raises(NoPlanError) as caught:
        plan_pick(context, scene, PickQuery("bin_B", ITEM, "bin_B", by=Shift(0.0, 0.02)), home)
    assert {reason.what for reason in caught.value.reasons} == {"no room to shift"}
    assert all("could roll after it" in reason.detail for reason in caught.value.reasons)
    assert caught.value.in_the_way == ("up_glucose_bottle",)


@pytest.mark.parametrize("y", [0.05, 0.07])
def test_a_wall_does_not_roll_after_the_item(context: PlanningContext, cell: Cell, y: float) -> None:
    """Beside a bottle on one side, the wall on the other side is not taken for something that rolls."""
    problem = PickProblem.of(context, beside_a_bottle(cell, y), PickQuery("bin_B", ITEM), 0)
    corridors = extraction_of(problem).corridors
    assert not isinstance(corridors, Failures) and len(corridors) > 0


@pytest.mark.parametrize("query", ["by -33,20 mm", "by -30,20 mm and 5 deg", "by -30,-20 mm"])
def test_the_verifier_compares_the_shift_with_the_query(
    scene_with: SceneWith, plan_shift: PlanShift, query: str
) -> None:
    scene = _resting(scene_with((ITEM, "bin_B", 0.25, 0.0)))
    plan = plan_shift(scene, "bin_B", Shift(-0.03, 0.02))
    wrong = replace(plan, query=f"shift {ITEM} in bin_B {query}")
    assert [reason.what for reason in verify(wrong, scene).reasons] == ["not shifted as stated"]
    elsewhere = replace(plan, query=plan.query.replace("bin_B", "bin_C"))
    assert [reason.what for reason in verify(elsewhere, scene).reasons] == ["wrong query"]


@pytest.mark.parametrize(
    ("bin_name", "by"), [("bin_B", Shift(-0.03, 0.02)), ("bin_H", Shift(0.02, 0.0, 0.5))]
)
def test_a_simulated_shift_ends_where_it_was_planned(
    cell: Cell, scene_with: SceneWith, plan_shift: PlanShift, bin_name: str, by: Shift
) -> None:
    scene = _resting(scene_with((ITEM, bin_name, 0.25, 0.0)))
    plan = plan_shift(scene, bin_name, by)
    planned = _held_poses(plan, scene)[-1]
    world = World(scene, plan.trajectory.positions[0], plan.segments[0].tool_state, seed=1)
    try:
        record = execute(plan, world)
        assert record.is_clean, record.trouble
        world.wait(0.5)
        place = cell.places[bin_name]
        after = inverse(scene.T_world_place(place)) @ world.now().find(ITEM).T_world_item
    finally:
        world.close()
    assert float(np.linalg.norm((after - planned)[:2, 3])) < 0.003
