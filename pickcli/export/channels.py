"""Assigns a cell's devices to numbered digital outputs and inputs of a robot controller."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pickcli.cell.device import Device, DeviceKind
from pickcli.errors import InputError, UnknownNameError

N_CHANNELS = 8  # digital outputs, and as many inputs, of a Universal Robots controller


@dataclass(frozen=True)
class Channel:
    """One device on one output, or a sensor on one input.

    Attributes:
        number: Number of the output or input.
        is_input: Whether it is an input.
        action_on: Action that switches the output on; for a sensor the action that reads it.
    """

    number: int
    is_input: bool
    action_on: str


def channels(devices: Mapping[str, Device], chosen: Mapping[str, int]) -> dict[str, Channel]:
    """Assign a channel to every device.

    Devices without a chosen number take the free ones in the order of the cell file: sensors those of inputs,
    all others those of outputs. An output is on for the action "on", or else for the second of the device's
    two actions.

    Args:
        devices: Devices of a cell, by name.
        chosen: Numbers chosen by the user, by name.

    Returns:
        Channels by name, in the order of the cell file.

    Raises:
        InputError: A number is out of range or used twice, or an output device does not have two actions.
    """
    for name, number in chosen.items():
        if name not in devices:
            raise UnknownNameError("device", name, sorted(devices))
        if not 0 <= number < N_CHANNELS:
            raise InputError(f"channel {name}={number}: expected 0 to {N_CHANNELS - 1}; name one of these")
    found = {}
    for are_inputs in (False, True):
        group = {n: d for n, d in devices.items() if (d.kind is DeviceKind.SENSOR) == are_inputs}
        numbers = _numbers(tuple(group), chosen, "input" if are_inputs else "output")
        found.update(
            {name: Channel(numbers[name], are_inputs, _action_on(device)) for name, device in group.items()}
        )
    return {name: found[name] for name in devices}


def _numbers(names: tuple[str, ...], chosen: Mapping[str, int], what: str) -> dict[str, int]:
    taken: dict[int, str] = {}
    for name in (name for name in names if name in chosen):
        other = taken.setdefault(chosen[name], name)
        if other != name:
            raise InputError(
                f"channel {name}={chosen[name]}: {other} has that {what}; name different ones for the two"
            )
    free = iter([number for number in range(len(names) + N_CHANNELS) if number not in taken])
    numbers = {name: chosen[name] if name in chosen else next(free) for name in names}
    if beyond := [name for name, number in numbers.items() if number >= N_CHANNELS]:
        raise InputError(f"device {beyond[0]}: no {what} is left for it, there are {N_CHANNELS}")
    return numbers


def _action_on(device: Device) -> str:
    if device.kind is DeviceKind.SENSOR:
        return device.actions[0]
    if len(device.actions) != 2:
        raise InputError(
            f"device {device.name}: has {len(device.actions)} actions, and one digital output tells two "
            "apart; export to another format"
        )
    return "on" if "on" in device.actions else device.actions[1]
