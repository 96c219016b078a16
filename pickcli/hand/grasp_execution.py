"""Executes grasps: approach, closing, separation of two objects, pulling in, firm grasp, lift.

The stages are those of Krug et al. (RA-L 2016, section III-C and figure 4). The controller knows currents and
encoders of the motors and the wrist's torques; it does not know where objects are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import GraspObject
from pickcli.hand.grasp_world import TIME_STEP, GraspWorld

REACHED = 0.95  # share of a current that counts as reached
BLOCKED = 0.2  # share of its speed below which a belt is blocked
SETTLED = 0.2  # s after an approach in which the arm comes to rest
CLOSING_TIME = 5.0  # s, after which closing is given up


class StageName(StrEnum):
    """Stages of a grasp, in order."""

    APPROACH = "approach"
    CLOSING = "closing"
    SEPARATION = "separation"
    PULL_IN = "pull-in"
    FIRM = "firm grasp"
    LIFT = "lift"


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


class _OverloadError(Exception):
    """A torque of the wrist is beyond its threshold."""


class GraspExecution:
    """The controller of a grasp in a world.

    Attributes:
        stages: Stages so far.
        is_stopped: Whether a torque beyond its threshold stopped the arm.

    Args:
        world: The world.
        kind: The object for which currents are set.
        watch: Called after every step.
    """

    def __init__(
        self, world: GraspWorld, kind: GraspObject, watch: Callable[[GraspWorld], None] = lambda _: None
    ) -> None:
        self._world, self._hand, self._kind, self._watch = world, world.hand, kind, watch
        self._control = world.hand.hand.control
        self.stages: list[GraspStage] = []
        self.is_stopped = False

    def run(self, pre_grasp: Array, seconds: float) -> None:
        """Approach, grasp and lift, until the end or a stop.

        Args:
            pre_grasp: (6,) m and rad of the wrist before the fingers close.
            seconds: s of the approach.
        """
        self._hand.motor.set_point = self._kind.low_current
        try:
            self._stage(StageName.APPROACH, lambda: self._move(pre_grasp, seconds))
            self._hand.wrist.is_level_soft = True
            self._stage(StageName.CLOSING, self._close)
            if self._hand.motor.angle < self._control.two_objects:
                self._stage(StageName.SEPARATION, self._separate)
                self._stage(StageName.CLOSING, self._close)
            self._stage(StageName.PULL_IN, self._pull_in)
            self._stage(StageName.FIRM, self._hold_firmly)
            self._stage(StageName.LIFT, self._lift)
        except _OverloadError:
            self.is_stopped = True

    def _stage(self, name: StageName, act: Callable[[], str]) -> None:
        start, ended_by = self._world.time, "torque threshold"
        try:
            ended_by = act()
        finally:
            motor = self._hand.motor
            self.stages.append(
                GraspStage(
                    name,
                    start,
                    self._world.time,
                    ended_by,
                    motor.current,
                    motor.angle,
                    self._blocked(),
                    self._hand.slipping,
                )
            )

    def _step(self) -> None:
        self._world.step()
        self._watch(self._world)
        if self._hand.wrist.is_overloaded:
            raise _OverloadError

    def _wait(self, seconds: float) -> None:
        for _ in range(round(seconds / TIME_STEP)):
            self._step()

    def _wait_for(self, condition: Callable[[], bool], seconds: float) -> bool:
        """Wait until a condition has held for the standing time; return whether it did."""
        since = 0.0
        for _ in range(round(seconds / TIME_STEP)):
            self._step()
            since = since + TIME_STEP if condition() else 0.0
            if since >= self._control.standing_time:
                return True
        return False

    def _move(self, goal: Array, seconds: float) -> str:
        """Move the wrist's wanted position by a quintic of least jerk."""
        start, n = self._hand.wrist.wanted.copy(), max(1, round(seconds / TIME_STEP))
        for k in range(n):
            s = (k + 1) / n
            self._hand.wrist.wanted = start + (goal - start) * s**3 * (10.0 + s * (6.0 * s - 15.0))
            self._step()
        self._wait(SETTLED)
        return "arrived"

    def _has_contact(self) -> bool:
        """Current reached, and the encoder stands."""
        motor = self._hand.motor
        return motor.current >= REACHED * motor.set_point and abs(motor.rate) < self._control.standing

    def _close(self) -> str:
        self._hand.motor.wanted = self._hand.hand.drive.speed
        return "contact" if self._wait_for(self._has_contact, CLOSING_TIME) else "time"

    def _separate(self) -> str:
        speed = self._hand.hand.belts.speed
        self._hand.run_belts(speed, -speed)
        self._wait(self._control.separation)
        self._hand.run_belts(0.0, 0.0)
        return "time"

    def _blocked(self) -> tuple[str, ...]:
        speed = self._hand.hand.belts.speed
        return tuple(
            link for link, drive in self._hand.drives.items()
            if drive.wanted != 0.0 and abs(drive.speed) < BLOCKED * speed
        )  # fmt: skip

    def _has_blocked(self) -> bool:
        return {link.split("_")[0] for link in self._blocked()} == {"left", "right"}

    def _pull_in(self) -> str:
        speed = self._hand.hand.belts.speed
        self._hand.run_belts(speed, speed)
        return "belts blocked" if self._wait_for(self._has_blocked, self._control.pull_in) else "time"

    def _hold_firmly(self) -> str:
        self._hand.run_belts(0.0, 0.0)
        self._hand.motor.set_point = self._kind.high_current
        self._wait(self._control.firm)
        return "time"

    def _lift(self) -> str:
        goal = self._hand.wrist.wanted + np.array([0.0, 0.0, self._control.lift, 0.0, 0.0, 0.0])
        self._move(goal, self._control.lift_time)
        self._wait(self._control.hold)
        return "arrived"
