"""When devices are switched: cases at the very times on which the verdict turns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.event_check import check_io
from support.handmade_plans import CRAYOLA, SEAL_TIME, Builder, bound, cell, make_scene, pick, pick_sealing
from support.plan_mutations import moved_event, segment
from support.tool_states import DOWN

Q = np.asarray(cell().configurations["home"].q)


def whats(reasons: Iterable[Reason]) -> list[str]:
    return [reason.what for reason in reasons]


def event_at(device: str, action: str, trigger: float) -> Event:
    """An event commanded at a time, s, of a plan's first segment."""
    lead = cell().devices[device].lead
    anchor = Anchor(AnchorKind.TIME, 0, trigger + lead)
    return Event(device, action, anchor, lead, trigger + lead, trigger)


def carrying(*events: Event) -> tuple[Plan, Scene]:
    """A plan that begins and ends with the item in the cup."""
    builder, scene = Builder(Q), make_scene()
    builder.wait(SegmentKind.TRANSFER, 4.0, held=CRAYOLA)
    grasp = pick()[0].grasp
    plan = Plan("bring", "", "", 0, tuple(builder.segments), builder.trajectory(), events, grasp)
    return bound(plan, scene), scene


@pytest.mark.parametrize("device", ["pump", "valve"])
@pytest.mark.parametrize("t", [-0.9e-6, 0.0, 1e-3, 1.0])
def test_what_is_carried_from_the_start_is_lost_if_anything_is_switched_off(device: str, t: float) -> None:
    """Also with the first command of all."""
    assert check_io(*carrying()) == ()
    assert whats(check_io(*carrying(event_at(device, "off", t)))) == ["vacuum lost"]


@pytest.mark.parametrize(("missing", "is_refused"), [(0.0, False), (-0.1, False), (0.05, True), (0.2, True)])
def test_the_tool_rests_on_an_item_until_the_vacuum_is_there(missing: float, is_refused: bool) -> None:
    """So many s less than the cell's tool needs."""
    plan, scene = pick_sealing(SEAL_TIME - missing), pick()[1]
    assert ("no time to seal" in whats(check_io(plan, scene))) is is_refused


def test_pump_and_valve_are_on_when_the_tool_comes_to_rest_on_the_item() -> None:
    plan, scene = pick()
    for i in (0, 1):
        for late, is_refused in ((0.9e-6, False), (1e-3, True), (SEAL_TIME, True)):
            moved = moved_event(i, late)(plan)
            assert ("event at the wrong time" in whats(check_io(moved, scene))) is is_refused


def test_a_tool_that_seals_slowly_needs_more_rest_and_one_that_seals_at_once_none() -> None:
    plan, scene = pick()
    for seal_time, refused in ((0.3, True), (0.0, False), (20.0, True)):
        tool = scene.cell.robot.tool
        slower = replace(tool, grip=replace(tool.cup, seal_time=seal_time))
        robot = replace(scene.cell.robot, tool=slower)
        other = replace(scene, cell=replace(scene.cell, robot=robot))
        assert ("no time to seal" in whats(check_io(plan, other))) is refused


@pytest.mark.parametrize(("by", "is_lost"), [(-1e-3, False), (0.0, True), (1e-3, True)])
def test_what_is_switched_off_after_it_was_switched_on_is_off(by: float, is_lost: bool) -> None:
    """At the same time too: nobody knows which command comes last."""
    plan, scene = pick()
    on = plan.events[0]
    assert on.t_trigger is not None
    contact = plan.segments[segment(plan, SegmentKind.CONTACT)]
    off = event_at(on.device, "off", on.t_trigger + by)
    assert on.t_trigger + by < contact.t_end
    again = replace(plan, events=(*plan.events, off))
    found = [reason for reason in check_io(again, scene) if reason.what == "vacuum lost"]
    assert bool(found) is is_lost


def turning(early: float, late: float) -> tuple[Plan, Scene]:
    """A wait, the cup turning down for as long as that takes, and a wait with it turned.

    early, late: s by which the command comes before the turning segment, and by which that is shorter
    """
    builder, lead = Builder(Q), cell().devices["cup_pivot"].lead
    builder.wait(SegmentKind.TRANSIT, 1.0)
    builder.wait(SegmentKind.TRANSIT, lead - early - late, tool_state=MOVING)
    builder.wait(SegmentKind.TRANSIT, 1.0, tool_state=DOWN)
    scene = make_scene()
    events = (event_at("cup_pivot", "down", 1.0 - early),)
    plan = Plan("move", "", "", 0, tuple(builder.segments), builder.trajectory(), events)
    return bound(plan, scene), scene


@pytest.mark.parametrize(
    ("early", "late", "is_refused"),
    [(0.0, 0.0, False), (0.9e-6, 0.0, False), (1.2e-6, 0.0, True), (0.0, 0.9e-6, False),
     (0.0, 1.2e-6, True), (-0.1, 0.0, False), (0.0, -0.1, False), (0.1, 0.0, True)],
)  # fmt: skip
def test_the_cup_turns_while_a_segment_says_so_and_at_no_other_time(
    early: float, late: float, is_refused: bool
) -> None:
    """To a microsecond."""
    assert ("wrong tool state" in whats(check_io(*turning(early, late)))) is is_refused


@pytest.mark.parametrize("apart", [0.0, 1e-10, 0.9e-6])
@pytest.mark.parametrize("actions", [("down", "straight"), ("straight", "down"), ("down", "down")])
def test_two_commands_to_one_device_at_one_moment_are_refused(apart: float, actions: tuple[str, str]) -> None:
    """Whoever carries the plan out could take either of them for the last."""
    builder = Builder(Q)
    builder.wait(SegmentKind.TRANSIT, 2.0, tool_state=MOVING)
    scene, (first, second) = make_scene(), actions
    events = event_at("cup_pivot", first, 0.5), event_at("cup_pivot", second, 0.5 + apart)
    plan = Plan("move", "", "", 0, tuple(builder.segments), builder.trajectory(), events)
    assert "commands at the same time" in whats(check_io(bound(plan, scene), scene))
    shifted = replace(plan, events=(events[0], event_at("cup_pivot", second, 1.0)))
    assert "commands at the same time" not in whats(check_io(bound(shifted, scene), scene))


@pytest.mark.parametrize(
    ("early", "is_refused"), [(0.0, False), (0.9e-6, False), (1.2e-6, True), (0.3, True)]
)
def test_the_cup_has_turned_when_the_motion_ends(early: float, is_refused: bool) -> None:
    """What it would do afterwards nobody has looked at."""
    builder, lead = Builder(Q), cell().devices["cup_pivot"].lead
    builder.wait(SegmentKind.TRANSIT, 1.0)
    builder.wait(SegmentKind.TRANSIT, lead - early + 1e-9, tool_state=MOVING)
    scene = make_scene()
    plan = Plan(
        "move",
        "",
        "",
        0,
        tuple(builder.segments),
        builder.trajectory(),
        (event_at("cup_pivot", "down", 1.0),),
    )
    assert ("moves after the motion" in whats(check_io(bound(plan, scene), scene))) is is_refused


@pytest.mark.parametrize("device", ["pump", "valve"])
def test_what_takes_nothing_switches_no_vacuum_on(device: str) -> None:
    builder, scene = Builder(Q), make_scene()
    builder.wait(SegmentKind.TRANSIT, 4.0)
    plan = Plan("move", "", "", 0, tuple(builder.segments), builder.trajectory(), ())
    for action, told in (("on", ["vacuum for nothing"]), ("off", [])):
        switching = replace(plan, events=(event_at(device, action, 0.5),))
        assert whats(check_io(bound(switching, scene), scene)) == told


def test_the_pump_is_switched_off_after_the_release() -> None:
    plan, scene = pick()
    assert check_io(plan, scene) == ()
    left_on = tuple(e for e in plan.events if (e.device, e.action) != ("pump", "off"))
    assert [str(r) for r in check_io(replace(plan, events=left_on), scene)] == [
        "pump off: event missing: 0 of them, needs one"
    ]


@pytest.mark.parametrize(("when", "is_refused"), [(2.0, True), (3.0, True), (3.9, True), (4.0, False)])
def test_the_sensor_is_read_when_all_of_the_lift_is_over_also_where_nothing_follows_it(
    when: float, is_refused: bool
) -> None:
    """A contact and a lift in three segments, 1 s each."""
    builder, scene = Builder(Q), make_scene()
    builder.wait(SegmentKind.CONTACT, 1.0)
    for _ in range(3):
        builder.wait(SegmentKind.LIFT, 1.0, held=CRAYOLA)
    sensor = next(d for d in cell().devices.values() if d.kind is DeviceKind.SENSOR)
    read = event_at(sensor.name, "read", when - sensor.lead)
    plan = Plan("lift", "", "", 0, tuple(builder.segments), builder.trajectory(), (read,), pick()[0].grasp)
    found = check_io(bound(plan, scene), scene)
    assert any(r.what == "event at the wrong time" and r.where == "sensor read" for r in found) is is_refused
