"""Events are bound to the segments that give them their meaning."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.device import Device, DeviceKind
from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import InputError
from pickcli.io_events.bind import bind_pick, bind_tool_states
from pickcli.io_events.resolve import delay_segments, resolve
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from support.tool_states import DOWN, STRAIGHT

TOOL = load_cell("apc2016_delft").robot.tool
DEVICES = {
    device.name: device
    for device in (
        Device("pump", DeviceKind.PUMP, 2.0, ("on", "off")),
        Device("valve", DeviceKind.VALVE, 0.05, ("on", "off")),
        Device("gauge", DeviceKind.SENSOR, 0.0, ("read",)),
        Device("cup", DeviceKind.TOOL_ACTUATOR, 0.3, ("straight", "down")),
    )
}


def pick(tool_state: ToolState = DOWN, first: ToolState = MOVING) -> tuple[Segment, ...]:
    """A pick whose segments last one second each, but the contact and the place: one and a half."""
    k, rows, t = SegmentKind, [], 0.0
    for kind, held, state, lasts in (
        (k.TRANSIT, None, first, 1.0),
        (k.PREAPPROACH, None, tool_state, 1.0),
        (k.APPROACH, None, tool_state, 1.0),
        (k.CONTACT, None, tool_state, 1.5),
        (k.LIFT, "duck", tool_state, 1.0),
        (k.RETREAT, "duck", tool_state, 1.0),
        (k.TRANSFER, "duck", tool_state, 1.0),
        (k.PLACE, "duck", tool_state, 1.5),
        (k.DEPART, None, tool_state, 1.0),
    ):
        rows.append(Segment(kind, t, t + lasts, state, held))
        t += lasts
    return tuple(rows)


def line(duration: float = 10.0, speed: float = 0.5) -> Trajectory:
    """One joint at an even speed; ends are not at rest, which does not matter here."""
    t = np.linspace(0.0, duration, 101)
    q = (speed * t)[:, None]
    return Trajectory(("x",), t, q, np.full_like(q, speed), np.zeros_like(q))


def times_of(segments: tuple[Segment, ...]) -> dict[tuple[str, str], tuple[float, float]]:
    """(device, action) -> (anchor, trigger)."""
    events = resolve(bind_pick(segments, DEVICES, TOOL, 0.5, 0.5), segments, line()).events
    out = {(e.device, e.action): (e.t_anchor, e.t_trigger) for e in events}
    assert len(out) == len(events)
    return out  # type: ignore[return-value]


def test_a_pick_has_its_events_where_they_belong() -> None:
    times = times_of(pick())
    pressed_on, retreated, over_the_tote = 4.0, 6.5, 8.5
    assert times["pump", "on"] == pytest.approx((pressed_on, pressed_on - 2.0))
    assert times["valve", "on"] == pytest.approx((pressed_on, pressed_on - 0.05))
    assert times["gauge", "read"] == pytest.approx((retreated, retreated))
    assert times["valve", "off"] == pytest.approx((over_the_tote, over_the_tote - 0.05))
    assert times["pump", "off"][1] == pytest.approx(over_the_tote)


def test_cup_turns_as_soon_as_it_may() -> None:
    segments = pick()
    anchor, trigger = times_of(segments)["cup", "down"]
    assert trigger == pytest.approx(segments[0].t_start)
    assert anchor <= segments[0].t_end


def test_no_turn_without_a_moving_segment() -> None:
    assert bind_tool_states(pick(STRAIGHT, STRAIGHT), DEVICES, TOOL) == ()


def test_several_moving_segments_in_a_row_are_one_turn() -> None:
    segments = (Segment(SegmentKind.DEPART, 0.0, 1.0, DOWN, None), *pick(STRAIGHT)[:1], *pick(STRAIGHT))
    events = bind_tool_states(segments, DEVICES, TOOL)
    assert [(e.action, e.anchor.segment) for e in events] == [("straight", 1)]


def test_a_move_without_contact_switches_nothing() -> None:
    assert bind_pick(pick(STRAIGHT, STRAIGHT)[:1], DEVICES, TOOL) == ()


def test_a_pick_that_keeps_the_item_does_not_let_go() -> None:
    assert not [e for e in bind_pick(pick()[:-1], DEVICES, TOOL) if e.action == "off"]


def test_missing_device_or_action_is_named() -> None:
    without_valve = {name: device for name, device in DEVICES.items() if name != "valve"}
    with pytest.raises(InputError, match="no valve"):
        bind_pick(pick(), without_valve, TOOL)
    deaf = {**DEVICES, "pump": Device("pump", DeviceKind.PUMP, 2.0, ("off",))}
    with pytest.raises(InputError, match="pump cannot 'on'"):
        bind_pick(pick(), deaf, TOOL)


def test_lead_longer_than_the_way_asks_for_a_delay_that_suffices() -> None:
    segments = pick()[2:]
    segments = tuple(Segment(s.kind, s.t_start - 2, s.t_end - 2, s.tool_state, s.held) for s in segments)
    slow = {**DEVICES, "pump": Device("pump", DeviceKind.PUMP, 5.0, ("on", "off"))}
    events = bind_pick(segments, slow, TOOL)
    first = resolve(events, segments, line())
    assert first.start_delay == pytest.approx(5.0 - 2.5)
    shifted = delay_segments(segments, first.start_delay)
    assert shifted[0].t_start == 0.0
    again = resolve(events, shifted, line())
    assert again.start_delay == 0.0
    assert min(e.t_trigger for e in again.events if e.t_trigger is not None) == pytest.approx(0.0)


@pytest.mark.parametrize("as_function", [False, True])
def test_arc_length_anchor_is_where_the_tool_has_travelled_that_far(as_function: bool) -> None:
    trajectory, segments = line(speed=0.5), pick()
    event = Event("valve", "on", Anchor(AnchorKind.ARC_LENGTH, 3, 0.2), 0.05)
    travel = (lambda t: 0.5 * t) if as_function else 0.5 * trajectory.times
    found = resolve([event], segments, trajectory, travel).events[0]
    assert found.t_anchor == pytest.approx(segments[3].t_start + 0.2 / 0.5)
    before = Event("valve", "on", Anchor(AnchorKind.ARC_LENGTH, 3, -0.2), 0.05)
    assert resolve([before], segments, trajectory, travel).events[0].t_anchor == pytest.approx(
        segments[3].t_start - 0.2 / 0.5
    )


def test_arc_length_during_a_rest_is_its_beginning() -> None:
    """Travel stands still from 2 s to 3 s: the place is reached at 2 s."""
    trajectory = line()
    travel = np.interp(trajectory.times, [0.0, 2.0, 3.0, 10.0], [0.0, 1.0, 1.0, 2.0])
    event = Event("valve", "on", Anchor(AnchorKind.ARC_LENGTH, 0, 1.0), 0.0)
    assert resolve([event], pick(), trajectory, travel).events[0].t_anchor == pytest.approx(2.0)


def test_arc_length_off_the_path_is_a_reason() -> None:
    event = Event("valve", "on", Anchor(AnchorKind.ARC_LENGTH, 0, 99.0), 0.0)
    resolution = resolve([event], pick(), line(), 0.5 * line().times)
    assert resolution.reasons[0].what == "anchor off the path"


def test_time_anchor_counts_from_its_segment() -> None:
    event = Event("valve", "on", Anchor(AnchorKind.TIME, 4, 0.25), 0.1)
    found = resolve([event], pick(), line()).events[0]
    assert (found.t_anchor, found.t_trigger) == pytest.approx((4.75, 4.65))
