"""Servo control of the robot's joints, and drives of the tool's joints.

A joint's position loop demands the velocity (command - position) / lag; its motor reaches that within a time
step if its torque suffices. So a joint follows with a first-order lag, and below its limits there is no
steady-state error. Real arms leave their path because the joints lag differently:

- every joint has its own lag, up to ``spread`` from the common one;
- the lag increases with the used share of the motor's torque, up to ``load_lag`` at full torque: a loaded arm
  lags more;
- torque is limited (``motor_forces`` of the cell), and so is the drive's speed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

LOAD_TIME = 0.25  # s over which the load on a motor is averaged
UNLIMITED = 1e9  # N or Nm
AT_WIDTH = 1e-3  # m, tolerance of the width at which fingers have arrived
STALLED, STALL_TIME = 5e-3, 0.01  # m/s of the width, averaged over s: below it fingers count as stopped
WIDTH_TOLERANCE = 5e-4  # m of change in width after which stopped fingers count as moving again
PRESSING_SPEED = 0.2  # m/s demanded from motors of stopped fingers: with less, the solver, which has a
# limited number of iterations over all motors and contacts, does not reach their full force


@dataclass(frozen=True)
class Servo:
    """Parameters of how joints follow their commands.

    Attributes:
        lag: s; 2 ms are 2 mm behind at a tool speed of 1 m/s.
        spread: Largest deviation of a joint's own lag, as a share.
        load_lag: Increase of the lag at full motor torque, as a share.
        speed: Limit of a drive's speed, as a share of the joint's velocity limit.
        has_finite_torque: Whether motor torque is limited to the cell's ``motor_forces``.
    """

    lag: float = 2e-3
    spread: float = 0.2
    load_lag: float = 1.0
    speed: float = 1.05
    has_finite_torque: bool = True

    def own_lags(self, joint_names: tuple[str, ...]) -> Array:
        """Return the unloaded lag of each joint; it depends only on the joint's name.

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
        servo: Parameters of following.
        joint_names: Names of the planned joints.
        limits: Motion limits of the planned joints.
        forces: (n,) largest motor effort of each, N or Nm.
        time_step: s.
    """

    def __init__(
        self, servo: Servo, joint_names: tuple[str, ...], limits: Limits, forces: Array, time_step: float
    ) -> None:
        self._servo, self._time_step = servo, time_step
        self._lags = servo.own_lags(joint_names)
        self._ceiling = servo.speed * limits.velocity
        self._floor = -self._ceiling
        self.forces = forces if servo.has_finite_torque else np.full(len(forces), UNLIMITED)
        self._use = np.zeros(len(forces))  # share of the force in use, averaged

    def velocities(self, command: Array, q: Array, torques: Array) -> Array:
        """Compute velocity commands of the motors for the next step.

        Args:
            command: (n,) target positions at the end of the step.
            q: (n,) measured positions.
            torques: (n,) motor efforts in the last step, N or Nm.

        Returns:
            (n,) rad/s or m/s.
        """
        self._use += self._time_step / LOAD_TIME * (np.abs(torques) / self.forces - self._use)
        lags = self._lags * (1.0 + self._servo.load_lag * self._use)
        wanted = (command - q) / np.maximum(lags, self._time_step)
        return np.minimum(np.maximum(wanted, self._floor), self._ceiling)


class ToolDrive(Protocol):
    """Drive of the joints that the tool's state moves."""

    @property
    def forces(self) -> Array:
        """Largest efforts (k,) of the motors, N or Nm."""

    def command(self, position: float) -> None:
        """Command a state.

        Args:
            position: Its position or width.
        """

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Compute velocity commands of the motors for the next step.

        Args:
            measured: (k,) joint positions.
            time_step: s.

        Returns:
            (k,) rad/s or m/s.
        """


class CupDrive:
    """Actuator of the cup's joint, with cushioned ends: it moves along the quintic from rest to rest.

    Args:
        position: Initial position, rad or m.
        duration: s of a move from one state to another.
        force: N or Nm.
        lag: s, lag of the joint.
    """

    def __init__(self, position: float, duration: float, force: float, lag: float) -> None:
        self._force, self._lag = force, lag
        self._from, self._target, self._t, self._duration = position, position, 0.0, duration

    @property
    def forces(self) -> Array:
        """Largest effort (1,) of the motor, N or Nm."""
        return np.array([self._force])

    def command(self, position: float) -> None:
        """Command a position.

        Args:
            position: rad or m.
        """
        if position == self._target:
            return
        self._from, self._target, self._t = self._position, position, 0.0

    @property
    def _position(self) -> float:
        """Position that the actuator is at now, rad or m."""
        share = 1.0 if self._t >= self._duration else self._t / self._duration
        return self._from + (self._target - self._from) * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Compute the velocity command of the motor for the next step.

        Args:
            measured: (1,) joint position.
            time_step: s.

        Returns:
            (1,) rad/s or m/s.
        """
        self._t += time_step
        return np.asarray((self._position - measured) / max(self._lag, time_step))


class FingerDrive:
    """Drive of two fingers that mirror each other, with constant speed and limited force.

    Attributes:
        force: N with which each finger presses on an item.
        width: m between the pads, by the encoder.

    Args:
        gripper: The gripper.
        width: m between the pads at the start.
        delay: s from a command until the fingers begin to move.
        lag: s, lag of the fingers.
    """

    def __init__(self, gripper: ParallelGripper, width: float, delay: float, lag: float) -> None:
        self._gripper, self._delay, self._lag = gripper, delay, lag
        self.force = gripper.limits.force
        self.width = width
        self._target, self._next, self._wait = width, width, 0.0
        self._speed = 0.0  # m/s, averaged rate of change of the width
        self._stood_at: float | None = width  # m, the width at which the fingers stopped
        self._stand: float | None = None  # m, the width to hold while an item sticks to the pads

    @property
    def forces(self) -> Array:
        """Largest efforts (2,) of the motors, N."""
        return np.full(2, self.force)

    @property
    def is_opening(self) -> bool:
        """Whether the commanded width is greater than the present one."""
        return self._target > self.width + AT_WIDTH

    @property
    def is_stopped(self) -> bool:
        """Whether the fingers stopped at a greater width than commanded."""
        return self.is_standing and self.width > self._target + AT_WIDTH

    @property
    def is_standing(self) -> bool:
        """Whether the fingers are at rest, and no motion is pending."""
        return self._wait <= 0.0 and self._stood_at is not None

    def command(self, position: float) -> None:
        """Command a width.

        Args:
            position: m between the pads.
        """
        self._next, self._wait = position, self._delay
        self._speed, self._stood_at = self._gripper.closing_speed, None  # motion is pending

    def stand(self, is_standing: bool) -> None:
        """Hold the present width, on an item that sticks to the pads, or press on.

        Args:
            is_standing: Whether to hold the width.
        """
        self._stand = self.width if is_standing else None

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Compute velocity commands of the motors for the next step.

        Args:
            measured: (2,) m, joint positions.
            time_step: s.

        Returns:
            (2,) m/s.
        """
        fingers = self._gripper.fingers
        before, self.width = self.width, self._gripper.width_at(measured)
        speed = abs(self.width - before) / time_step
        if self._wait > 0.0:
            self._wait -= time_step
        else:
            self._target = self._next
            self._speed += time_step / STALL_TIME * (speed - self._speed)
            self._note_stand()
        width = self._target if self._stand is None else self._stand
        targets = np.array([self._gripper.joint_position(finger.joint, width) for finger in fingers])
        most = PRESSING_SPEED if self.is_stopped else self._gripper.closing_speed / 2
        return np.clip((targets - measured) / max(self._lag, time_step), -most, most)

    def _note_stand(self) -> None:
        """Update the width at which the fingers stopped, or clear it if they move again."""
        if self._stood_at is None:
            self._stood_at = self.width if self._speed < STALLED else None
        elif abs(self.width - self._stood_at) > WIDTH_TOLERANCE:
            self._speed, self._stood_at = self._gripper.closing_speed, None
