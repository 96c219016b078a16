"""Stages of what a hand does, one after the other, until the last one or a stop by a torque threshold.

The controller knows currents and encoders of the motors, the encoders of the fingers' joints, and the torques
and the motion with which the hand is held; it does not know where objects are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.grasp_world import TIME_STEP
from pickcli.hand.simulated_hand import SimulatedHand

BLOCKED = 0.2  # share of its speed below which a belt is blocked
SETTLED = 0.2  # s after a motion in which the arm comes to rest
OPENING_TIME = 4.0  # s, after which opening is given up


class StageName(StrEnum):
    """Stages of a grasp and of its release, in order."""

    APPROACH = "approach"
    CLOSING = "closing"
    SEPARATION = "separation"
    PULL_IN = "pull-in"
    FIRM = "firm grasp"
    LIFT = "lift"
    LOWERING = "lowering"
    OPENING = "opening"
    BACKING = "backing off"


@dataclass(frozen=True)
class GraspStage:
    """A stage as it went.

    Attributes:
        name: The stage.
        start: s.
        end: s.
        ended_by: What ended it.
        current: A of the closing motor at its end.
        angle: rad of the closing motor at its end.
        blocked: Links whose belts were blocked at its end.
        slipping: Links whose belts slipped on an object at its end.
    """

    name: StageName
    start: float
    end: float
    ended_by: str
    current: float
    angle: float
    blocked: tuple[str, ...]
    slipping: tuple[str, ...]


class HandWorld(Protocol):
    """A simulated world with a hand.

    Attributes:
        hand: The hand.
    """

    hand: SimulatedHand

    @property
    def time(self) -> float:
        """Time (s) since the start."""

    def step(self) -> None:
        """Advance by ``TIME_STEP``."""


class ThresholdError(Exception):
    """A force or torque of the arm is beyond its threshold."""


class StagedExecution:
    """What stages of any kind share.

    Attributes:
        stages: Stages so far.
        is_stopped: Whether a torque beyond its threshold stopped the arm.

    Args:
        world: The world.
        on_step: Called after every step.
    """

    def __init__(self, world: HandWorld, on_step: Callable[[], None] = lambda: None) -> None:
        self.world, self.hand, self._on_step = world, world.hand, on_step
        self.control = world.hand.hand.control
        self.stages: list[GraspStage] = []
        self.is_stopped = False

    def carry_out(self, act: Callable[[], None]) -> None:
        """Carry out stages until they end, or a torque stops them.

        Args:
            act: Carries out the stages.
        """
        try:
            act()
        except ThresholdError:
            self.is_stopped = True

    def stage(self, name: StageName, act: Callable[[], str]) -> None:
        """Carry out a stage, and record it.

        Args:
            name: The stage.
            act: Carries it out, and tells what ended it.

        Raises:
            ThresholdError: A torque is beyond its threshold.
        """
        start, ended_by = self.world.time, "torque threshold"
        try:
            ended_by = act()
        finally:
            motor = self.hand.motor
            self.stages.append(
                GraspStage(
                    name,
                    start,
                    self.world.time,
                    ended_by,
                    motor.current,
                    motor.angle,
                    self.blocked(),
                    self.hand.slipping,
                )
            )

    def step(self) -> None:
        """Advance by a step. Raises ThresholdError."""
        self.world.step()
        self._on_step()
        if self.hand.wrist.is_overloaded:
            raise ThresholdError

    def wait(self, seconds: float) -> None:
        """Let time pass.

        Args:
            seconds: s.
        """
        for _ in range(round(seconds / TIME_STEP)):
            self.step()

    def wait_for(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Wait until a condition has held for the standing time.

        Args:
            condition: The condition.
            seconds: s after which waiting is given up.

        Returns:
            Whether it did.
        """
        since = 0.0
        for _ in range(round(seconds / TIME_STEP)):
            self.step()
            since = since + TIME_STEP if condition() else 0.0
            if since >= self.control.standing_time:
                return True
        return False

    def move(self, goal: Array, seconds: float, until: Callable[[], bool] = lambda: False) -> str:
        """Move the wanted pose of the hand by a quintic of least jerk.

        Args:
            goal: (6,) m and rad.
            seconds: s.
            until: Ends the motion early.

        Returns:
            What ended it.
        """
        start, n = self.hand.wrist.wanted.copy(), max(1, round(seconds / TIME_STEP))
        off = goal - start
        off[3:] = (off[3:] + np.pi) % (2 * np.pi) - np.pi  # the shorter way round
        for k in range(n):
            s = (k + 1) / n
            self.hand.wrist.wanted = start + off * s**3 * (10.0 + s * (6.0 * s - 15.0))
            self.step()
            if until():
                return "contact"
        self.wait(SETTLED)
        return "arrived"

    def turn_to(self, angle: float) -> str:
        """Turn the closing motor to an angle.

        Args:
            angle: rad.

        Returns:
            What ended it.
        """
        motor = self.hand.motor
        way = 1.0 if angle > motor.angle else -1.0
        motor.wanted = way * self.hand.hand.drive.speed
        t_end = self.world.time + OPENING_TIME
        while way * (angle - motor.angle) > 0.0 and self.world.time < t_end:
            self.step()
        is_there = way * (angle - motor.angle) <= 0.0
        motor.wanted = 0.0
        self.wait(SETTLED)
        return "open" if is_there else "time"

    def blocked(self) -> tuple[str, ...]:
        """Return the links whose belts are to run, and do not."""
        speed = self.hand.hand.belts.speed
        return tuple(
            link for link, drive in self.hand.drives.items()
            if drive.wanted != 0.0 and abs(drive.speed) < BLOCKED * speed
        )  # fmt: skip
