"""Pump, valve and line of the suction tool: a pressure over time, without any geometry."""

from __future__ import annotations

import math
from dataclasses import dataclass

FULL_VACUUM = 60e3  # Pa below ambient that the pump reaches on a closed line
LEAK_VACUUM = 4e3  # Pa that remains while the valve is open and nothing seals the cup
LEAK_TIME = 0.05  # s, time constant of losing the vacuum through the open cup
HOLD_TIME = 20.0  # s, time constant of a closed line with the pump off
SEAL_VACUUM = 30e3  # Pa below which a cup does not draw an item on, and the sensor says "nothing held"
TIME_CONSTANTS_TO_FULL = 4.0  # a pump's lead is the time to 98 % of the full vacuum


@dataclass
class Vacuum:
    """The line between pump and cup. Exact over any step length, so the time step does not matter.

    pump_lead: s from switching the pump on to full vacuum
    valve_lead: s from the command to the open or closed valve
    """

    pump_lead: float
    valve_lead: float
    pressure: float = 0.0  # Pa below ambient, before the valve
    is_pump_on: bool = False
    is_valve_open: bool = False
    _time_to_switch: float = 0.0
    _wanted_open: bool = False

    def switch_pump(self, on: bool) -> None:
        """Pump command."""
        self.is_pump_on = on

    def switch_valve(self, on: bool) -> None:
        """Valve command; it acts after ``valve_lead``."""
        if on != self._wanted_open:
            self._wanted_open, self._time_to_switch = on, self.valve_lead

    def advance(self, time_step: float, is_sealed: bool) -> None:
        """Let a time step in s pass; ``is_sealed``: whether something closes the cup."""
        if self._wanted_open != self.is_valve_open:
            self._time_to_switch -= time_step
            if self._time_to_switch <= 1e-9:
                self.is_valve_open = self._wanted_open
        target, time = self._tendency(is_sealed)
        self.pressure = target + (self.pressure - target) * math.exp(-time_step / time)

    def _tendency(self, is_sealed: bool) -> tuple[float, float]:
        if self.is_valve_open and not is_sealed:
            return (LEAK_VACUUM if self.is_pump_on else 0.0), LEAK_TIME
        if self.is_pump_on:
            return FULL_VACUUM, self.pump_lead / TIME_CONSTANTS_TO_FULL
        return 0.0, HOLD_TIME

    @property
    def at_cup(self) -> float:
        """Pa below ambient in a sealed cup: the line's while the valve is open, else nothing."""
        return self.pressure if self.is_valve_open else 0.0
