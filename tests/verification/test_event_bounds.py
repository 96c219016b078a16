"""When devices are switched: the very times and places up to which the verdict stays."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import Reason
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.verification.event_check import WAY_TOLERANCE, _anchored, _apart, _changes, _still, check_io
from pickcli.verification.straightness_check import every_millisecond
from pickcli.verification.vacuum_events import (
    EVENT_TIME_TOLERANCE,
    LAST_MOMENT,
    TimedEvent,
    _is_on,
    _kept,
    _near,
    _needed,
    _release,
    _rests,
    _slow,
)
from support.handmade_plans import CRAYOLA, bound, cell, make_scene
from support.tool_states import DOWN, STRAIGHT

SCENE = make_scene()
HOME = np.asarray(cell().configurations["home"].q)
LAST = HOME.size - 1  # turns the tool about its own axis
PUMP, VALVE, READ = "pump", "valve", "vacuum_sensor"
LIFT, CONTACT, TRANSIT = SegmentKind.LIFT, SegmentKind.CONTACT, SegmentKind.TRANSIT
PLACE, TRANSFER = SegmentKind.PLACE, SegmentKind.TRANSFER


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


def command(t: float, device: str = PUMP, action: str = "off", took: float = 0.0) -> TimedEvent:
    return TimedEvent(device, cell().devices[device].kind, action, t, t + took)


def event(
    device: str, action: str, complete: float, anchor: Anchor | None = None, late: float = 0.0
) -> Event:
    """An event whose effect is complete at a time, s; commanded so much later than its lead asks for."""
    lead = cell().devices[device].lead
    at = anchor or Anchor(AnchorKind.TIME, 0, complete)
    return Event(device, action, at, lead, complete, complete - lead + late)


def plan_of(
    *segments: tuple[SegmentKind, float, str | None],
    moves: Iterable[tuple[float, float, float]] = (),
    events: Iterable[Event] = (),
    joint: int = 0,
) -> Plan:
    """Segments of a kind, so many s long, with what they hold; one joint moves, all others rest.

    moves: of the joint: times, s, position beyond that of home, m or rad, and speed
    """
    lengths = [seconds for _, seconds, _ in segments]
    ends = np.cumsum(lengths).tolist()
    parts = tuple(
        Segment(kind, end - seconds, end, STRAIGHT, held)
        for (kind, seconds, held), end in zip(segments, ends, strict=True)
    )
    points = {0.0: (0.0, 0.0), **{t: (p, v) for t, p, v in moves}}
    points.setdefault(ends[-1], (points[max(points)][0], 0.0))
    times = sorted(points)
    p, v = np.tile(HOME, (len(times), 1)), np.zeros((len(times), len(HOME)))
    p[:, joint] += [points[t][0] for t in times]
    v[:, joint] = [points[t][1] for t in times]
    trajectory = Trajectory(cell().robot.joint_names, np.array(times), p, v, np.zeros_like(v))
    return bound(Plan("move", "", "", 0, parts, trajectory, tuple(events)), SCENE)


def said(plan: Plan) -> list[str]:
    return whats(check_io(plan, SCENE))


@pytest.mark.parametrize(
    ("t_end", "n"), [(0.0, 2), (0.0005, 2), (0.001, 2), (0.0015, 3), (0.25, 251), (0.2505, 252)]
)
def test_every_millisecond_has_its_time_and_both_ends_have_theirs(t_end: float, n: int) -> None:
    for t_start in (0.0, 2.0):
        times = every_millisecond(t_start, t_start + t_end)
        assert len(times) in ({n} if t_start == 0.0 else {n, n + 1})  # the difference may be rounded up
        assert (times[0], times[-1]) == (t_start, t_start + t_end)
        np.testing.assert_allclose(np.diff(times), t_end / (len(times) - 1), atol=1e-12)


# Times that an event states


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({}, []),
        ({"device": "hose"}, ["unknown device or action"]),
        ({"action": "open"}, ["unknown device or action"]),
        ({"action": "on"}, ["vacuum for nothing"]),
        ({"lead": 0.07}, ["wrong lead"]),
        ({"t_anchor": None}, ["not resolved"]),
        ({"t_trigger": None}, ["not resolved"]),
        ({"t_trigger": 1.5}, ["wrong trigger"]),
        ({"anchor": Anchor(AnchorKind.SEGMENT_START, 1, 0.0)}, []),
        ({"anchor": Anchor(AnchorKind.SEGMENT_END, 0, 0.0)}, []),
        ({"anchor": Anchor(AnchorKind.SEGMENT_END, 1, -2.0)}, []),
        ({"anchor": Anchor(AnchorKind.SEGMENT_START, 0, 0.0)}, ["wrong anchor time"]),
        ({"anchor": Anchor(AnchorKind.SEGMENT_END, 1, 0.0)}, ["wrong anchor time"]),
    ],
)
def test_every_part_of_an_event_fits_the_cell_and_the_motion(
    changes: dict[str, Any], problem: list[str]
) -> None:
    """The valve is closed at 2 s, between two segments of 2 s."""
    asked = replace(event(VALVE, "off", 2.0), **changes)
    assert said(plan_of((TRANSIT, 2.0, None), (TRANSIT, 2.0, None), events=[asked])) == problem


def test_a_command_may_be_a_microsecond_off_what_its_lead_asks_for_and_off_the_motion() -> None:
    lead, off = cell().devices[VALVE].lead, EVENT_TIME_TOLERANCE
    for complete, trigger, problem in (
        (lead, off, []),
        (lead, -off, []),
        (lead, 2 * off, ["wrong trigger"]),
        (lead - 1.5 * off, -2 * off, ["trigger outside the motion"]),
        (lead + 4.0 + off / 2, 4.0 + off, []),
        (lead + 4.0 + 1.5 * off, 4.0 + 2 * off, ["trigger outside the motion"]),
    ):
        asked = replace(event(VALVE, "off", complete), t_trigger=trigger)
        assert said(plan_of((TRANSIT, 4.0, None), events=[asked])) == problem


def test_the_cup_may_turn_until_a_microsecond_after_the_motion() -> None:
    for complete, is_refused in ((4.0 + EVENT_TIME_TOLERANCE, False), (4.0 + 2 * EVENT_TIME_TOLERANCE, True)):
        asked = event("cup_pivot", "down", complete)
        found = said(plan_of((TRANSIT, 4.0, None), events=[asked]))
        assert ("moves after the motion" in found) is is_refused


def test_an_anchor_may_be_off_by_the_very_tolerance() -> None:
    """Of time, where it is bound to a time, and of way, where it is bound to the way of a tool that rests."""
    for kind, t, offset, problem in (
        (AnchorKind.TIME, EVENT_TIME_TOLERANCE, 0.0, []),
        (AnchorKind.TIME, 2 * EVENT_TIME_TOLERANCE, 0.0, ["wrong anchor time"]),
        (AnchorKind.ARC_LENGTH, 0.0, WAY_TOLERANCE, []),
        (AnchorKind.ARC_LENGTH, 0.0, -WAY_TOLERANCE, []),
        (AnchorKind.ARC_LENGTH, 0.0, 2 * WAY_TOLERANCE, ["wrong anchor time"]),
    ):
        asked = event(VALVE, "off", t, Anchor(kind, 0, offset))
        assert whats(_anchored(plan_of((TRANSIT, 4.0, None)), SCENE, asked, "")) == problem


def test_the_way_of_an_anchor_counts_from_its_segment_backwards_as_well() -> None:
    """The rail goes 0.4 m in the second before the segment, and 0.1 m in the first second of it."""
    moves = [(1.0, 0.0, 0.0), (2.0, 0.4, 0.0), (3.0, 0.5, 0.0)]
    for complete, way in ((1.0, -0.4), (2.0, 0.0), (3.0, 0.1)):
        for off, problem in ((0.0, []), (1e-3, ["wrong anchor time"]), (-1e-3, ["wrong anchor time"])):
            asked = event(VALVE, "off", complete, Anchor(AnchorKind.ARC_LENGTH, 1, way + off))
            plan = plan_of((TRANSIT, 2.0, None), (TRANSIT, 2.0, None), moves=moves, events=[asked])
            assert said(plan) == problem


def test_two_commands_to_one_device_are_more_than_a_microsecond_apart() -> None:
    """In whatever order they stand, and whatever is between them."""
    assert whats(_apart([command(1.0), command(1.0 + 0.9e-6)])) == ["commands at the same time"]
    assert whats(_apart([command(1.0), command(1.0 + 1.1e-6)])) == []
    for second, problem in ((EVENT_TIME_TOLERANCE, ["commands at the same time"]), (2e-6, [])):
        first, other, last = command(0.0), command(0.0, VALVE), command(second)
        for commands in ((first, last), (last, first), (first, other, last), (last, other, first)):
            assert whats(_apart(commands)) == problem
    assert whats(_apart([command(0.0), command(0.0, VALVE)])) == []


# What is on, and how long


def test_exactly_one_command_is_complete_between_two_times() -> None:
    off = EVENT_TIME_TOLERANCE
    for t, problem in (
        (1.0 - off, []), (2.0 + off, []), (1.5, []),
        (1.0 - 2 * off, ["event at the wrong time"]), (2.0 + 2 * off, ["event at the wrong time"]),
    ):  # fmt: skip
        assert whats(_needed("pump on", [command(t)], 1.0, 2.0)) == problem
    assert whats(_needed("pump on", [], 1.0, 2.0)) == ["event missing"]
    assert whats(_needed("pump on", [command(1.2), command(1.7)], 1.0, 2.0)) == ["event twice"]
    assert whats(_needed("pump on", [command(0.9, took=0.5)], 1.0, 2.0)) == []  # its effect counts


def test_what_holds_is_not_switched_off_from_a_microsecond_before_until_the_release() -> None:
    for t, is_lost in (
        (1.0 - 2e-6, False),
        (1.0 - EVENT_TIME_TOLERANCE, True),
        (2.0 - 1e-9, True),
        (2.0, False),
    ):
        assert whats(_kept([command(t)], 1.0, 2.0)) == ["vacuum lost"] * is_lost


def test_what_was_on_last_stays_on_until_the_contact_is_made() -> None:
    on = [command(1.0, action="on"), command(3.0, action="on"), command(6.0, action="on")]
    for t, is_lost in ((2.0, False), (2.9, False), (3.0, True), (4.0, True), (5.0, True), (5.1, False)):
        assert whats(_is_on(on, [command(t)], 5.0)) == ["vacuum lost"] * is_lost
    assert whats(_is_on([command(5.0, action="on")], [command(5.0)], 5.0)) == ["vacuum lost"]
    assert whats(_is_on([], [command(4.0)], 5.0)) == []


def test_what_is_carried_to_the_end_is_held_by_a_pump_that_may_run_again() -> None:
    plan = plan_of((TRANSFER, 4.0, CRAYOLA), events=[event(PUMP, "on", 2.5)])
    assert said(plan) == []


def taking(*events: Event) -> Plan:
    """A contact of 4 s at rest, and an item that is lifted, carried, set down and not released, 1 s each."""
    held = [(kind, 1.0, CRAYOLA) for kind in (LIFT, TRANSFER, TRANSFER, PLACE)]
    return plan_of((CONTACT, 4.0, None), *held, events=events)


def test_vacuum_may_be_there_as_early_as_its_devices_allow() -> None:
    """From the first moment at which their commands can be given until the tool seals, at 3.75 s."""
    pump, valve = (cell().devices[name].lead for name in (PUMP, VALVE))
    read = event(READ, "read", 6.5)
    for late in (0.0, 0.5, 3.7 - max(pump, valve)):
        on = [event(PUMP, "on", pump + late), event(VALVE, "on", valve + late)]
        assert said(taking(*on, read)) == []
    too_late = [event(PUMP, "on", 3.8), event(VALVE, "on", 3.8)]
    assert said(taking(*too_late, read)) == ["event at the wrong time"] * 2


@pytest.mark.parametrize(
    ("t", "is_refused"), [(4.9, True), (5.0, False), (6.5, False), (7.5, False), (8.0, False), (8.1, True)]
)
def test_the_sensor_is_read_from_the_end_of_the_lift_until_the_item_is_let_go(
    t: float, is_refused: bool
) -> None:
    on = [event(PUMP, "on", 3.0), event(VALVE, "on", 3.0)]
    waits = plan_of(
        (CONTACT, 4.0, None), *[(kind, 1.0, CRAYOLA) for kind in (LIFT, TRANSFER, TRANSFER, PLACE)],
        (TRANSIT, 1.0, None), events=[*on, event(READ, "read", t)],
    )  # fmt: skip
    found = [r for r in check_io(waits, SCENE) if r.where == "sensor read"]
    assert whats(found) == ["event at the wrong time"] * is_refused


# Rest


@pytest.mark.parametrize(
    ("seconds", "moved", "is_refused"),
    [(0.5, 0.0, False), (0.25, 0.0, False), (0.2, 0.0, True), (0.5, 0.1, True), (0.2, 0.1, True)],
)
def test_a_contact_that_comes_first_is_long_enough_to_seal_and_at_rest(
    seconds: float, moved: float, is_refused: bool
) -> None:
    plan = plan_of((CONTACT, seconds, None), moves=[(seconds, moved, 0.0)])
    assert whats(_rests(plan, seconds - 0.25, seconds)) == ["no time to seal"] * is_refused


def test_a_joint_that_comes_back_has_not_rested() -> None:
    """By 10 um there and back within the seal, and by as much before it."""
    for at, is_refused in ((2.5, True), (1.5, False)):
        moves = [(at - 0.4, 0.0, 0.0), (at, 1e-5, 0.0), (at + 0.4, 0.0, 0.0)]
        plan = plan_of((CONTACT, 3.0, None), moves=moves)
        assert whats(_rests(plan, 2.0, 3.0)) == ["no time to seal"] * is_refused


# The release


@pytest.mark.parametrize(("rest", "is_thrown"), [(0.0, True), (0.0005, True), (0.0015, False)])
def test_in_its_last_millisecond_the_tool_is_slow_however_late_the_valve_closes(
    rest: float, is_thrown: bool
) -> None:
    """The rail moves at 0.5 m/s and stands for so many s before the release at 2 s."""
    stop = 2.0 - rest
    moves = [(stop - 0.001, 0.3, 0.5), (stop, 0.3003, 0.0)]
    plan = plan_of((PLACE, 2.0, CRAYOLA), (TRANSIT, 1.0, None), moves=moves)
    thrown = ["released too fast"] * is_thrown
    for trigger in (2.0, 5.0, 2.0 - LAST_MOMENT):
        assert whats(_slow(plan, SCENE, plan.segments[0], command(trigger, VALVE))) == thrown


def test_the_speed_before_a_place_begins_is_not_that_of_the_release() -> None:
    """Fast in the transfer, at rest from the second of the place on, and the command comes before both."""
    moves = [(0.5, 0.3, 0.9), (1.0, 0.5, 0.0)]
    plan = plan_of((TRANSFER, 1.0, CRAYOLA), (PLACE, 1.0, CRAYOLA), moves=moves)
    assert whats(_slow(plan, SCENE, plan.segments[1], command(0.5, VALVE, took=1.0))) == []
    assert whats(_slow(plan, SCENE, plan.segments[0], command(0.5, VALVE))) == ["released too fast"]


def evenly(speed: float) -> list[tuple[float, float, float]]:
    """The rail goes from rest at a speed from 0.5 s to 1.5 s, and rests again at 2 s."""
    return [(0.5, speed / 4, speed), (1.5, speed * 5 / 4, speed), (2.0, speed * 3 / 2, 0.0)]


@pytest.mark.parametrize(("over", "is_thrown"), [(-1e-3, False), (1e-3, True)])
def test_the_tool_goes_at_10_cm_a_second_from_the_command_on_and_stands_when_the_valve_is_closed(
    over: float, is_thrown: bool
) -> None:
    """Standing is to move by 2 mm/s at most."""
    for speed, closed in ((0.1, 2.0), (0.002, 1.0)):
        moves = evenly(speed * (1.0 + over))
        plan = plan_of((PLACE, 2.0, CRAYOLA), moves=moves)
        valve = command(0.7, VALVE, took=closed - 0.7)
        found = list(_slow(plan, SCENE, plan.segments[0], valve))
        assert whats(found) == ["released too fast"] * is_thrown
        assert all(f"at most {speed} m/s" in reason.detail for reason in found)


@pytest.mark.parametrize(("away", "is_refused"), [(0.0049, False), (0.0051, True)])
def test_the_valve_opens_within_5_mm_of_the_contact(away: float, is_refused: bool) -> None:
    """The rail goes at 10 mm/s from 0.5 s to 1.5 s and by another 2.5 mm, and then rests on the item."""
    at = 1.5 - (away - 0.0025) / 0.01
    on = [event(PUMP, "on", 3.0), event(VALVE, "on", at)]
    held = [(kind, 1.0, CRAYOLA) for kind in (LIFT, TRANSFER)]
    plan = plan_of((CONTACT, 4.0, None), *held, moves=evenly(0.01), events=[*on, event(READ, "read", 5.5)])
    assert said(plan) == ["event at the wrong place"] * is_refused


@pytest.mark.parametrize(("away", "is_refused"), [(0.0099, False), (0.0101, True)])
def test_the_valve_closes_within_10_mm_of_the_release(away: float, is_refused: bool) -> None:
    """The rail goes at 30 mm/s to 1.5 s and by another 7.5 mm until 2 s, where the item is let go."""
    at, lead = 1.5 - (away - 0.0075) / 0.03, cell().devices[VALVE].lead
    plan = plan_of((PLACE, 2.0, CRAYOLA), (TRANSIT, 2.0, None), moves=evenly(0.03),
                   events=[event(VALVE, "off", at + lead), event(PUMP, "off", 4.0)])  # fmt: skip
    found = [what for what in said(plan) if what != "released too fast"]
    assert found == ["event at the wrong place"] * is_refused


@pytest.mark.parametrize(("t", "is_far"), [(0.0, True), (1.0, True), (2.0, False)])
def test_the_tool_is_near_where_its_segment_ends(t: float, is_far: bool) -> None:
    plan = plan_of((PLACE, 2.0, CRAYOLA), moves=[(2.0, 0.2, 0.0)])
    for most, is_refused in ((0.09, is_far), (0.21, False)):
        refused = ["event at the wrong place"] * is_refused
        assert whats(_near(plan, SCENE, plan.segments[0], t, most, "valve off")) == refused


@pytest.mark.parametrize(("t", "is_lost"), [(3.9, False), (4.5, True), (5.5, True), (7.9, True)])
@pytest.mark.parametrize("device", [PUMP, VALVE])
def test_what_was_taken_is_held_from_the_first_segment_on(device: str, t: float, is_lost: bool) -> None:
    """From 4 s, in the lift as later, until it is let go at 8 s."""
    release = [event(VALVE, "off", 8.0), event(PUMP, "off", 10.0)]
    on = [event(PUMP, "on", 3.0), event(VALVE, "on", 3.0), event(READ, "read", 6.5)]
    off = event(device, "off", t + cell().devices[device].lead)
    held = [(kind, 1.0, CRAYOLA) for kind in (LIFT, TRANSFER, TRANSFER, PLACE)]
    plan = plan_of((CONTACT, 4.0, None), *held, (TRANSIT, 2.0, None), events=[*on, off, *release])
    found = [r for r in check_io(plan, SCENE) if r.what == "vacuum lost" and "still held" in r.detail]
    assert bool(found) is is_lost


@pytest.mark.parametrize(("moved", "is_refused"), [(1e-6, False), (-1e-6, False), (1.01e-6, True)])
def test_a_joint_that_rests_may_move_by_a_micrometre_or_microrad(moved: float, is_refused: bool) -> None:
    joint = HOME.tolist().index(0.0)
    plan = plan_of((CONTACT, 1.0, None), moves=[(1.0, moved, 0.0)], joint=joint)
    assert whats(_rests(plan, 0.0, 1.0)) == ["no time to seal"] * is_refused


def test_a_wrong_trigger_is_told_with_the_right_one() -> None:
    """The valve is to be closed at 2 s; it is commanded its lead before that."""
    asked = replace(event(VALVE, "off", 2.0), t_trigger=1.5)
    (reason,) = check_io(plan_of((TRANSIT, 4.0, None), events=[asked]), SCENE)
    assert reason.detail == f"at 1.500 s, anchor less lead is {2.0 - cell().devices[VALVE].lead:.3f} s"


def test_the_pump_is_not_off_before_the_valve_and_both_are_needed() -> None:
    plan = plan_of((PLACE, 2.0, CRAYOLA), (TRANSIT, 2.0, None))
    (place, _) = plan.segments

    def found(*commands: TimedEvent) -> list[str]:
        def find(kind: DeviceKind, action: str) -> list[TimedEvent]:
            return [c for c in commands if c.kind is kind and c.action == action]

        return whats(_release(plan, SCENE, place, place, find))

    valve = command(1.5, VALVE)
    assert found(valve, command(1.5)) == found(valve, command(3.0)) == []
    assert found(valve, command(1.2, took=0.5)) == ["vacuum lost"]
    assert found(valve, command(1.2)) == ["event at the wrong time", "vacuum lost"]
    assert found(command(1.5)) == ["event missing", "event at the wrong time"]
    assert found(valve) == found(command(2.0)) == ["event missing"]
    assert found() == ["event missing", "event missing"]


# The state of the tool


def turn(t: float, action: str) -> TimedEvent:
    return command(t, "cup_pivot", action, 0.5)


def test_no_command_moves_the_cup_within_a_segment_but_for_a_microsecond() -> None:
    """The segment counts on its state from 1 s to 2 s."""
    segment, off = Segment(TRANSIT, 1.0, 2.0, STRAIGHT, None), EVENT_TIME_TOLERANCE
    for trigger, complete, is_refused in (
        (0.5, 1.0 + off, False), (0.5, 1.0 + 2 * off, True), (2.0 - off, 2.5, False),
        (2.0 - 2 * off, 2.5, True), (0.5, 2.5, True), (0.2, 0.8, False), (2.2, 2.8, False),
    ):  # fmt: skip
        move = replace(turn(trigger, "down"), complete=complete)
        assert whats(_still(segment, [move], "")) == ["wrong tool state"] * is_refused


def states(*stated: ToolState) -> list[Segment]:
    return [Segment(TRANSIT, float(k), k + 1.0, state, None) for k, state in enumerate(stated)]


def changes(segments: list[Segment], moves: list[TimedEvent]) -> Iterable[Reason]:
    return _changes(segments, SCENE.cell.robot.tool, moves)


def test_a_segment_states_what_the_last_command_before_it_left() -> None:
    """Commands that are complete at 1 s and at 2 s, and what the plan begins with."""
    there, back = turn(0.5, "down"), turn(1.5, "straight")
    assert whats(changes(states(STRAIGHT, STRAIGHT), [])) == []
    assert whats(changes(states(STRAIGHT, DOWN), [])) == ["wrong tool state"]
    assert whats(changes(states(STRAIGHT, DOWN, STRAIGHT), [there, back])) == []
    assert whats(changes(states(STRAIGHT, DOWN, DOWN), [there, back])) == ["wrong tool state"]
    assert whats(changes(states(STRAIGHT, STRAIGHT, STRAIGHT), [there, back])) == ["wrong tool state"]
    assert whats(changes(states(MOVING, DOWN, DOWN), [there])) == []
    assert whats(changes(states(MOVING, MOVING, DOWN), [])) == ["wrong tool state"]
    assert whats(changes(states(MOVING, MOVING), [])) == []
    assert "the commands leave it down" in str([*changes(states(STRAIGHT, STRAIGHT), [there])])
    assert "no command says" in str([*changes(states(MOVING, STRAIGHT), [])])


def test_a_command_that_is_complete_within_a_microsecond_of_a_segment_s_start_counts() -> None:
    for late, is_refused in ((EVENT_TIME_TOLERANCE, False), (2 * EVENT_TIME_TOLERANCE, True)):
        move = replace(turn(0.5, "down"), complete=1.0 + late)
        assert whats(changes(states(MOVING, DOWN), [move])) == ["wrong tool state"] * is_refused
