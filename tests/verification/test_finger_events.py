"""Fingers close and open while the arm rests, by one command each, to the microsecond and the micrometre."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import Reason
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.finger_events import check_finger_events, leads_to
from pickcli.verification.finger_kinematics import finger_position
from pickcli.verification.hold_choice import PINCH, SUCTION, hold_checks
from support.gripper_cell import CLOSED, HALF, HALF_WIDE, LEAD, OPEN, WIDEST
from support.handmade_plans import cell as cup_cell
from support.tool_states import DOWN, STRAIGHT

K = SegmentKind
WIDTH = ToolState.of_width(0.03)
PICK = (
    (K.APPROACH, OPEN, None), (K.CONTACT, MOVING, "box"), (K.LIFT, WIDTH, "box"), (K.PLACE, WIDTH, "box"),
    (K.DEPART, MOVING, None), (K.DEPART, OPEN, None),
)  # fmt: skip
CLOSES, OPENS = 1.2, 4.3  # s, when the commands of that pick are given


def command(t: float, action: str, took: float = LEAD) -> Event:
    return Event("fingers", action, Anchor(AnchorKind.TIME, 0, t + took), LEAD, t + took, t)


def plan_of(
    cell: Cell,
    events: Sequence[Event],
    parts: Sequence[tuple[SegmentKind, ToolState, str | None]] = PICK,
    moves: float = 0.0,
    at: float = 0.0,
) -> Plan:
    """Segments of a second each; at one time a joint is so far (rad) from where it is at all others."""
    segments = tuple(
        Segment(kind, float(k), k + 1.0, state, held if kind is not K.CONTACT else None)
        for k, (kind, state, held) in enumerate(parts)
    )
    times = np.arange(0.0, len(parts) + 0.05, 0.1).round(9)
    p = np.tile(np.asarray(cell.configurations["home"].q), (len(times), 1))
    p[np.abs(times - at) < 1e-9, 3] += moves
    still = np.zeros_like(p)
    trajectory = Trajectory(cell.robot.joint_names, times, p, still, still)
    return Plan("pick", "", "", 0, segments, trajectory, tuple(events))


def told(cell: Cell, plan: Plan) -> list[Reason]:
    return list(check_finger_events(plan, Scene(cell, cell.T_world_pod, (), PoseNoise())))


def said(cell: Cell, plan: Plan) -> list[str]:
    return whats(told(cell, plan))


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


CLOSE, RELEASE = command(CLOSES, "closed"), command(OPENS, "open")


def test_a_pick_closes_and_opens_once(gripper_cell: Cell) -> None:
    assert said(gripper_cell, plan_of(gripper_cell, (CLOSE, RELEASE))) == []
    assert said(gripper_cell, plan_of(gripper_cell, (CLOSE, command(2.0, "open"), RELEASE))) == []


@pytest.mark.parametrize(
    ("events", "what", "which"),
    [
        ((RELEASE,), "event missing", "fingers close"), ((CLOSE,), "event missing", "fingers open"),
        ((CLOSE, CLOSE, RELEASE), "event twice", "fingers close"),
        ((CLOSE, RELEASE, RELEASE), "event twice", "fingers open"),
    ],
)  # fmt: skip
def test_a_command_that_is_missing_or_given_twice_is_told(
    events: Sequence[Event], what: str, which: str, gripper_cell: Cell
) -> None:
    (reason,) = told(gripper_cell, plan_of(gripper_cell, events))
    assert (reason.what, reason.where) == (what, which)


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize(
    ("start", "took", "is_refused"),
    [
        (-0.5e-6, LEAD, False), (-1.5e-6, LEAD, True), (0.0, 1.0 + 0.5e-6, False), (0.0, 1.0 + 1.5e-6, True),
        (0.5, LEAD, False), (0.6, LEAD, True), (-0.2, LEAD, True),
    ],
)  # fmt: skip
def test_a_command_begins_and_ends_while_the_fingers_may_move(
    first: int, start: float, took: float, is_refused: bool, gripper_cell: Cell
) -> None:
    events = [CLOSE, RELEASE]
    events[first] = command((1.0, 4.0)[first] + start, ("closed", "open")[first], took)
    found = told(gripper_cell, plan_of(gripper_cell, events))
    assert whats(found) == ["event missing"] * is_refused
    assert all(reason.where == ("fingers close", "fingers open")[first] for reason in found)


@pytest.mark.parametrize(
    ("action", "width", "is_refused"),
    [
        ("closed", 0.03, False), ("half", 0.05, False), ("half", HALF_WIDE, True), ("half", 0.03, True),
        ("open", 0.03, True),
    ],
)  # fmt: skip
def test_fingers_close_to_less_than_the_width_of_what_they_hold(
    action: str, width: float, is_refused: bool, gripper_cell: Cell
) -> None:
    holding = ToolState.of_width(width)
    parts = tuple((kind, holding if state == WIDTH else state, held) for kind, state, held in PICK)
    plan = plan_of(gripper_cell, (command(CLOSES, action), RELEASE), parts)
    assert said(gripper_cell, plan) == ["event missing"] * is_refused


@pytest.mark.parametrize(
    ("action", "width", "is_refused"),
    [
        ("open", 0.03, False), ("half", 0.03, False), ("half", HALF_WIDE, True), ("half", 0.05, True),
        ("closed", 0.03, True), ("open", WIDEST, True),
    ],
)  # fmt: skip
def test_fingers_open_to_more_than_the_width_of_what_they_hold(
    action: str, width: float, is_refused: bool, gripper_cell: Cell
) -> None:
    """The width that is held at last counts."""
    holding = ToolState.of_width(width)
    parts = tuple((kind, holding if kind is K.PLACE else state, held) for kind, state, held in PICK)
    plan = plan_of(gripper_cell, (CLOSE, command(OPENS, action)), parts)
    assert said(gripper_cell, plan) == ["event missing"] * is_refused


def test_a_state_that_the_cell_names_is_as_wide_as_it_says(gripper_cell: Cell) -> None:
    parts = tuple((kind, HALF if state == WIDTH else state, held) for kind, state, held in PICK)
    assert said(gripper_cell, plan_of(gripper_cell, (CLOSE, RELEASE), parts)) == []
    half = command(CLOSES, "half")
    assert said(gripper_cell, plan_of(gripper_cell, (half, RELEASE), parts)) == ["event missing"]


@pytest.mark.parametrize(
    ("at", "what"), [(1.5, "close"), (4.5, "open"), (2.5, None), (0.5, None), (3.5, None)]
)
@pytest.mark.parametrize(("moves", "is_refused"), [(0.8e-6, False), (1.3e-6, True), (-1.3e-6, True)])
def test_the_arm_rests_while_the_fingers_move(
    at: float, what: str | None, moves: float, is_refused: bool, gripper_cell: Cell
) -> None:
    found = said(gripper_cell, plan_of(gripper_cell, (CLOSE, RELEASE), moves=moves, at=at))
    assert found == [f"fingers {what} while the arm moves"] * (is_refused and what is not None)


def test_the_fingers_open_right_after_what_they_hold(gripper_cell: Cell) -> None:
    """The state of the segment says so; by its end the command is carried out."""
    parts = (*PICK[:4], (K.DEPART, WIDTH, None), PICK[5])
    (reason,) = told(gripper_cell, plan_of(gripper_cell, (CLOSE, RELEASE), parts))
    assert (reason.what, reason.where) == ("wrong tool state", "segment 4 (depart)")
    late = plan_of(gripper_cell, (CLOSE, command(5.2, "open")))
    assert said(gripper_cell, late) == ["event missing"]


def test_what_is_held_to_the_end_is_not_let_go_and_what_is_held_from_the_start_is_not_taken(
    gripper_cell: Cell,
) -> None:
    assert said(gripper_cell, plan_of(gripper_cell, (CLOSE,), PICK[:4])) == []
    bringing = ((K.TRANSFER, WIDTH, "box"), (K.PLACE, WIDTH, "box"), *PICK[4:])
    assert said(gripper_cell, plan_of(gripper_cell, (command(2.3, "open"),), bringing)) == []
    assert said(gripper_cell, plan_of(gripper_cell, (), bringing)) == ["event missing"]
    assert said(gripper_cell, plan_of(gripper_cell, (), PICK[:2])) == []
    assert said(gripper_cell, plan_of(gripper_cell, (), PICK[4:])) == []


@pytest.mark.parametrize(
    ("command", "state", "held", "leads"),
    [
        (OPEN, OPEN, None, True), (CLOSED, OPEN, None, False), (OPEN, OPEN, "box", False),
        (CLOSED, WIDTH, "box", True), (HALF, WIDTH, "box", False),
        (HALF, ToolState.of_width(0.0401), "box", True),
        (HALF, ToolState.of_width(HALF_WIDE), "box", False), (CLOSED, WIDTH, None, False),
        (CLOSED, HALF, "box", True), (HALF, HALF, "box", False), (WIDTH, WIDTH, "box", True),
        (ToolState.of_width(0.02), WIDTH, "box", False),
    ],
)  # fmt: skip
def test_fingers_end_on_what_they_close_on_and_else_where_they_are_told_to(
    command: ToolState, state: ToolState, held: str | None, leads: bool, gripper_cell: Cell
) -> None:
    segment = Segment(K.LIFT, 0.0, 1.0, state, held)
    assert leads_to(gripper_cell.robot.tool, command, segment) is leads


def test_a_cup_is_where_it_is_told_to_be() -> None:
    tool = cup_cell().robot.tool
    for held in (None, "box"):
        assert leads_to(tool, DOWN, Segment(K.LIFT, 0.0, 1.0, DOWN, held))
        assert not leads_to(tool, STRAIGHT, Segment(K.LIFT, 0.0, 1.0, DOWN, held))


def test_each_finger_goes_half_of_the_way_from_where_the_pads_meet(gripper_cell: Cell) -> None:
    tool = gripper_cell.robot.tool
    gripper = tool.gripper
    assert gripper is not None
    for gap in (0.0, 0.006):
        apart = replace(tool, grip=replace(gripper, gap=gap))
        for finger in gripper.fingers:
            at = finger_position(apart, finger.joint, 0.05)
            assert at == pytest.approx(finger.opening_sign * (0.05 - gap) / 2) and at != 0.0
        assert finger_position(apart, "wrist", 0.05) == 0.0


def test_fingers_pinch_and_all_else_sucks(gripper_cell: Cell) -> None:
    assert hold_checks(gripper_cell.robot.tool) is PINCH
    assert hold_checks(cup_cell().robot.tool) is SUCTION
