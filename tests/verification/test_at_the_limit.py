"""What is exactly at a limit of the verifier is within it: exact figures in plain frames."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, pose
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import HeldItem, PoseNoise
from pickcli.verification.contact_check import _Pair
from pickcli.verification.grasp_check import _as_grasped, _seal, check_kind
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.joint_limit_check import check_limits
from pickcli.verification.release_check import check_release
from pickcli.verification.structure_check import _tool_states, check_structure
from support.handmade_plans import CRAYOLA, bound, cell, make_scene, pick, place
from support.plan_mutations import scaled
from support.tool_states import STRAIGHT

TOOL = cell().robot.tool
N = len(cell().robot.joint_names)
SCENE = make_scene()


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


def resting(*times: float) -> Trajectory:
    """The arm at rest, with a point at each of some times, s."""
    q = np.tile(np.asarray(cell().configurations["home"].q), (len(times), 1))
    return Trajectory(cell().robot.joint_names, np.array(times), q, np.zeros_like(q), np.zeros_like(q))


def plan_of(
    trajectory: Trajectory, *ends: tuple[float, float], kind: SegmentKind = SegmentKind.TRANSIT
) -> Plan:
    parts = tuple(Segment(kind, start, end, STRAIGHT, None) for start, end in ends)
    return bound(Plan("move", "", "", 0, parts, trajectory, ()), SCENE)


# Times


@pytest.mark.parametrize(
    ("end", "segments", "is_refused"),
    [
        (1.0, ((0.0, 1.0),), False),
        (1.0, ((1e-9, 1.0),), False),
        (1.0, ((1.01e-9, 1.0),), True),
        (2e-9, ((0.0, 1e-9),), False),
        (3e-9, ((0.0, 1e-9),), True),
        (1.0, ((0.0, 0.0), (0.0, 1.0)), True),
        (1.0, ((0.0, 0.5), (0.5, 0.5), (0.5, 1.0)), True),
    ],
)
def test_segments_may_be_a_nanosecond_apart_and_take_some_time(
    end: float, segments: tuple[tuple[float, float], ...], is_refused: bool
) -> None:
    found = check_structure(plan_of(resting(0.0, end), *segments), SCENE)
    assert ("segments not contiguous" in whats(found)) is is_refused


def test_points_may_be_a_nanosecond_apart() -> None:
    assert check_structure(plan_of(resting(0.0, 1e-9, 1.0), (0.0, 1.0)), SCENE) == ()


@pytest.mark.parametrize(
    ("times", "point"),
    [((0.0, 0.0, 1.0), 1), ((0.0, 1.0, 1.0), 2), ((0.0, 2.0, 1.0, 3.0), 2), ((0.0, 0.5, 1.5, 1.0), 3)],
)
def test_the_first_point_that_does_not_come_after_the_one_before_is_named(
    times: tuple[float, ...], point: int
) -> None:
    (reason,) = check_structure(plan_of(resting(*times), (0.0, times[-1])), SCENE)
    assert (reason.what, reason.where) == ("time stamps", f"point {point}")


@pytest.mark.parametrize("name", ["velocities", "accelerations"])
@pytest.mark.parametrize("end", [0, -1])
def test_a_billionth_is_rest_and_between_the_ends_nothing_rests(name: str, end: int) -> None:
    trajectory = resting(0.0, 1.0, 2.0, 3.0)
    for at, value, problem in (
        (end, 1e-9, []),
        (1, 0.01, []),
        (2, 0.01, []),
        (end, 1.01e-9, ["not at rest"]),
    ):
        values = getattr(trajectory, name).copy()
        values[at, 3] = value
        plan = plan_of(replace(trajectory, **{name: values}), (0.0, 3.0))
        assert whats(check_limits(plan, SCENE).reasons) == problem


def test_what_is_carried_at_full_speed_breaks_one_limit_and_not_two() -> None:
    plan, scene = pick()
    item = replace(scene.find(CRAYOLA).item, speed_scale=1.0)
    quick = replace(scene.cell, items={**scene.cell.items, (item.name, item.year): item})
    there = replace(scene.moved(replace(scene.find(CRAYOLA), item=item)), cell=quick)
    fast = replace(scaled(2.2)(plan), speed_scale=1.0)
    assert {"velocity limit"} == {
        what for what in whats(check_limits(fast, there).reasons) if "speed" in what or "velocity" in what
    }
    slow = replace(fast, speed_scale=0.999)
    assert "carrying speed limit" in whats(check_limits(slow, there).reasons)


def test_only_a_tool_with_joints_moves_between_its_states() -> None:
    plan = plan_of(resting(0.0, 3.0), (0.0, 3.0))
    moving = replace(plan, segments=(replace(plan.segments[0], tool_state=MOVING),))
    tool = SCENE.cell.robot.tool
    for joint, told in ((tool.joint, []), (None, ["unknown tool state"])):
        robot = replace(SCENE.cell.robot, tool=replace(tool, joint=joint))
        assert whats(_tool_states(moving, replace(SCENE, cell=replace(SCENE.cell, robot=robot)))) == told


# Who holds what


def with_held(*held: bool, contacts: tuple[int, ...] = ()) -> list[tuple[str, str]]:
    """What is wrong where segments, 1 s each, hold the item or not; those at ``contacts`` take it."""
    kinds = [SegmentKind.CONTACT if k in contacts else SegmentKind.RETREAT for k in range(len(held))]
    parts = tuple(
        Segment(kind, float(k), k + 1.0, STRAIGHT, CRAYOLA if is_held else None)
        for k, (kind, is_held) in enumerate(zip(kinds, held, strict=True))
    )
    plan = Plan(pick()[0].query, "", "", 0, parts, resting(0.0, float(len(held))), (), pick()[0].grasp)
    return [(reason.what, reason.where) for reason in check_structure(bound(plan, pick()[1]), pick()[1])]


FORGOTTEN = "held item forgotten"
OFTEN = (FORGOTTEN, "")


def test_an_item_is_taken_once_and_released_once() -> None:
    assert with_held(False, True, False, contacts=(0,)) == []
    assert with_held(False, False, True, True, False, False, contacts=(1,)) == []
    assert with_held(False, True, contacts=(0,)) == [("not let go", "end")]
    again = ("held without contact", "segment 3 (retreat)")
    assert with_held(False, True, False, True, False, contacts=(0,)) == [again, OFTEN]
    assert with_held(False, True, False, False, True, False, contacts=(0, 3)) == [OFTEN]
    first = (FORGOTTEN, "segment 0 (contact)")
    assert with_held(False, False, True, False, contacts=(0, 1)) == [first, OFTEN]
    assert with_held(False, False, contacts=(0,)) == [first]
    assert with_held(False, False, contacts=(1,)) == [(FORGOTTEN, "segment 1 (contact)")]
    assert with_held(False, True, False) == [("held without contact", "segment 1 (retreat)")]


@pytest.mark.parametrize("kind", list(SegmentKind))
def test_each_kind_of_segment_says_whether_something_is_held(kind: SegmentKind) -> None:
    """Of a plan of that segment alone, without an item and with one that was in the cup before."""
    (empty,) = (Segment(kind, 0.0, 1.0, STRAIGHT, None),)
    whole = Plan(pick()[0].query, "", "", 0, (empty,), resting(0.0, 1.0), (), pick()[0].grasp)
    carried = replace(whole, segments=(replace(empty, held=CRAYOLA),))
    found, loaded = ([r.what for r in check_structure(plan, pick()[1])] for plan in (whole, carried))
    carries = kind in (SegmentKind.LIFT, SegmentKind.TRANSFER, SegmentKind.INSERT, SegmentKind.PLACE)
    assert found == [FORGOTTEN] * (carries or kind is SegmentKind.CONTACT)
    comes_empty = kind in (SegmentKind.TRANSIT, SegmentKind.DEPART)
    loaded.remove("not in the cup")
    takes = [FORGOTTEN, "not let go"] * (kind is SegmentKind.CONTACT)
    assert loaded == ["wrong held item"] * comes_empty + takes


def test_names_are_of_items_and_bodies_of_the_scene_and_of_what_is_in_the_cup() -> None:
    plan, scene = pick()
    body = scene.standing[0][0].name
    contact = Segment(SegmentKind.CONTACT, 0.0, 1.0, STRAIGHT, None)
    held = replace(
        scene.without("dove_beauty_bar"), held=HeldItem("dove_beauty_bar", scene.items[1].item, pose())
    )
    for there, names in ((scene, (CRAYOLA, body, "dove_beauty_bar")), (held, ("dove_beauty_bar",))):
        for name in (*names, "elephant"):
            touching = replace(plan, segments=(replace(contact, touching=(name,)),))
            assert ("unknown name" in whats(check_structure(touching, there))) is (name == "elephant")
    for name, is_known in (("dove_beauty_bar", True), ("elephant", False)):
        assert plan.grasp is not None
        other = replace(plan, grasp=replace(plan.grasp, item=name))
        for there in (scene, held):
            assert ("unknown item" in whats(check_structure(other, there))) is not is_known


# The grasp


@pytest.mark.parametrize("yaw", [0.0, 1.2])
@pytest.mark.parametrize(
    ("axis", "kind"),
    [
        ((1.0, 0.0, 0.0), "frontal"), ((0.8, 0.6, 0.0), "frontal"), ((0.8, 0.0, -0.6), "frontal"),
        ((0.0, 0.0, -1.0), "top-down"), ((0.6, 0.0, -0.8), "top-down"), ((0.0, 0.6, -0.8), "top-down"),
        ((0.0, 1.0, 0.0), "side"), ((0.0, -1.0, 0.0), "side"), ((0.6, -0.8, 0.0), "side"),
        ((0.0, -0.8, -0.6), "side"), ((0.0, 0.6, 0.8), "side"), ((-0.8, 0.6, 0.0), "side"),
    ],
)  # fmt: skip
def test_a_grasp_is_of_the_kind_of_the_side_from_which_the_cup_comes(
    axis: tuple[float, float, float], kind: str, yaw: float
) -> None:
    """By the axes of the bin, x into it and z up, wherever the pod stands."""
    turned = replace(pick()[1], T_world_pod=pose((0.1, 0.2, 0.0), rpy=(0.0, 0.0, yaw)))
    target = turned.find(CRAYOLA)
    T_place = turned.T_world_place(turned.cell.places[target.location])
    in_item = (inverse(target.T_world_item) @ T_place)[:3, :3] @ np.array(axis)
    for stated in ("frontal", "top-down", "side"):
        grasp = replace(cup_at((0.0, 0.0, 0.0), in_item), kind=stated)
        assert whats(check_kind(turned, grasp)) == ["wrong kind"] * (stated != kind)


@pytest.mark.parametrize("off", [-2e-9, 0.0, 2e-9])
def test_between_two_axes_a_grasp_may_go_by_either_name(off: float) -> None:
    """A bottle on its side, taken half from aside and half from above: rounding says which is nearer."""
    there = pick()[1]
    target = there.find(CRAYOLA)
    T_place = there.T_world_place(there.cell.places[target.location])
    axis = np.array([0.0, np.sin(np.pi / 4 + off), -np.cos(np.pi / 4 + off)])
    in_item = (inverse(target.T_world_item) @ T_place)[:3, :3] @ axis
    for stated in ("frontal", "top-down", "side"):
        grasp = replace(cup_at((0.0, 0.0, 0.0), in_item), kind=stated)
        assert whats(check_kind(there, grasp)) == ["wrong kind"] * (stated == "frontal")


def item_of(*size: float) -> Item:
    shape = Shape(ShapeKind.BOX, size)
    item = replace(cell().item(CRAYOLA), shape=shape, seal_inset=0.0, areas={})
    return replace(item, seals=dict.fromkeys(shape.face_names, 1.0))


def cup_at(p: tuple[float, float, float], axis: Array) -> Grasp:
    """A cup at a point of an item, of whose frame only the axis is stated."""
    T = pose(p)
    T[:3, 2] = axis
    grasp = pick()[0].grasp
    assert grasp is not None
    return replace(grasp, T_item_tip=T)


DOWN = np.array([0.0, 0.0, -1.0])


def test_a_tip_may_be_a_millimetre_off_the_surface() -> None:
    thin = item_of(0.2, 0.2, 0.002)  # its surface is 1 mm from its middle
    for z, problem in ((0.002, []), (0.00201, ["grasp off the surface"])):
        assert whats(_seal(cup_at((0.0, 0.0, z), DOWN), thin, TOOL, PoseNoise())) == problem


def test_a_cup_may_be_as_askew_as_it_takes_up_and_a_degree() -> None:
    least = float(np.cos(np.radians(1.0) + TOOL.cup.tilt))
    for c, problem in ((least, []), (least - 1e-12, ["cup not square on the face"])):
        axis = np.array([np.sqrt(1.0 - c * c), 0.0, -c])
        assert (
            whats(_seal(cup_at((0.0, 0.0, 0.05), axis), item_of(0.2, 0.2, 0.1), TOOL, PoseNoise())) == problem
        )


@pytest.mark.parametrize(("beyond", "is_refused"), [(0.0, False), (0.9e-6, False), (1.1e-6, True)])
def test_a_cup_may_be_a_micrometre_beyond_the_edge(beyond: float, is_refused: bool) -> None:
    grasp = cup_at((0.1 - TOOL.cup.radius + beyond, 0.0, 0.05), DOWN)
    assert (
        whats(_seal(grasp, item_of(0.2, 0.2, 0.1), TOOL, PoseNoise())) == ["cup beyond the edge"] * is_refused
    )


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_cup_may_be_just_before_its_place_or_pressed_in_and_just_aside(noise: float) -> None:
    scene = replace(pick()[1], noise=PoseNoise(noise, 0.0))
    grasp = replace(cup_at((0.0, 0.0, 0.0), np.array([0.0, 0.0, 1.0])), T_item_tip=np.eye(4))
    most = scene.noise.bound(scene.item(CRAYOLA)) + TOOL.cup.stroke
    for xyz, is_off in (
        ((0.0, 0.0, -0.001), False), ((0.0, 0.0, -0.00101), True), ((0.0, 0.0, most), False),
        ((0.0, 0.0, most + 1e-9), True), ((0.002, 0.0, 0.0), False), ((0.0, -0.002, 0.0), False),
        ((0.00201, 0.0, 0.0), True), ((0.0015, 0.0015, 0.0), True),
    ):  # fmt: skip
        found = whats(_as_grasped(scene, grasp, pose(xyz), "contact"))
        assert found == ["misses the item"] * is_off


def test_a_miss_is_told_with_how_far_and_how_turned() -> None:
    scene = pick()[1]
    grasp = replace(cup_at((0.0, 0.0, 0.0), np.array([0.0, 0.0, 1.0])), T_item_tip=np.eye(4))
    (reason,) = _as_grasped(scene, grasp, pose((0.003, 0.004, 0.0), rpy=(0.0, 0.0, np.radians(12.0))), "")
    assert reason.detail == "5.0 mm aside, turned 12.0 deg"
    (reason,) = _as_grasped(scene, grasp, pose((0.0, 0.0, 0.5)), "")
    assert reason.detail.startswith("pressed on by 500.0 mm, expected 0..")


def test_a_grasp_is_at_a_pose() -> None:
    """Turned as it may be, but neither mirrored, scaled nor sheared."""
    plan, scene = pick()
    assert plan.grasp is not None
    T = plan.grasp.T_item_tip
    for change, problem in (
        (np.eye(4), []), (np.diag([1.0, 1.0, -1.0, 1.0]), ["not a pose"]),
        (np.diag([1.01, 1.0, 1.0, 1.0]), ["not a pose"]), (np.diag([1.0, 1.0, 1.0, 2.0]), ["not a pose"]),
        (np.eye(4) + 0.01 * np.outer(np.eye(4)[0], np.eye(4)[1]), ["not a pose"]),
    ):  # fmt: skip
        found = check_structure(replace(plan, grasp=replace(plan.grasp, T_item_tip=T @ change)), scene)
        assert whats(found) == problem


def test_what_is_let_go_is_let_go_in_a_place() -> None:
    plan, scene = pick()
    T_tip_item = pose_in_tool(plan, scene)
    assert T_tip_item is not None
    assert check_release(plan, scene, T_tip_item) == ()
    bare = replace(scene, cell=replace(scene.cell, tote=None))  # nothing is open above
    assert whats(check_release(plan, bare, T_tip_item)) == ["released outside of every place"]


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_a_carried_item_may_lie_in_a_neighbour_as_deep_as_both_poses_and_a_touch_explain(
    noise: float,
) -> None:
    """And 1.5 mm more for the lines; what is clear of it may come as near as a turn explains."""
    other = place("dove_beauty_bar", (0.0, 0.0, 0.0), "bin_A")
    scene = make_scene(*pick()[1].items, other, noise=PoseNoise(noise, 0.0))
    part, fixture = (
        SimpleNamespace(name=name, is_held=held) for name, held in ((CRAYOLA, True), (other.id, False))
    )
    pair = _Pair(scene, None, 0, part, fixture, None)  # type: ignore[arg-type]
    assert pair._explained(-1.0) == pytest.approx(0.0015 + 2 * noise + 0.0015)
    assert pair._explained(-0.001) == pytest.approx(0.001 + 0.0015)
    assert pair._explained(0.01) == pytest.approx(1e-4)
