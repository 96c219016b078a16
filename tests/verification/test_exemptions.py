"""Which pairs are not looked at: told pair by pair, of parts, joints and plates that are made by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from pickcli.cell.robot import Robot
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array, pose
from pickcli.motion.plan import Grasp, Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.verification.exemptions import Exemptions, _neighbours, exemptions, pinched
from pickcli.verification.fcl_solids import Solid, cover
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures
from pickcli.verification.tool_speed import check_tool_speed
from support.handmade_plans import CRAYOLA, cell, make_scene
from support.rail_motions import HOME, rail
from support.tool_states import STRAIGHT

CONTACT, LIFT, PLACE = SegmentKind.CONTACT, SegmentKind.LIFT, SegmentKind.PLACE
DEPART, RETREAT = SegmentKind.DEPART, SegmentKind.RETREAT
BLOCK = Shape(ShapeKind.BOX, (0.02, 0.02, 0.02))
PLATE = Shape(ShapeKind.BOX, (0.3, 0.3, 0.1))


def part(name: str, *reach: float, **what: bool) -> Part:
    """A block on the first link; of a hand-made robot of as many joints as reaches are told."""
    joints = np.array(reach or [1.0])
    block = Part(name, 0, np.eye(4), BLOCK, Solid(BLOCK), cover(BLOCK), joints)
    return replace(block, **what)  # type: ignore[arg-type]


LINK, CUP = part("link"), part("cup", is_cup=True)
ITEM, FINGER = part("item", is_held=True), part("finger", is_finger=True)
STAND = part("stand", 0.0)
PAIRS = frozenset({frozenset({"link", "floor"}), frozenset({"link", "arm"})})
EXEMPT = Exemptions(frozenset({"plate"}), "item", frozenset({frozenset({"link", "next"})}), PAIRS)


@pytest.mark.parametrize(
    ("moving", "name", "is_untested"),
    [
        (CUP, "plate", True), (CUP, "floor", False), (ITEM, "plate", True), (ITEM, "other", False),
        (FINGER, "item", True), (FINGER, "plate", False), (LINK, "plate", False), (LINK, "item", False),
        (LINK, "floor", True), (part("arm"), "floor", False), (STAND, "floor", True), (STAND, "plate", True),
        (part("link", 0.0, 1e-9), "plate", False), (part("stand", 0.0, is_cup=True), "floor", False),
    ],
)  # fmt: skip
def test_in_the_world_only_what_is_planned_allowed_or_at_rest_is_left_out(
    moving: Part, name: str, is_untested: bool
) -> None:
    assert EXEMPT.is_world_pair_untested(moving, name) is is_untested


@pytest.mark.parametrize(
    ("a", "b", "is_untested"),
    [
        (LINK, part("link", 2.0), True), (CUP, ITEM, True), (FINGER, ITEM, True),
        (part("arm", 1.0, 0.0), ITEM, False), (part("link", 0.0, 2.0), part("next", 2.0, 1.0), True),
        (part("link", 0.0, 2.0), part("arm", 2.0, 1.0), True),
        (part("link", 0.0, 2.0), part("far", 2.0, 1.0), False),
        (part("link", 0.1, 2.0), part("far", 2.0, 0.1), True), (CUP, part("far", 1.0), True),
        (part("cup", 1.0, 1.0, is_cup=True), part("far", 1.0, 0.0), False),
    ],
)  # fmt: skip
def test_of_the_arm_neighbours_what_is_allowed_and_what_no_joint_parts_is_left_out(
    a: Part, b: Part, is_untested: bool
) -> None:
    assert EXEMPT.is_own_pair_untested(a, b) is is_untested
    assert EXEMPT.is_own_pair_untested(b, a) is is_untested


def robot(*joints: tuple[str, str, bool], shaped: Sequence[str]) -> Robot:
    """Joints (parent, child, whether it moves) of a robot of which some links have a shape."""
    made = [SimpleNamespace(name=f"{p}-{c}", parent=p, child=c) for p, c, _ in joints]
    names = tuple(f"{p}-{c}" for p, c, moves in joints if moves)
    links = dict.fromkeys(name for p, c, _ in joints for name in (p, c))
    with_shape = [SimpleNamespace(name=name, bodies=(BLOCK,) * (name in shaped)) for name in links]
    return cast(Robot, SimpleNamespace(joints=made, joint_names=names, links=with_shape))


def test_neighbours_are_links_with_a_shape_and_one_joint_that_moves_between_them() -> None:
    chain = ("a", "b", True), ("b", "c", True), ("c", "d", False), ("d", "e", True)
    for shaped, pairs in (
        ("abcde", {"ab", "bc", "cd", "de"}), ("acde", {"ab", "cd", "de"}), ("abe", {"ab", "bc", "bd"}),
        ("ace", {"ab", "cd", "ce"}), ("ade", {"ab", "de"}), ("cde", {"ab", "cd", "de"}),
    ):  # fmt: skip
        assert _neighbours(robot(*chain, shaped=shaped)) == {frozenset(pair) for pair in pairs}


def plan_of(*kinds: SegmentKind, held: Sequence[bool], touched: str = "plate", **changes: object) -> Plan:
    parts = tuple(
        Segment(kind, float(k), k + 1.0, STRAIGHT, CRAYOLA if is_held else None, (touched,))
        for k, (kind, is_held) in enumerate(zip(kinds, held, strict=True))
    )
    grasp = Grasp(CRAYOLA, "frontal", "-z", STRAIGHT, np.eye(4), 0.1, 0.0, 0.0, 0.0, 0.0, 0.0)
    plan = Plan("pick", "", "", 0, parts, rail(0.0).trajectory, (), grasp)
    return replace(plan, **changes)  # type: ignore[arg-type]


def test_fingers_touch_what_they_close_on_or_open_from_while_they_move() -> None:
    kinds = RETREAT, CONTACT, LIFT, PLACE, DEPART, DEPART
    plan = plan_of(*kinds, held=(False, False, True, True, False, False), touched=CRAYOLA)

    def of(plan: Plan) -> list[str]:
        return [pinched(plan, k) for k in range(len(kinds))]

    moving = replace(plan, segments=tuple(replace(s, tool_state=MOVING) for s in plan.segments))
    assert of(moving) == ["", CRAYOLA, "", "", CRAYOLA, ""]
    assert of(plan) == of(replace(moving, grasp=None)) == [""] * 6
    other = replace(moving, segments=tuple(replace(s, touching=("plate",)) for s in moving.segments))
    assert of(other) == [""] * 6


# What is near where it is at rest

NEAR = cell().clearance  # m


def touched(plan: Plan, k: int, gaps: Sequence[float], moving: Sequence[Part], slack: float = 0.0) -> bool:
    """Whether segment k may touch the plate, over which the parts are by so many m at each second."""
    solid, T = Solid(PLATE), pose((0.0, 0.0, -0.05))
    solid.place(T)
    plate = Fixture("plate", T, PLATE, solid, slack)
    links: Array = np.array([[pose((0.0, 0.0, 0.01 + gap)) for gap in gaps]])
    times, n = np.arange(float(len(gaps))), len(gaps)
    still = np.zeros((n, len(HOME)))
    states = States(times, still, links, still, 0.0, cell().robot, plan.trajectory)
    world = PlanFixtures(plan, (plate,), None)
    found = exemptions(plan, make_scene(), states, [(part,) for part in moving], world)
    assert found[k].touching <= {"plate"}
    return bool(found[k].touching)


FAR = 0.5  # m


@pytest.mark.parametrize(
    ("kinds", "held", "k", "at", "owner"),
    [
        ((CONTACT, LIFT), (False, True), 0, 1, 1),
        ((CONTACT, LIFT), (False, True), 1, 1, 1),
        ((PLACE, DEPART), (True, False), 0, 1, 0),
        ((PLACE, DEPART), (True, False), 1, 1, 0),
    ],
)
def test_an_item_touches_what_it_is_near_to_where_it_is_taken_or_set_down(
    kinds: tuple[SegmentKind, ...], held: tuple[bool, ...], k: int, at: int, owner: int
) -> None:
    """``at``: the state at which it is at rest. The cup itself is far from everything there."""
    plan = plan_of(*kinds, held=held)
    moving = [replace(part("cup", is_cup=True), T_link_shape=pose((0.0, 0.0, FAR))) for _ in kinds]
    moving[owner] = part(CRAYOLA, is_held=True)
    for slack in (0.0, 0.004):
        for beyond, is_near in ((-1e-5, True), (1e-5, False)):
            gaps = [FAR] * 3
            gaps[at] = NEAR + slack + beyond
            assert touched(plan, k, gaps, moving, slack) is is_near
    gaps = [0.0] * 3
    gaps[at] = FAR
    assert not touched(plan, k, gaps, moving)
    own = [replace(one, slack=0.004) if one.is_held else one for one in moving]
    assert touched(plan, k, [NEAR + 0.0039] * 3, own) and not touched(plan, k, [NEAR + 0.0041] * 3, own)


def test_the_empty_cup_touches_what_it_is_near_to_where_a_way_out_begins() -> None:
    plan = plan_of(DEPART, RETREAT, held=(False, False), recovery=RecoveryLevel.SLOWLY)
    for gap, is_near in ((NEAR - 1e-5, True), (NEAR + 1e-5, False)):
        assert touched(plan, 0, [gap, FAR, FAR], [CUP, CUP]) is is_near
        assert not touched(plan, 0, [gap, FAR, FAR], [LINK, LINK])
        assert not touched(replace(plan, recovery=None), 0, [gap, FAR, FAR], [CUP, CUP])
        silent = replace(plan, segments=tuple(replace(s, touching=()) for s in plan.segments))
        assert not touched(silent, 0, [gap, FAR, FAR], [CUP, CUP])


# The tool's speed


@pytest.mark.parametrize(("over", "is_refused"), [(-0.5e-3, False), (0.9e-3, False), (1.1e-3, True)])
def test_the_tool_keeps_the_speed_of_its_cell_in_every_segment(over: float, is_refused: bool) -> None:
    """At its fastest, in the middle, a rail that goes by 0.2 m in a second goes at 15/8 of that."""
    limit = 0.2 * 15 / 8 / (1.0 + over)
    for ways in ((0.2,), (0.01, 0.2), (-0.2, 0.01)):
        plan = rail(*ways)
        found = list(check_tool_speed(plan, replace(cell(), max_tool_speed=limit)))
        segment = f"segment {[abs(way) for way in ways].index(0.2)} (retreat)"
        assert [(reason.what, reason.where) for reason in found] == [("tool speed", segment)] * is_refused
        assert list(check_tool_speed(plan, replace(cell(), max_tool_speed=None))) == []


def test_the_tool_is_as_fast_as_in_the_fastest_of_its_states() -> None:
    """A joint of the wrist turns the tool: in one of its states it reaches farther out."""
    plan = rail(0.1)
    p = np.tile(HOME, (2, 1))
    p[1, -2] += 0.2
    turning = replace(plan, trajectory=replace(plan.trajectory, positions=p))

    def told(state: ToolState) -> float:
        tool = replace(cell().robot.tool, positions={state: cell().robot.tool.positions[state]})
        slow = replace(cell(), max_tool_speed=1e-6, robot=replace(cell().robot, tool=tool))
        (reason,) = check_tool_speed(turning, slow)
        return float(reason.detail.split(" m/s")[0])

    speeds = sorted(told(state) for state in cell().robot.tool.positions)
    assert speeds[0] < 0.97 * speeds[1]
    for limit, is_refused in ((0.99 * speeds[1], True), (1.01 * speeds[1], False)):
        found = list(check_tool_speed(turning, replace(cell(), max_tool_speed=limit)))
        assert bool(found) is is_refused
