"""Devices on the tool and their lead times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum

from pickcli.cell.item import REFERENCE_FLOW
from pickcli.errors import InputError


class DeviceKind(StrEnum):
    """Kind of a device."""

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
        kind: Kind of the device.
        lead: s between the command and its full effect (a pump's time to full vacuum, a valve's switching).
        actions: E.g. ("on", "off"), ("read",), ("straight", "down"), ("open", "closed").
        flow: l/min of free air that a pump draws; without meaning for other devices.
    """

    name: str
    kind: DeviceKind
    lead: float
    actions: tuple[str, ...]
    flow: float = REFERENCE_FLOW


def pump_flow(devices: Iterable[Device]) -> float:
    """Return the flow of the weakest pump, for which the seals of all items are to hold.

    Args:
        devices: Devices of a cell.

    Returns:
        l/min of free air; that of the reference pump if there is no pump.
    """
    return min((each.flow for each in devices if each.kind is DeviceKind.PUMP), default=REFERENCE_FLOW)


def device_of(devices: Mapping[str, Device], kind: DeviceKind) -> Device:
    """Return the first device of a kind.

    Args:
        devices: Devices of the cell, by name.
        kind: The kind.

    Returns:
        The device.

    Raises:
        InputError: The cell has none of this kind.
    """
    for device in devices.values():
        if device.kind is kind:
            return device
    raise InputError(
        f"the cell has no {kind.value}: a pick needs one, add it under `devices` in its cell.yaml"
    )
