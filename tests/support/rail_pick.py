"""A plan by hand: a frontal pick with the rail alone, 40 mm forward onto the item and 0.3 m back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from support.pedestal import start
from support.tool_states import STRAIGHT

GAP = 0.04  # m from the cup to the item at the start
OVERTRAVEL = 0.003  # m
SPEED = 0.075  # m/s of the contact
T_SLOW, T_CONTACT, T_LIFT, T_READ, T_END = 0.8, 0.94, 1.19, 2.19, 2.69  # s


def rail_pick(cell: Cell, valve_shift: float = 0.0, distance: float = 0.3) -> Plan:
    """valve_shift: s that the valve opens later than planned (earlier, if negative)."""
    q = start(cell)
    on, slow = GAP + OVERTRAVEL, GAP + OVERTRAVEL - 0.0045
    rail = np.array([0.0, slow, on, on, on - distance, GAP - distance])
    direction = (np.arange(8) == 0).astype(float)
    times = np.array([0.0, T_SLOW, T_CONTACT, T_LIFT, T_READ, T_END])
    speeds = np.array([0.0, SPEED, 0.0, 0.0, 0.0, 0.0])
    still = np.zeros((len(times), 8))
    trajectory = Trajectory(
        cell.robot.joint_names, times, q + np.outer(rail, direction), np.outer(speeds, direction), still
    )
    straight = STRAIGHT
    segments = (
        Segment(SegmentKind.CONTACT, 0.0, T_LIFT, straight, None, ("cube",)),
        Segment(SegmentKind.RETREAT, T_LIFT, T_READ, straight, "cube", ("cube", "pedestal")),
        Segment(SegmentKind.TRANSFER, T_READ, T_END, straight, "cube"),
    )
    events = (
        event("valve", "on", 0, T_CONTACT, 0.05 - valve_shift),
        event("vacuum_sensor", "read", 1, T_READ, 0.0),
        event("valve", "off", 2, T_END - 0.1, 0.05),
    )
    return Plan("rail pick", cell.fingerprint, "", 0, segments, trajectory, events)


def event(device: str, action: str, segment: int, t_anchor: float, lead: float) -> Event:
    """An event at a time of the plan, resolved."""
    anchor = Anchor(AnchorKind.SEGMENT_END, segment)
    return replace(Event(device, action, anchor, lead), t_anchor=t_anchor, t_trigger=t_anchor - lead)
