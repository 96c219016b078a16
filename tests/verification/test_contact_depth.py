"""Who may touch something, when that is at rest, and how deep: a block at a plate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import ToolState
from pickcli.geometry import inverse, pose
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.contact_check import _Pair
from pickcli.verification.contact_exemptions import ends_at_rest, may_touch, releases
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.fcl_solids import Solid, cover
from pickcli.verification.forward_kinematics import T_lance_last
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.recovery_check import check_opening
from pickcli.verification.static_solids import PlanFixtures
from support.handmade_plans import CRAYOLA, cell, make_scene, place
from support.rail_motions import rail, states_of
from support.tool_states import DOWN, STRAIGHT

CONTACT, LIFT, RETREAT = SegmentKind.CONTACT, SegmentKind.LIFT, SegmentKind.RETREAT
PLACE, DEPART, TRANSIT = SegmentKind.PLACE, SegmentKind.DEPART, SegmentKind.TRANSIT
SLOWLY, BACKWARDS = RecoveryLevel.SLOWLY, RecoveryLevel.BACKWARDS
CARRYING = (LIFT, PLACE, SegmentKind.TRANSFER, SegmentKind.INSERT)


def plan_of(*kinds: SegmentKind, level: RecoveryLevel | None = None, held: Sequence[bool] = ()) -> Plan:
    """Segments of some kinds; without further word the item is held where the kind says so."""
    holds = held or [kind in CARRYING for kind in kinds]
    parts = tuple(
        Segment(kind, float(k), k + 1.0, STRAIGHT, CRAYOLA if is_held else None)
        for k, (kind, is_held) in enumerate(zip(kinds, holds, strict=True))
    )
    return Plan("pick", "", "", 0, parts, rail(0.0).trajectory, (), recovery=level)


def touching(*kinds: SegmentKind, level: RecoveryLevel | None = None, held: Sequence[bool] = ()) -> list[int]:
    """Segments that may touch something."""
    plan = plan_of(*kinds, level=level, held=held)
    return [k for k in range(len(kinds)) if may_touch(plan, k)]


# Who may touch


def test_an_item_is_let_go_where_it_is_held_and_then_not() -> None:
    for held, ends in (
        ((True, False), (0,)), ((True, True, False), (1,)), ((False, True), ()), ((True,), ()),
        ((True, False, True, False), (0, 2)), ((False, True, True, False, False), (2,)), ((True, True), ()),
    ):  # fmt: skip
        assert releases(plan_of(*[RETREAT] * len(held), held=held)) == ends


@pytest.mark.parametrize("level", [None, *RecoveryLevel])
def test_a_pick_touches_from_the_contact_to_the_lift_and_from_the_place_to_the_depart(
    level: RecoveryLevel | None,
) -> None:
    whole = TRANSIT, CONTACT, LIFT, LIFT, RETREAT, PLACE, PLACE, DEPART, DEPART, TRANSIT
    assert touching(*whole, level=level, held=[2 <= k <= 6 for k in range(10)]) == [1, 2, 6, 7]
    late = PLACE, TRANSIT, DEPART, TRANSIT
    assert touching(*late, level=level) == [0]
    still_held = touching(PLACE, PLACE, level=level)
    assert still_held == ([] if level is None else [0, 1])  # on, or back along it
    assert touching(PLACE, PLACE, level=level, held=(False, False)) == []


def test_coarse_motions_and_ways_in_and_out_touch_nothing() -> None:
    touch = CONTACT, LIFT, PLACE, DEPART
    for kind in [kind for kind in SegmentKind if kind not in touch]:
        for held in (True, False):
            found = touching(kind, PLACE, kind, level=SLOWLY, held=(held, True, held))
            assert found == [1] * (not held)
            assert touching(kind, CONTACT, kind, level=SLOWLY, held=(held, False, held)) == [1]


def test_a_lift_touches_after_a_contact_and_at_the_ends_of_a_way_out() -> None:
    lifts = LIFT, LIFT, LIFT, LIFT
    assert touching(*lifts) == []
    assert touching(*lifts, level=SLOWLY) == [0, 3]
    assert touching(LIFT, RETREAT, CONTACT) == [2]
    assert touching(CONTACT, LIFT, LIFT, CONTACT) == [0, 1, 3]
    assert touching(RETREAT, LIFT, RETREAT, level=SLOWLY) == []


def test_a_depart_touches_empty_after_a_release_and_at_the_beginning_of_a_way_out() -> None:
    departs = DEPART, DEPART, DEPART
    assert touching(*departs) == []
    assert touching(*departs, level=SLOWLY) == [0]
    assert touching(*departs, level=SLOWLY, held=(True, True, True)) == []
    assert touching(RETREAT, DEPART, level=SLOWLY) == []
    assert touching(RETREAT, DEPART, DEPART, held=(True, False, False)) == [1]


def test_what_is_touched_is_at_rest_at_the_end_of_contact_and_place_and_of_a_lift_back() -> None:
    for level in (None, *RecoveryLevel):
        plan = plan_of(*SegmentKind, level=level)
        at_the_end = {segment.kind for k, segment in enumerate(plan.segments) if ends_at_rest(plan, k)}
        assert at_the_end == ({CONTACT, PLACE, LIFT} if level is BACKWARDS else {CONTACT, PLACE})


# How deep

BLOCK = Shape(ShapeKind.BOX, (0.02, 0.02, 0.02))
PLATE = Shape(ShapeKind.BOX, (0.3, 0.3, 0.1))
STROKE = cell().robot.tool.cup.stroke


def part(is_cup: bool = False, is_held: bool = False) -> Part:
    n = len(cell().robot.joint_names)
    return Part(
        "cup", 0, np.eye(4), BLOCK, Solid(BLOCK), cover(BLOCK), np.zeros(n), is_cup=is_cup, is_held=is_held
    )


def plate(name: str = "plate", slack: float = 0.0) -> Fixture:
    """A plate whose upper side is at z = 0."""
    T, solid = pose((0.0, 0.0, -0.05)), Solid(PLATE)
    solid.place(T)
    return Fixture(name, T, PLATE, solid, slack)


def pair(
    scene: Scene, kind: SegmentKind, k: int, moving: Part, depths: Sequence[float], fixture: Fixture,
    tool_state: ToolState = STRAIGHT,
) -> tuple[_Pair, range]:  # fmt: skip
    """The block goes down on the plate, its cup's axis ahead; at each state it is so deep (m) in it."""
    robot = scene.cell.robot
    axis = (T_lance_last(robot, tool_state) @ robot.tool.T_last_tip)[:3, 2]
    R = np.linalg.svd(axis[None])[2].T  # its first column is the axis, or the opposite
    down = np.column_stack([R[:, 1], np.cross(-axis, R[:, 1]), -axis])  # turns -z into the axis
    links = np.array([[pose((0.0, 0.0, 0.01 - depth)) for depth in depths]]) @ inverse(pose(R=down))
    moving = replace(moving, T_link_shape=pose(R=down))
    states = SimpleNamespace(times=np.arange(float(len(depths))), links=links)
    segment = Segment(kind, 0.0, 1.0, tool_state, None)
    return _Pair(scene, segment, k, moving, fixture, states), range(len(depths))  # type: ignore[arg-type]


def refused(
    kind: SegmentKind, depths: Sequence[float], at_rest: int, k: int = 1, scene: Scene | None = None,
    moving: Part | None = None, fixture: Fixture | None = None, tool_state: ToolState = STRAIGHT,
) -> bool:  # fmt: skip
    moving = moving or part(is_cup=True)
    both, at = pair(scene or make_scene(), kind, k, moving, depths, fixture or plate(), tool_state)
    found = list(both.too_deep(at, at_rest))
    assert {reason.what for reason in found} <= {"planned contact too deep"}
    return bool(found)


def limits(most: float) -> tuple[tuple[float, bool], ...]:
    return (most - 1e-5, False), (most + 1e-5, True)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_a_cup_is_pressed_on_by_its_stroke_and_what_lines_are_off(
    tool_state: ToolState,
) -> None:
    for depth, is_refused in limits(STROKE + 0.0015):
        for depths in ((-0.01, 0.0, depth), (-0.01, depth, 0.002), (depth, 0.0, 0.0)):
            assert refused(CONTACT, depths, 2, tool_state=tool_state) is is_refused


def test_what_an_item_may_be_off_a_cup_may_go_deeper() -> None:
    target = place(CRAYOLA, (1.0, 0.0, 0.0), "bin_A")
    scene = make_scene(target, noise=PoseNoise(0.003, 0.0))
    for depth, is_refused in limits(STROKE + 0.003 + 0.0015):
        assert refused(CONTACT, (0.0, depth), 1, scene=scene, fixture=plate(CRAYOLA)) is is_refused
    for depth, is_refused in limits(0.003 + 0.0015):
        assert refused(DEPART, (0.0, depth), 0, scene=scene, fixture=plate(CRAYOLA)) is is_refused
    assert refused(DEPART, (0.0, 0.002), 0, scene=scene)  # of the plate the pose is known


@pytest.mark.parametrize("kind", [DEPART, LIFT, PLACE])
def test_elsewhere_a_cup_goes_no_deeper_than_it_stands_at_rest(kind: SegmentKind) -> None:
    for stands in (0.0, 0.004):
        for depth, is_refused in limits(stands + 0.0015):
            assert refused(kind, (stands, depth, 0.0), 0) is is_refused
            assert refused(kind, (0.0, depth, stands), 2) is is_refused


def test_only_out_of_where_it_began_a_cup_may_come_from_deeper_than_its_stroke() -> None:
    depth = STROKE + 0.004
    assert not refused(DEPART, (depth, 0.0), 0, k=0)
    assert refused(DEPART, (depth, 0.0), 0, k=1)
    for deeper, is_refused in limits(depth + 0.0015):
        assert refused(DEPART, (depth, deeper), 0, k=0) is is_refused


def test_a_slack_makes_no_contact_deeper() -> None:
    """Solids count as they are perceived, and not grown."""
    assert not refused(CONTACT, (0.0, STROKE), 1, fixture=plate(slack=0.05))


def test_the_deepest_state_is_told() -> None:
    both, at = pair(make_scene(), DEPART, 1, part(is_cup=True), (0.0, 0.003, 0.005, 0.004), plate())
    told = [reason.detail for reason in both.too_deep(at, 0)]
    assert told == ["cup and plate at 2.000 s, 5.0 mm deep, 1.5 explained"]


def held(depths: Sequence[float], noise: PoseNoise, kind: SegmentKind = LIFT) -> tuple[_Pair, range]:
    item = place(CRAYOLA, (1.0, 0.0, 0.0), "bin_A")
    scene = make_scene(item, noise=noise)
    moving = replace(part(is_held=True), name=CRAYOLA)
    return pair(scene, kind, 1, moving, depths, plate())


def test_a_held_item_goes_as_deep_as_it_lies_and_turns_by_over_the_first_of_the_lift() -> None:
    """A pose that is off by an angle leads 55 mm of a lift aside by that; lines are off by 1.5 mm."""
    noise = PoseNoise(0.0, 0.02)
    aside = 0.02 * 0.055
    for rest, most in ((0.001, 0.001 + aside + 0.0015), (-0.001, aside + 0.0005), (-0.02, 1e-4)):
        for depth, is_refused in limits(most):
            both, at = held((rest, depth, 0.0), noise)
            assert bool(list(both.too_deep(at, 0))) is is_refused


def test_what_rolls_is_come_to_by_a_millimetre_at_most() -> None:
    for gaps, is_pushed in (
        ((0.005, 0.0041), False), ((0.005, 0.0039), True), ((0.005, 0.02, 0.0039, 0.05), True),
        ((0.0, -0.0009), False), ((0.0, -0.0011), True), ((0.002, 0.05, 0.0011), False),
    ):  # fmt: skip
        both, at = held([-gap for gap in gaps], PoseNoise())
        assert [reason.what for reason in both.pushed(at)] == ["pushes what rolls"] * is_pushed
    both, at = held((-0.005, -0.02, -0.003, -0.05), PoseNoise())
    assert [r.detail for r in both.pushed(at)] == [
        f"{CRAYOLA} comes to plate, 2.0 mm nearer at 2.000 s, it rolls away"
    ]


# What is near at the start of a way out


@pytest.mark.parametrize("level", [RecoveryLevel.BACKWARDS, RecoveryLevel.OPENING])
@pytest.mark.parametrize("tool", [part(is_cup=True), part(is_held=True)], ids=["cup", "item"])
def test_what_cup_or_item_are_planned_to_touch_is_not_followed_on_the_way_back(
    tool: Part, level: RecoveryLevel
) -> None:
    plan = rail(-0.01, level=level, kind=DEPART)
    none = frozenset[str]()
    for moving, touched, allowed, is_followed in (
        (tool, none, False, True),
        (tool, frozenset({"plate"}), False, level is RecoveryLevel.OPENING),
        (tool, frozenset({"floor"}), False, True),
        (tool, none, True, False),
        (part(), frozenset({"plate"}), False, True),
    ):
        states, near = states_of(plan), plate()
        T = states.links[0, 0] @ pose((0.0, 0.0, -0.0605))  # the block is half a millimetre over it
        near.solid.place(T)
        near = replace(near, T_world_shape=T)
        pairs = frozenset({frozenset({"cup", "plate"})}) if allowed else frozenset[frozenset[str]]()
        exempt = Exemptions(touched, "", frozenset(), pairs)
        found = check_opening(
            plan, make_scene(), states, [(moving,)], PlanFixtures(plan, (near,), None), [exempt]
        )
        assert found.pairs == (frozenset({("cup", "plate")} if is_followed else ()),)
