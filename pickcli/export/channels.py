"""Devices of a cell on numbered digital outputs and inputs of a robot's controller."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from pickcli.cell.device import Device, DeviceKind
from pickcli.errors import InputError, UnknownNameError

N_CHANNELS = 8  # outputs, and as many inputs, of a controller of Universal Robots


@dataclass(frozen=True)
class Channel:
    """One device on one output, or a sensor on one input.

    Attributes:
        number: Of the output or input.
        is_input: Whether the device is read.
        action_on: The action that switches the output on; of a sensor the one that reads it.
    """

    number: int
    is_input: bool
    action_on: str


def channels(devices: Mapping[str, Device], chosen: Mapping[str, int]) -> dict[str, Channel]:
    """The channel of every device.

    Where nothing is chosen, devices take the numbers that are free in the order of the cell file: sensors
    those of inputs, all others those of outputs. An output is on for the action "on", and of a device without
    one for the second of its two actions.

    Args:
        devices: Devices of a cell, by name.
        chosen: Numbers that the user chose, by name.

    Returns:
        By name, in the order of the cell file.

    Raises:
        InputError: A number is out of range or taken twice, or a device has no two actions to tell apart.
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
