"""A conveyor that runs in the simulated world, with the encoder that measures its travel."""

from __future__ import annotations

from collections import deque

from pickcli.cell.conveyor import Conveyor
from pickcli.simulation.engine import Engine


class RunningBelt:
    """A running belt.

    Args:
        engine: The engine with the belt.
        body: Name of its body.
        conveyor: The figures of the conveyor.
        speed: m/s at which it runs.

    Attributes:
        speed: m/s at which it is driven.
    """

    def __init__(self, engine: Engine, body: str, conveyor: Conveyor, speed: float) -> None:
        self._engine, self._body, self._resolution = engine, body, conveyor.encoder_resolution
        self.speed = self._wanted = speed
        self._acceleration = 0.0
        n_old = round(conveyor.encoder_latency / engine.time_step)
        # Before the world began, the belt ran at its speed.
        self._travels = deque((-k * engine.time_step * speed for k in range(n_old, -1, -1)), n_old + 1)

    def change_speed(self, speed: float, acceleration: float) -> None:
        """Let the belt come to another speed.

        Args:
            speed: m/s.
            acceleration: m/s^2 at which it does so.
        """
        self._wanted, self._acceleration = speed, acceleration

    def before_step(self) -> None:
        """Drive the belt; call before a step."""
        if self.speed != self._wanted:
            most = self._acceleration * self._engine.time_step
            self.speed += min(max(self._wanted - self.speed, -most), most)
            self._engine.drive_belt(self._body, self.speed)

    def after_step(self) -> None:
        """Measure the travel; call after a step."""
        self._travels.append(self._engine.belt_position(self._body))

    @property
    def travel(self) -> float:
        """Reading of the encoder, m: whole counts, as old as its latency."""
        return self._resolution * round(self._travels[0] / self._resolution)
