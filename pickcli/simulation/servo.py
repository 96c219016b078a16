"""How the robot's joints follow their commands, and the swing of the tool's joint.

A joint's position loop asks for the velocity (command - position) / lag; its motor reaches that within a time
step as far as the torque suffices. So a joint follows as a first-order lag, and below its limits nothing sags
at rest. What makes a real arm leave its path is that the joints do not lag alike:

- every joint has a lag of its own, up to ``spread`` off the common one;
- the lag grows with the share of the motor's torque that is in use, up to ``load_lag`` of it at full torque:
  an arm that is loaded follows later;
- the torque is finite (``motor_forces`` of the cell), and so is the drive's speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

LOAD_TIME = 0.25  # s over which the load on a motor is averaged
UNLIMITED = 1e9  # N or Nm


@dataclass(frozen=True)
class Servo:
    """How well the joints follow.

    Attributes:
        lag: s; 2 ms are 2 mm behind at a tool speed of 1 m/s.
        spread: How far a joint's own lag is off, at most, as a share.
        load_lag: Share by which the lag grows at full motor torque.
        speed: Ceiling of a drive's speed, as a share of the joint's velocity limit.
        has_finite_torque: Whether motors end at the cell's ``motor_forces``.
    """

    lag: float = 2e-3
    spread: float = 0.2
    load_lag: float = 1.0
    speed: float = 1.05
    has_finite_torque: bool = True

    def own_lags(self, joint_names: tuple[str, ...]) -> Array:
        """Unloaded lag of each joint, the same for a joint of that name in every world.

        Args:
            joint_names: Names of n joints.

        Returns:
            (n,) s.
        """
        off = [float(derived_rng("servo", name).uniform(-1.0, 1.0)) for name in joint_names]
        return self.lag * (1.0 + self.spread * np.array(off))


IDEAL = Servo(spread=0.0, load_lag=0.0, speed=np.inf, has_finite_torque=False)


class Drives:
    """The position loops of one robot's planned joints.

    Args:
        servo: How well they follow.
        joint_names: Of the planned joints.
        limits: Of their motion.
        forces: (n,) largest motor force of each, N or Nm.
        time_step: s.
    """

    def __init__(
        self, servo: Servo, joint_names: tuple[str, ...], limits: Limits, forces: Array, time_step: float
    ) -> None:
        self._servo, self._time_step = servo, time_step
        self._lags = servo.own_lags(joint_names)
        self._ceiling = servo.speed * limits.velocity
        self.forces = forces if servo.has_finite_torque else np.full(len(forces), UNLIMITED)
        self._use = np.zeros(len(forces))  # share of the force in use, averaged

    def velocities(self, command: Array, q: Array, torques: Array) -> Array:
        """Velocities for the motors in the next step.

        Args:
            command: (n,) where the joints should be at the end of the step.
            q: (n,) where they are.
            torques: (n,) what the motors exerted in the last step, N or Nm.

        Returns:
            (n,) rad/s or m/s.
        """
        self._use += self._time_step / LOAD_TIME * (np.abs(torques) / self.forces - self._use)
        lags = self._lags * (1.0 + self._servo.load_lag * self._use)
        wanted = (command - q) / np.maximum(lags, self._time_step)
        return np.clip(wanted, -self._ceiling, self._ceiling)


@dataclass
class ToolDrive:
    """The actuator of the tool's joint: it turns at constant speed to the position last asked for.

    Attributes:
        position: rad.
        target: rad.
        speed: rad/s.
    """

    position: float
    target: float
    speed: float

    def advance(self, time_step: float) -> float:
        """The position after one time step.

        Args:
            time_step: s.

        Returns:
            rad.
        """
        step = self.speed * time_step
        self.position += min(max(self.target - self.position, -step), step)
        return self.position
