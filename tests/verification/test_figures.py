"""Every figure that the verifier holds a plan against: just within is accepted, just beyond is refused."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Reason
from pickcli.geometry import Array, pose
from pickcli.grasping.lip_coverage import bearing_share
from pickcli.motion.event import Anchor, AnchorKind
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.verification.event_check import check_io
from pickcli.verification.grasp_check import _face_at, _meets, _seal, _share_at
from pickcli.verification.joint_limit_check import check_limits
from pickcli.verification.release_check import _dropped, _off_floor
from pickcli.verification.structure_check import check_structure
from support.handmade_plans import CRAYOLA, SEAL_TIME, bound, cell, make_scene, pick
from support.plan_mutations import moved_event, segment, with_event, with_grasp, with_segment
from support.tool_states import STRAIGHT

TOOL = cell().robot.tool
LIMITS = cell().robot.limits
N = len(cell().robot.joint_names)
J = 7  # the joint that moves in a plan of one joint
EMPTY = make_scene()


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


def one_move(distance: float, seconds: float, start: float = 0.0) -> Plan:
    """One joint from rest to rest by one quintic: 15/8 d/T, 10/sqrt(3) d/T^2 and 60 d/T^3 at their worst."""
    p = np.zeros((2, N))
    p[:, 0] = 0.2  # the rail stands within its limits
    p[:, J] = start, start + distance
    still = np.zeros((2, N))
    trajectory = Trajectory(cell().robot.joint_names, np.array([0.0, seconds]), p, still, still)
    segments = (Segment(SegmentKind.TRANSIT, 0.0, seconds, STRAIGHT, None),)
    return bound(Plan("move", "", "", 0, segments, trajectory, ()), EMPTY)


# Limits


@pytest.mark.parametrize("derivative", [1, 2, 3])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_limit_may_be_reached_and_not_passed(derivative: int, sign: float) -> None:
    name = ("velocity", "acceleration", "jerk")[derivative - 1]
    limit = getattr(LIMITS, name)[J]
    peak = (15 / 8, 10 / np.sqrt(3), 60.0)[derivative - 1]
    for ratio, is_over in ((1.0 + 0.5e-6, False), (1.0 + 1.5e-6, True)):
        found = check_limits(one_move(sign * ratio * limit / peak, 1.0), EMPTY)
        worst = (found.velocity, found.acceleration, found.jerk)[derivative - 1]
        assert worst == pytest.approx(ratio, abs=1e-8)
        assert (f"{name} limit" in whats(found.reasons)) is is_over


def test_the_speed_of_a_cell_scales_velocity_and_acceleration_and_not_jerk() -> None:
    plan = one_move(0.5, 2.0)
    slow = replace(EMPTY, cell=replace(cell(), speed_scale=0.5))
    full, half = check_limits(plan, EMPTY), check_limits(plan, slow)
    assert (half.velocity, half.acceleration) == pytest.approx((2 * full.velocity, 2 * full.acceleration))
    assert half.jerk == full.jerk


@pytest.mark.parametrize(("beyond", "is_over"), [(-1e-3, False), (0.9e-6, False), (1.1e-6, True)])
@pytest.mark.parametrize("side", ["upper", "lower"])
def test_joints_stay_within_their_limits(side: str, beyond: float, is_over: bool) -> None:
    outwards = 1.0 if side == "upper" else -1.0
    edge = getattr(LIMITS, side)[J] + outwards * beyond
    for start, distance in ((edge - outwards * 0.5, outwards * 0.5), (edge, -outwards * 0.5)):
        found = check_limits(one_move(distance, 3.0, start), EMPTY)
        assert ("joint limit" in whats(found.reasons)) is is_over


@pytest.mark.parametrize("name", ["velocities", "accelerations"])
@pytest.mark.parametrize("end", [0, -1])
def test_a_plan_begins_and_ends_at_rest(name: str, end: int) -> None:
    plan = one_move(0.5, 3.0)
    for value, is_over in ((0.9e-9, False), (-1.1e-9, True), (1.1e-9, True)):
        values = getattr(plan.trajectory, name).copy()
        values[end, 3] = value
        moving = replace(plan, trajectory=replace(plan.trajectory, **{name: values}))
        found = [r for r in check_limits(moving, EMPTY).reasons if r.what == "not at rest"]
        assert [r.where for r in found] == (["start" if end == 0 else "end"] if is_over else [])


# Structure


def times_of(plan: Plan, times: Array) -> Plan:
    return replace(plan, trajectory=replace(plan.trajectory, times=times))


def test_a_plan_takes_at_most_five_minutes() -> None:
    assert check_structure(one_move(0.5, 300.0), EMPTY) == ()
    assert "too long" in whats(check_structure(one_move(0.5, 300.1), EMPTY))


def test_points_are_a_nanosecond_apart_at_least() -> None:
    plan = one_move(0.0, 1.0)
    t = plan.trajectory
    three = replace(t, **{n: getattr(t, n)[[0, 0, 1]] for n in ("positions", "velocities", "accelerations")})
    for step, is_refused in ((1.1e-9, False), (0.9e-9, True)):
        reasons = check_structure(
            replace(plan, trajectory=replace(three, times=np.array([0.0, step, 1.0]))), EMPTY
        )
        assert ("time stamps" in whats(reasons)) is is_refused


@pytest.mark.parametrize("field", ["positions", "velocities", "accelerations"])
def test_numbers_of_a_plan_are_up_to_a_million(field: str) -> None:
    plan = one_move(0.5, 3.0)
    for value, is_refused in ((1e6, False), (-1e6, False), (1.1e6, True), (-1.1e6, True)):
        values = getattr(plan.trajectory, field).copy()
        values[1, 2] = value
        reasons = check_structure(
            replace(plan, trajectory=replace(plan.trajectory, **{field: values})), EMPTY
        )
        assert whats(reasons) == (["not a plan's number"] if is_refused else [])


def test_times_begin_at_nothing_and_increase() -> None:
    plan = one_move(0.5, 3.0)
    assert whats(check_structure(times_of(plan, np.array([0.1, 3.0])), EMPTY)) == ["time stamps"]
    assert whats(check_structure(times_of(plan, np.array([0.0, 0.0])), EMPTY)) == ["time stamps"]
    assert whats(check_structure(times_of(plan, np.array([0.0, np.nan])), EMPTY)) == ["not finite"]
    assert whats(check_structure(times_of(plan, np.array([0.0, 1.0, 3.0])), EMPTY)) == ["shape"]
    one = replace(plan.trajectory, **{
        n: getattr(plan.trajectory, n)[:1] for n in ("times", "positions", "velocities", "accelerations")
    })  # fmt: skip
    assert whats(check_structure(replace(plan, trajectory=one), EMPTY)) == ["shape"]


@pytest.mark.parametrize(("off", "is_refused"), [(0.9e-9, False), (1.1e-9, True), (-1.1e-9, True)])
def test_segments_follow_each_other_within_a_nanosecond(off: float, is_refused: bool) -> None:
    plan = one_move(0.5, 3.0)
    (whole,) = plan.segments
    for segments in (
        (replace(whole, t_start=off),),
        (replace(whole, t_end=3.0 + off),),
        (replace(whole, t_end=1.0), replace(whole, t_start=1.0 + off)),
    ):
        reasons = check_structure(replace(plan, segments=segments), EMPTY)
        assert ("segments not contiguous" in whats(reasons)) is is_refused
    twice = (replace(whole, t_end=0.0), whole)
    assert "segments not contiguous" in whats(check_structure(replace(plan, segments=twice), EMPTY))


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (with_segment(SegmentKind.CONTACT, held=CRAYOLA), "held item forgotten"),
        (with_segment(SegmentKind.APPROACH, held=CRAYOLA), "held item forgotten"),
        (with_segment(SegmentKind.TRANSIT, held=CRAYOLA), "wrong held item"),
        (with_segment(SegmentKind.DEPART, held=CRAYOLA), "wrong held item"),
        (with_segment(SegmentKind.PLACE, held=None), "held item forgotten"),
        (with_segment(SegmentKind.RETREAT, held=None), "held item forgotten"),
        (with_segment(SegmentKind.CONTACT, kind=SegmentKind.APPROACH), "held without contact"),
        (lambda p: replace(p, grasp=None), "wrong held item"),
        (with_grasp(item="dove_beauty_bar"), "wrong held item"),
    ],
)
def test_an_item_is_held_from_the_contact_to_the_release(change: object, what: str) -> None:
    plan, scene = pick()
    assert check_structure(plan, scene) == ()
    assert what in whats(check_structure(change(plan), scene))  # type: ignore[operator]


# The grasp


def item_of(shape: Shape, **changes: object) -> Item:
    item = replace(cell().item(CRAYOLA), shape=shape, seal_inset=0.0, areas={})
    return replace(item, seals=dict.fromkeys(shape.face_names, 1.0), **changes)  # type: ignore[arg-type]


BOX = item_of(Shape(ShapeKind.BOX, (0.2, 0.16, 0.12)))
CAN = item_of(Shape(ShapeKind.CYLINDER, (0.05, 0.2)))
BALL = item_of(Shape(ShapeKind.SPHERE, (0.06,)))


@pytest.mark.parametrize(
    ("item", "p", "face", "normal", "room"),
    [
        (BOX, (0.1, 0.03, 0.01), "+x", (1, 0, 0), 0.05),
        (BOX, (-0.1, 0.0, -0.05), "-x", (-1, 0, 0), 0.01),
        (BOX, (0.09, 0.08, 0.0), "+y", (0, 1, 0), 0.01),
        (BOX, (0.0, -0.08, 0.0), "-y", (0, -1, 0), 0.06),
        (BOX, (0.07, 0.0, 0.06), "+z", (0, 0, 1), 0.03),
        (BOX, (0.0, 0.0, -0.06), "-z", (0, 0, -1), 0.08),
        (CAN, (0.03, 0.0, 0.1), "+z", (0, 0, 1), 0.02),
        (CAN, (0.0, 0.04, -0.1), "-z", (0, 0, -1), 0.01),
        (CAN, (0.03, 0.04, 0.07), "mantle", (0.6, 0.8, 0), 0.03),
        (CAN, (-0.05, 0.0, -0.06), "mantle", (-1, 0, 0), 0.04),
        (BALL, (0.036, 0.0, 0.048), "sphere", (0.6, 0, 0.8), np.inf),
    ],
)
@pytest.mark.parametrize("off", [0.0, 0.004, -0.004])
def test_a_point_belongs_to_the_face_it_is_nearest_to(
    item: Item, p: tuple[float, ...], face: str, normal: tuple[float, ...], room: float, off: float
) -> None:
    found = _face_at(item, np.array(p) + off * np.array(normal))
    assert found[0] == face
    assert found[1] == pytest.approx(off, abs=1e-12)
    np.testing.assert_allclose(found[2], normal, atol=1e-12)
    assert found[3] == pytest.approx(room)


def grasp_on(p: tuple[float, ...], axis: tuple[float, ...], tilt: float = 0.0) -> Grasp:
    """A cup at a point, its axis turned away from the given one."""
    z = np.array(axis, dtype=float)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z) / np.linalg.norm(np.cross(helper, z))
    T = pose(p, R=np.column_stack([x, np.cross(z, x), z])) @ pose(rpy=(tilt, 0.0, 0.0))
    grasp = pick()[0].grasp
    assert grasp is not None
    return replace(grasp, T_item_tip=T)


@pytest.mark.parametrize(
    ("item", "p", "axis"),
    [(BOX, (0.1, 0.0, 0.0), (-1, 0, 0)), (CAN, (0.03, 0.04, 0.0), (-0.6, -0.8, 0)),
     (BALL, (0.0, 0.0, -0.06), (0, 0, 1))],
)  # fmt: skip
def test_a_cup_is_on_the_surface_and_square_on_it(
    item: Item, p: tuple[float, ...], axis: tuple[float, ...]
) -> None:
    for off, problem in ((0.0009, []), (-0.0009, []), (0.0011, ["grasp off the surface"]),
                         (-0.0011, ["grasp off the surface"])):  # fmt: skip
        at = tuple(np.array(p) - off * np.array(axis))
        assert whats(_seal(grasp_on(at, axis), item, TOOL, PoseNoise())) == problem
    most = TOOL.cup.tilt + np.radians(1.0)
    askew = ["cup not square on the face"]
    for tilt, problem in ((1e-4 - most, []), (most - 1e-4, []), (most + 1e-4, askew), (-most - 1e-4, askew)):
        assert whats(_seal(grasp_on(p, axis, tilt), item, TOOL, PoseNoise())) == problem
    inwards = tuple(-np.array(axis))
    assert "cup not square on the face" in whats(_seal(grasp_on(p, inwards), item, TOOL, PoseNoise()))


@pytest.mark.parametrize("inset", [0.0, 0.004])
def test_the_whole_cup_is_inside_its_face(inset: float) -> None:
    for item, along, axis in (
        (BOX, lambda s: (0.1, 0.08 - s, 0.0), (-1, 0, 0)),
        (BOX, lambda s: (0.1, 0.0, s - 0.06), (-1, 0, 0)),
        (CAN, lambda s: (0.05, 0.0, 0.1 - s), (-1, 0, 0)),
        (CAN, lambda s: (0.05 - s, 0.0, 0.1), (0, 0, -1)),
    ):
        item = replace(item, seal_inset=inset)
        least = TOOL.cup.radius + inset
        assert whats(_seal(grasp_on(along(least), axis), item, TOOL, PoseNoise())) == []
        assert whats(_seal(grasp_on(along(least - 1e-4), axis), item, TOOL, PoseNoise())) == [
            "cup beyond the edge"
        ]


def test_a_cup_is_on_a_face_and_on_the_part_of_it_that_seals() -> None:
    grasp = grasp_on((0.1, 0.0, 0.0), (-1, 0, 0))
    for share, problem in ((0.1, []), (0.0, ["cup not on a face that seals"])):
        item = replace(BOX, seals={**BOX.seals, "+x": share})
        assert whats(_seal(grasp, item, TOOL, PoseNoise())) == problem
    beyond = ["cup beyond the edge"]
    for least, greatest, problem in (
        (-0.015, 0.015, []), (-0.0149, 0.05, beyond), (-0.05, 0.0149, beyond),
    ):  # fmt: skip
        for axis in "yz":
            item = replace(BOX, areas={"+x": {axis: (least, greatest)}})
            assert whats(_seal(grasp, item, TOOL, PoseNoise())) == problem


@pytest.mark.parametrize(("half", "error", "problem"), [
    (0.0125, 0.0, []), (0.0125, 0.002, []), (0.0125, 0.004, ["cup beyond the edge"]),
    (0.01, 0.0, ["cup beyond the edge"]),
])  # fmt: skip
def test_a_lip_stands_over_the_edges_of_a_narrow_area_as_far_as_the_pump_keeps_enough(
    half: float, error: float, problem: list[str]
) -> None:
    """25 mm keep 0.37 under 30 mm, 0.30 at 2 mm, under 0.2 at 4 mm; 20 mm keep 0.1."""
    item = replace(BOX, areas={"+x": {"z": (-half, half)}})
    grasp = grasp_on((0.1, 0.0, 0.0), (-1, 0, 0))
    assert whats(_seal(grasp, item, TOOL, PoseNoise(error, 0.0))) == problem


@given(
    width=st.floats(0.02, 0.06),
    x=st.floats(-0.08, 0.08),
    y=st.floats(-0.012, 0.012),
    pressed=st.floats(0.0, 0.005),
    error=st.floats(0.0, 0.004),
)
def test_planner_and_verifier_let_a_cup_bear_the_same_wherever_it_is_pressed(
    width: float, x: float, y: float, pressed: float, error: float
) -> None:
    """The planner describes holds by where the pressed lip is, the verifier by the grasp on the face."""
    item = replace(BOX, shape=Shape(ShapeKind.BOX, (0.2, width, 0.02)), areas={})
    noise, grasp = PoseNoise(error, np.radians(1.0)), grasp_on((x, y, 0.01), (0, 0, -1))
    planned = bearing_share(item, "+z", np.array([x, y, 0.01 - pressed]), TOOL.cup, noise)
    assert _share_at(item, grasp, TOOL, noise) == pytest.approx(planned, rel=1e-9)


def shifted(xyz: tuple[float, ...], turn: float = 0.0) -> list[str]:
    """What is wrong with the contact of the pick if its item stands elsewhere, in the frame of the tool."""
    plan, scene = pick()
    assert plan.grasp is not None
    T = plan.grasp.T_item_tip @ pose(xyz, rpy=(0.0, turn, 0.0)) @ np.linalg.inv(plan.grasp.T_item_tip)
    target = scene.find(CRAYOLA)
    moved = scene.moved(replace(target, T_world_item=target.T_world_item @ T))
    t = plan.segments[segment(plan, SegmentKind.CONTACT)].t_end
    return whats(_meets(plan, moved, plan.grasp, t, "contact"))


def test_a_cup_meets_its_item_where_the_grasp_says() -> None:
    """It is pressed on by 2 mm as planned: up to the stroke of its bellows, and not before the surface."""
    assert shifted((0.0, 0.0, 0.0)) == []
    for z, is_off in ((0.0029, False), (0.0031, True), (-0.0059, False), (-0.0061, True)):
        assert (shifted((0.0, 0.0, z)) == ["misses the item"]) is is_off
    for aside, is_off in ((0.0019, False), (0.0021, True), (-0.0019, False), (-0.0021, True)):
        assert (shifted((aside, 0.0, 0.0)) == ["misses the item"]) is is_off
        assert (shifted((0.0, aside, 0.0)) == ["misses the item"]) is is_off
    for degrees, is_off in ((0.98, False), (1.02, True), (-1.02, True)):
        assert (shifted((0.0, 0.0, 0.0), np.radians(degrees)) == ["misses the item"]) is is_off


def test_a_cup_may_be_pressed_on_deeper_by_what_the_pose_may_be_off() -> None:
    plan, scene = pick()
    noisy = replace(scene, noise=PoseNoise(0.003, 0.0))
    target = scene.find(CRAYOLA)
    t = plan.segments[segment(plan, SegmentKind.CONTACT)].t_end
    assert plan.grasp is not None
    for deeper, is_off in ((0.0089, False), (0.0091, True)):
        T = plan.grasp.T_item_tip @ pose((0, 0, -deeper)) @ np.linalg.inv(plan.grasp.T_item_tip)
        moved = noisy.moved(replace(target, T_world_item=target.T_world_item @ T))
        assert (whats(_meets(plan, moved, plan.grasp, t, "")) == ["misses the item"]) is is_off


# Events


@pytest.mark.parametrize("i", range(5))
@pytest.mark.parametrize(("by", "is_refused"), [(0.9e-6, False), (1.2e-6, True), (-1.2e-6, True)])
def test_triggers_and_anchors_are_exact_to_a_microsecond(i: int, by: float, is_refused: bool) -> None:
    plan, scene = pick()
    assert check_io(plan, scene) == ()
    trigger, anchor = with_event(i, 0.0, by)(plan), with_event(i, by, by)(plan)
    assert ("wrong trigger" in whats(check_io(trigger, scene))) is is_refused
    assert ("wrong anchor time" in whats(check_io(anchor, scene))) is is_refused


def test_a_trigger_lies_within_the_motion() -> None:
    plan, scene = pick()
    event, end = plan.events[4], plan.trajectory.duration
    assert event.t_trigger is not None
    for t, is_refused in ((end + 0.9e-6, False), (end + 1.2e-6, True)):
        assert (
            "trigger outside the motion" in whats(check_io(moved_event(4, t - event.t_trigger)(plan), scene))
        ) is is_refused
    first = plan.events[0]
    assert first.t_trigger is not None
    for t, is_refused in ((-0.9e-6, False), (-1.2e-6, True)):
        reasons = check_io(moved_event(0, t - first.t_trigger)(plan), scene)
        assert ("trigger outside the motion" in whats(reasons)) is is_refused


def test_an_anchor_by_its_way_is_exact_to_half_a_millimetre() -> None:
    plan, scene = pick()
    k = segment(plan, SegmentKind.CONTACT)
    way = 0.014  # of the contact: from 12 mm before the item to 2 mm into the bellows
    for off, is_refused in ((0.0, False), (0.0004, False), (0.0006, True), (-0.0006, True)):
        anchored = with_event(1, anchor=Anchor(AnchorKind.ARC_LENGTH, k, way + off))(plan)
        assert ("wrong anchor time" in whats(check_io(anchored, scene))) is is_refused
    back = with_event(1, anchor=Anchor(AnchorKind.ARC_LENGTH, k + 1, 0.0))(plan)
    assert check_io(back, scene) == ()


def test_an_anchor_may_be_a_segment_s_start() -> None:
    plan, scene = pick()
    k = segment(plan, SegmentKind.CONTACT)
    lift = with_event(1, anchor=Anchor(AnchorKind.SEGMENT_START, k + 1, -SEAL_TIME))
    assert check_io(lift(plan), scene) == ()
    wrong = with_event(1, anchor=Anchor(AnchorKind.SEGMENT_START, k))(plan)
    assert whats(check_io(wrong, scene)) == ["wrong anchor time"]


# Where it is let go


def placed() -> tuple[Scene, Item]:
    return make_scene(noise=PoseNoise(0.002, 0.0)), BOX


def put(item: Item, where: str, T_world_item: Array) -> PlacedItem:
    return PlacedItem("one", item, where, T_world_item)


@given(st.sampled_from([0, 1]), st.sampled_from([-1.0, 1.0]))
def test_an_item_is_let_go_within_the_walls_of_the_tote(axis: int, side: float) -> None:
    scene, item = placed()
    half, size = np.array(cell().places["tote"].room.size[:2]) / 2, np.array(BOX.shape.size)
    for beyond, problem in ((-1e-4, []), (1e-4, ["released beyond the tote's walls"])):
        p = np.array([0.0, 0.0, 0.1])
        p[axis] = side * (half[axis] - size[axis] / 2 + beyond)
        T = cell().places[TOTE].T_carrier_place @ pose(p)
        assert whats(_dropped(scene, cell().places[TOTE], put(item, TOTE, T))) == problem


def test_an_item_falls_at_most_30_cm_into_the_tote() -> None:
    scene, item = placed()
    for low, problem in ((0.2999, []), (0.3001, ["released too high"])):
        T = cell().places["tote"].T_carrier_place @ pose((0.0, 0.0, low + 0.06))
        assert whats(_dropped(scene, cell().places[TOTE], put(item, TOTE, T))) == problem


def test_an_item_is_set_down_in_a_bin_within_2_cm_and_its_noise() -> None:
    scene, item = placed()
    cell_bin = cell().pod.bins["bin_B"]
    for x in (cell_bin.room.floor_flat_from + 0.15, 0.1):
        floor = np.interp(
            x + 0.1,
            (cell_bin.room.slope_from, cell_bin.room.floor_flat_from),
            (cell_bin.room.floor_front, cell_bin.room.floor_back),
        )
        for over, problem in ((0.0219, []), (0.0221, ["released too high"])):
            T = scene.T_world_place(cell_bin) @ pose((x, 0.0, float(floor) + 0.06 + over))
            assert whats(_off_floor(scene, cell_bin, put(item, "bin_B", T))) == problem
    for front, problem in ((1e-4, []), (-1e-4, ["released beyond the bin's mouth"])):
        T = scene.T_world_place(cell_bin) @ pose((0.1 + front, 0.0, cell_bin.room.floor_back + 0.06))
        assert whats(_off_floor(scene, cell_bin, put(item, "bin_B", T))) == problem
