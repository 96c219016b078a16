"""How the robot's joints follow their commands, and what moves those of the tool.

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
from typing import Protocol

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

LOAD_TIME = 0.25  # s over which the load on a motor is averaged
UNLIMITED = 1e9  # N or Nm
AT_WIDTH = 1e-3  # m between the pads within which fingers have arrived
STALLED, STALL_TIME = 5e-3, 0.01  # m/s of the width, averaged over so many s, below which fingers stand
STANDING = 5e-4  # m by which the width then changes before they count as moving again
PRESSING_SPEED = 0.2  # m/s that motors of stopped fingers ask for: asked for less, the engine's solver, which
# goes through all motors and contacts a limited number of times, does not come to their force


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
        self._floor = -self._ceiling
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
        return np.minimum(np.maximum(wanted, self._floor), self._ceiling)


class ToolDrive(Protocol):
    """What moves the joints that the state of the tool moves."""

    @property
    def forces(self) -> Array:
        """(k,) what their motors exert at most, N or Nm."""

    def command(self, position: float) -> None:
        """Go to a state.

        Args:
            position: Its position, or width.
        """

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Velocities for the motors in the next step.

        Args:
            measured: (k,) where the joints are.
            time_step: s.

        Returns:
            (k,) rad/s or m/s.
        """


class CupDrive:
    """The actuator of the cup's joint: it turns at constant speed to the position last asked for.

    Args:
        position: Where it stands, rad or m.
        speed: rad/s or m/s.
        force: N or Nm.
        lag: s by which the joint follows.
    """

    def __init__(self, position: float, speed: float, force: float, lag: float) -> None:
        self._force = force
        self._position, self._target, self._speed, self._lag = position, position, speed, lag

    @property
    def forces(self) -> Array:
        """(1,) what its motor exerts at most, N or Nm."""
        return np.array([self._force])

    def command(self, position: float) -> None:
        """Go to a state.

        Args:
            position: rad or m.
        """
        self._target = position

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Velocity for the motor in the next step.

        Args:
            measured: (1,) where the joint is.
            time_step: s.

        Returns:
            (1,) rad/s or m/s.
        """
        step = self._speed * time_step
        self._position += min(max(self._target - self._position, -step), step)
        return np.asarray((self._position - measured) / max(self._lag, time_step))


class FingerDrive:
    """The drive of two fingers that mirror each other: constant speed, as far as its force suffices.

    Attributes:
        force: N with which each finger presses on what stops it.
        width: m between the pads, as the encoder has it.

    Args:
        gripper: The fingers.
        width: m between the pads at the start.
        delay: s from a command until they begin to move.
        lag: s by which they follow.
    """

    def __init__(self, gripper: ParallelGripper, width: float, delay: float, lag: float) -> None:
        self._gripper, self._delay, self._lag = gripper, delay, lag
        self.force = gripper.limits.force
        self.width = width
        self._target, self._next, self._wait = width, width, 0.0
        self._speed = 0.0  # m/s at which the width changes, averaged
        self._stood_at: float | None = width  # m, the width at which the fingers came to stand
        self._stand: float | None = None  # m, the width at which something sticks to the pads

    @property
    def forces(self) -> Array:
        """(2,) what the motors exert at most, N."""
        return np.full(2, self.force)

    @property
    def is_opening(self) -> bool:
        """Whether the fingers go, or have gone, to a greater width than they stand at."""
        return self._target > self.width + AT_WIDTH

    @property
    def is_stopped(self) -> bool:
        """Whether the fingers stand at a greater width than they were told to close to."""
        return self.is_standing and self.width > self._target + AT_WIDTH

    @property
    def is_standing(self) -> bool:
        """Whether the fingers do not move, and are not about to."""
        return self._wait <= 0.0 and self._stood_at is not None

    def command(self, position: float) -> None:
        """Go to a width.

        Args:
            position: m between the pads.
        """
        self._next, self._wait = position, self._delay
        self._speed, self._stood_at = self._gripper.closing_speed, None  # they are about to move

    def stand(self, is_standing: bool) -> None:
        """Stand where the fingers are, on something that sticks to them, or press on.

        Args:
            is_standing: Whether to stand.
        """
        self._stand = self.width if is_standing else None

    def velocities(self, measured: Array, time_step: float) -> Array:
        """Velocities for the motors in the next step.

        Args:
            measured: (2,) m, where the joints are.
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
        """Note where the fingers come to stand, and that they move again."""
        if self._stood_at is None:
            self._stood_at = self.width if self._speed < STALLED else None
        elif abs(self.width - self._stood_at) > STANDING:
            self._speed, self._stood_at = self._gripper.closing_speed, None
