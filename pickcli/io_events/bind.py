"""Binding of the events of a pick to its segments (Delft, section 3.1).

An event is bound to an anchor, a place on the path, and to a device, which has a lead. Stitching and timing
move anchors in time, but keep their meaning: the vacuum is complete when the cup is pressed on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from pickcli.cell.device import Device, DeviceKind, device_of
from pickcli.cell.tool import MOVING, Tool
from pickcli.errors import InputError
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.segment import Segment, SegmentKind


def bind_pick(
    segments: Sequence[Segment],
    devices: Mapping[str, Device],
    tool: Tool,
    seal_time: float = 0.0,
    release_time: float = 0.0,
) -> tuple[Event, ...]:
    """Bind all events of a pick: vacuum on, sensor, vacuum off, and the changes of the tool's state.

    Missing parts of a pick have no events: without a contact segment nothing is switched on, without a
    release nothing off. Fingers hold and release only by their state.

    Args:
        segments: Segments of the pick, with their times.
        devices: Devices of the cell, by name.
        tool: The tool that holds.
        seal_time: s at rest at the end of the contact; the vacuum is complete at the start of this rest.
        release_time: s at rest at the end of the last segment with the item; the valve is closed at its
            start.

    Returns:
        The events, unresolved.

    Raises:
        InputError: If the cell lacks a required device.
    """
    changes = bind_tool_states(segments, devices, tool)
    if not tool.grip.holds_by_vacuum:
        return changes
    return (*_grasp(segments, devices, seal_time), *_release(segments, devices, release_time), *changes)


def bind_tool_states(
    segments: Sequence[Segment], devices: Mapping[str, Device], tool: Tool
) -> tuple[Event, ...]:
    """Bind changes of the tool's state: each begins with the segment in which the tool may be in any state.

    The earliest start leaves the most time before the next segment relies on the state. So fingers close on
    an item, and open from it, in a segment in which the arm rests for that long.

    Args:
        segments: Segments of the motion, with their times.
        devices: Devices of the cell, by name.
        tool: The tool, which states its actuator and the action for each state.

    Returns:
        The events, unresolved.
    """
    events = []
    for index, (before, after) in enumerate(pairwise([None, *segments, None])):
        # index counts segments: ``after`` is segments[index].
        is_change = after is not None and after.tool_state == MOVING
        if not is_change or (before is not None and before.tool_state == MOVING):
            continue
        resting = next((s.tool_state for s in segments[index:] if s.tool_state != MOVING), None)
        if resting is not None:
            device = device_of(devices, tool.mover)
            anchor = Anchor(AnchorKind.SEGMENT_START, index, device.lead)
            events.append(_event(device, tool.command(resting), anchor))
    return tuple(events)


def _grasp(segments: Sequence[Segment], devices: Mapping[str, Device], seal_time: float) -> tuple[Event, ...]:
    """Bind pump and valve on before the cup is pressed on, and the sensor read after the extraction.

    The sensor is read at the end of the retreat, or of the lift if there is no retreat.
    """
    contact = _last(segments, SegmentKind.CONTACT)
    if contact is None:
        return ()
    pressed = Anchor(AnchorKind.SEGMENT_END, contact, -seal_time)
    pump, valve = device_of(devices, DeviceKind.PUMP), device_of(devices, DeviceKind.VALVE)
    events = (_event(pump, "on", pressed), _event(valve, "on", pressed))
    ways_out = [_last(segments, kind) for kind in (SegmentKind.RETREAT, SegmentKind.LIFT)]
    out = next((k for k in ways_out if k is not None), None)
    if out is None:
        return events
    sensor = device_of(devices, DeviceKind.SENSOR)
    return (*events, _event(sensor, "read", Anchor(AnchorKind.SEGMENT_END, out)))


def _release(
    segments: Sequence[Segment], devices: Mapping[str, Device], release_time: float
) -> tuple[Event, ...]:
    """Bind valve off, complete when the robot rests over the tote, and pump off, commanded at that time.

    A pump's lead is its time to full effect, which is irrelevant here, so its anchor is one lead later and
    the command coincides with the closed valve.
    """
    holding = [index for index, segment in enumerate(segments) if segment.held is not None]
    if not holding or segments[-1].held is not None:
        return ()
    pump, valve = device_of(devices, DeviceKind.PUMP), device_of(devices, DeviceKind.VALVE)
    at_rest = Anchor(AnchorKind.SEGMENT_END, holding[-1], -release_time)
    afterwards = Anchor(AnchorKind.SEGMENT_END, holding[-1], pump.lead - release_time)
    return (_event(valve, "off", at_rest), _event(pump, "off", afterwards))


def _event(device: Device, action: str, anchor: Anchor) -> Event:
    if action not in device.actions:
        raise InputError(
            f"device {device.name} cannot {action!r}, only {', '.join(device.actions)}: "
            "correct its `actions` in the cell.yaml"
        )
    return Event(device.name, action, anchor, device.lead)


def _last(segments: Sequence[Segment], kind: SegmentKind) -> int | None:
    return max((index for index, segment in enumerate(segments) if segment.kind is kind), default=None)
