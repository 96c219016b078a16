"""How the robot's joints follow their commands: a servo with a realistic lag, and the swing of the pivot."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Servo:
    """A critically damped position loop with velocity feed-forward.

    In pybullet's motor a joint's next velocity is ``v + kd (v_target - v) + kp (q_target - q) / dt``, so
    the error obeys e'' + (kd/dt) e' + (kp/dt^2) e = acceleration. Choosing bandwidth and damping instead of
    the gains makes the servo independent of the time step; under an acceleration a it lags by
    a / bandwidth^2: 70 rad/s lags 2 mm at a tool that accelerates with 10 m/s^2, as was measured for
    kp 0.1 and kd 0.5 at 240 Hz.
    """

    bandwidth: float = 70.0  # rad/s
    damping: float = 1.0

    def gains(self, time_step: float) -> tuple[float, float]:
        """(position gain, velocity gain) for the engine's motors at a time step in s."""
        x = self.bandwidth * time_step
        return x * x, 2.0 * self.damping * x


LAGGING = Servo(bandwidth=20.0)  # a worn or overloaded arm: about 25 mm at the tool instead of 2


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
