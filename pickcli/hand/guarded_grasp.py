"""Grasps after a guarded approach: the hand stops and backs off where it meets something.

The hand feels by what the encoders and torques of its wrist tell (``force_observer``); it does not know where
the object is. Source of guarded moves: Will and Grossman, "An experimental system for computer controlled
mechanical assembly", IEEE Transactions on Computers C-24(9), 1975.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import GraspObject
from pickcli.hand.grasp_execution import GraspExecution
from pickcli.hand.staged_execution import SETTLED, HandWorld, StageName

MET = 1.0  # N in the horizontal plane: the hand has met an object
LIES = 1.0  # N upwards before the approach: the hand lies on something
RAISED_AT_MOST, RAISING_TIME = 0.02, 1.0  # m and s of raising it until it does not
BACKED = 0.01  # m straight back from what was met, so that it stands upright again
BACKING_TIME = 0.3  # s
RIGHTING_TIME = 0.3  # s in which an object that leaned on the hand comes to rest
TOUCHING, STRAIGHT = 0.005, 0.1  # m between tips and rad of hinges, of fingers around nothing
GOING_ON_TIME = 0.6  # s


class GuardedGrasp(GraspExecution):
    """The controller of a grasp with its approach.

    Args:
        world: The world.
        kind: The object for which currents are set.
        on_step: Called after every step.
        lift: m that it lifts; by default as the hand's file says.
    """

    def __init__(
        self,
        world: HandWorld,
        kind: GraspObject,
        on_step: Callable[[], None] = lambda: None,
        lift: float | None = None,
    ) -> None:
        super().__init__(world, kind, on_step, lift)
        self._wrist = world.hand.wrist
        self._goal = self._wrist.wanted  # (6,) m and rad, where it is to close if nothing is met before

    def run(self, pre_grasp: Array, seconds: float) -> None:
        """Approach, grasp and lift, until the end or a stop.

        Args:
            pre_grasp: (6,) m and rad of the wrist before the fingers close, if nothing is met before.
            seconds: s of the approach.
        """
        self.hand.motor.set_point = self._kind.low_current

        def act() -> None:
            self._goal = pre_grasp
            self.stage(StageName.APPROACH, lambda: self._approach(seconds))
            self._close_on_one()
            if self.stages[0].ended_by == "contact" and self._is_empty():
                self._go_on()
                self._close_on_one()
            self._lift_held()

        self.carry_out(act)

    def _approach(self, seconds: float) -> str:
        self._goal = self._goal + self._raise()
        ended_by = self.move(self._goal, seconds, until=self._has_met)
        if ended_by == "contact":
            self._back_off()
        return ended_by

    def _raise(self) -> Array:
        """Raise the hand off what it lies on, and return by how much ((6,) m and rad)."""
        wrist = self._wrist
        self.wait(SETTLED)
        before = wrist.wanted.copy()
        if wrist.felt[2] > LIES:
            up = np.array([0.0, 0.0, RAISED_AT_MOST, 0.0, 0.0, 0.0])
            self.move(before + up, RAISING_TIME, until=lambda: bool(wrist.felt[2] < LIES))
        return wrist.wanted - before

    def _has_met(self) -> bool:
        return bool(np.hypot(*self._wrist.felt[:2]) > MET)

    def _back_off(self) -> None:
        """Back off along the approach from where the hand is."""
        wrist = self._wrist
        wrist.wanted = np.concatenate([wrist.measured[:3], wrist.wanted[3:]])
        yaw = float(wrist.wanted[3])
        back = BACKED * np.array([np.cos(yaw), np.sin(yaw), 0.0, 0.0, 0.0, 0.0])
        self.move(wrist.wanted - back, BACKING_TIME)
        self.wait(RIGHTING_TIME)

    def _is_empty(self) -> bool:
        """The fingers are straight and their tips touch: what was met is not between them."""
        hand = self.hand
        gap = -float(hand.tips[:, 1].sum())
        return gap < TOUCHING and bool(np.abs(hand.fingers[:, 1]).max() < STRAIGHT)

    def _go_on(self) -> None:
        """Open, and go on to where the hand was to close, past what it met."""
        wrist = self._wrist
        self.stage(StageName.OPENING, lambda: self.turn_to(-self.hand.hand.fingers.widest))
        wrist.wanted, wrist.is_level_soft = wrist.measured.copy(), False
        self.stage(StageName.APPROACH, lambda: self.move(self._goal, GOING_ON_TIME))
