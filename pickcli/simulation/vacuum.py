"""Pressures in pump, valve, line and cup of a suction tool over time.

The pump evacuates the line up to the valve. Through the open valve the line evacuates a sealed cup; a leaking
or open cup lets air into the line. Pressures are Pa below ambient.

A pump of rate a (1/s) and a leak of conductance b keep the line at the share s = a / (a + b) of full vacuum,
which is how a face's seal is stated: so b = a (1 - s) / s, and the line approaches this pressure at rate a /
s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pickcli.cell.tools.lip_leak import FULL_VACUUM

LEAK_VACUUM = 4e3  # Pa kept by a running pump with the valve open and the cup unsealed
LEAK_TIME = 0.05  # s, time constant of venting the line through the open cup
HOLD_TIME = 20.0  # s, time constant of a closed line with the pump off
CUP_TIME = 0.04  # s, time constant of evacuating the small cup from the large line
VENT_TIME = 0.02  # s, time constant of venting the cup through the closed valve
TIME_CONSTANTS_TO_FULL = 4.0  # a pump's lead is the time to 98 % of the full vacuum


@dataclass
class Vacuum:
    """Pressures of the tool. All phases are exponential, so any step length is exact.

    Attributes:
        pump_lead: s from switching the pump on to full vacuum in the line.
        valve_lead: s from the command until the valve has switched.
        line: Pa below ambient in the line.
        cup: Pa below ambient in the cup.
        is_pump_on: Whether the pump runs.
        is_valve_open: Whether the valve is open.
    """

    pump_lead: float
    valve_lead: float
    line: float = 0.0
    cup: float = 0.0
    is_pump_on: bool = False
    is_valve_open: bool = False
    _is_open_wanted: bool = False
    _time_to_switch: float = 0.0

    def switch_pump(self, on: bool) -> None:
        """Command the pump.

        Args:
            on: Whether it runs.
        """
        self.is_pump_on = on

    def switch_valve(self, on: bool) -> None:
        """Command the valve; it acts after ``valve_lead``.

        Args:
            on: Whether it opens.
        """
        if on != self._is_open_wanted:
            self._is_open_wanted, self._time_to_switch = on, self.valve_lead

    def burst(self) -> None:
        """Break the seal: the cup is vented at once."""
        self.cup, self.line = 0.0, min(self.line, LEAK_VACUUM)

    def advance(self, time_step: float, seal: float) -> None:
        """Advance the simulation.

        Args:
            time_step: s.
            seal: Share of full vacuum that the pump can keep with the cup as it is closed: 1 is airtight, 0
                is open.
        """
        if self._is_open_wanted != self.is_valve_open:
            self._time_to_switch -= time_step
            if self._time_to_switch <= time_step / 2:
                self.is_valve_open = self._is_open_wanted
        self.line = _approach(self.line, *self._line_tendency(seal), time_step)
        if seal == 0.0:
            self.cup = 0.0
        elif self.is_valve_open:
            self.cup = _approach(self.cup, self.line, CUP_TIME, time_step)
        else:
            self.cup = _approach(self.cup, 0.0, VENT_TIME, time_step)

    def _line_tendency(self, seal: float) -> tuple[float, float]:
        """Pressure that the line approaches at present, and the time constant."""
        if self.is_valve_open and seal == 0.0:
            return (LEAK_VACUUM if self.is_pump_on else 0.0), LEAK_TIME
        share = seal if self.is_valve_open else 1.0
        pump = TIME_CONSTANTS_TO_FULL / self.pump_lead
        if self.is_pump_on:
            return share * FULL_VACUUM, share / pump
        return 0.0, 1.0 / (1.0 / HOLD_TIME + pump * (1.0 - share) / share)


def _approach(value: float, target: float, time_constant: float, time_step: float) -> float:
    return target + (value - target) * math.exp(-time_step / time_constant)
