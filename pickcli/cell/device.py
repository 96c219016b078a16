"""Devices on the tool and how late they act."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from pickcli.errors import InputError


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


def device_of(devices: Mapping[str, Device], kind: DeviceKind) -> Device:
    """The first device of a kind.

    Args:
        devices: Devices of the cell, by name.
        kind: What the device is for.

    Returns:
        The device.

    Raises:
        InputError: If the cell has none.
    """
    for device in devices.values():
        if device.kind is kind:
            return device
    raise InputError(
        f"the cell has no {kind.value}: a pick needs one, add it under `devices` in its cell.yaml"
    )
