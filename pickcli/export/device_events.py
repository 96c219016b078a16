"""Device events of a plan with the times of their commands."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.errors import InputError, UnknownNameError
from pickcli.export.samples import to_nanoseconds
from pickcli.motion.plan import Plan


@dataclass(frozen=True)
class DeviceEvent:
    """A command to a device.

    Attributes:
        nanoseconds: Time since the start of the motion.
        device: Name of a device of the cell.
        action: One of its actions.
        kind: Kind of the device.
        lead: s from the command to its full effect.
    """

    nanoseconds: int
    device: str
    action: str
    kind: DeviceKind
    lead: float


def device_events(plan: Plan, cell: Cell) -> tuple[DeviceEvent, ...]:
    """Return the events of a plan in the order of their commands.

    Args:
        plan: The plan.
        cell: Its cell.

    Returns:
        The events; if equal in time, in the plan's order.

    Raises:
        InputError: An event has no time yet, or the cell has no such device.
    """
    found = []
    for event in plan.events:
        if event.device not in cell.devices:
            raise UnknownNameError("device", event.device, sorted(cell.devices))
        if event.t_trigger is None:
            raise InputError(f"event {event.device} {event.action}: has no time yet; plan it again")
        kind = cell.devices[event.device].kind
        at = to_nanoseconds(event.t_trigger)
        found.append(DeviceEvent(at, event.device, event.action, kind, event.lead))
    return tuple(sorted(found, key=lambda event: event.nanoseconds))
