"""Devices on the tool and how late they act."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class DeviceKind(StrEnum):
    """What a device does."""

    PUMP = "pump"
    VALVE = "valve"
    SENSOR = "sensor"
    TOOL_ACTUATOR = "tool_actuator"
    GRIPPER = "gripper"


@dataclass(frozen=True)
class Device:
    """One switched device.

    Attributes:
        name: Unique in the cell.
        kind: What it does.
        lead: s between the command and its full effect (a pump's time to full vacuum, a valve's switching).
        actions: E.g. ("on", "off"), ("read",), ("straight", "down"), ("open", "closed").
    """

    name: str
    kind: DeviceKind
    lead: float
    actions: tuple[str, ...]
