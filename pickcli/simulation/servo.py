"""How the robot's joints follow their commands: a servo with a realistic lag, and the swing of the pivot."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Servo:
    """A position loop that follows its command late by ``lag`` and holds against gravity.

    In pybullet's motor a joint's next velocity is ``v + kd (v_target - v) + kp (q_target - q) / dt``. With
    kd = 1, no velocity target and kp = dt / lag that is a first-order lag, whatever the load (below the
    force limit) and the time step. All joints are late alike, so the tool stays on its path and trails by
    lag times speed, as on an industrial arm. A softer kd would sag under gravity: 10 mm at the tool for the
    gains that trail 2 mm.
    """

    lag: float = 2e-3  # s: 2 mm behind at a tool speed of 1 m/s

    def gains(self, time_step: float) -> tuple[float, float]:
        """(position gain, velocity gain) for the engine's motors at a time step in s."""
        return time_step / max(self.lag, time_step), 1.0


LAGGING = Servo(lag=20e-3)  # a worn or overloaded arm, ten times as late


@dataclass
class Swing:
    """The pivot's two-position actuator: turns at constant speed to the position last asked for."""

    position: float  # rad
    target: float  # rad
    speed: float  # rad/s

    def advance(self, time_step: float) -> float:
        """The position after one time step, rad."""
        step = self.speed * time_step
        self.position += min(max(self.target - self.position, -step), step)
        return self.position
