"""Sets down what a hand holds: lowering until it stands, opening, backing off.

Source: Krug et al., RA-L 2016, Fig. 7, placement.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.staged_execution import SETTLED, StagedExecution, StageName

STANDS = 8.0  # N that the arm presses down more than before: what is held stands
LOWERING_SPEED = 0.03  # m/s in the mean
LET_GO = -0.56  # rad of the closing motor, at which pads are clear of cans, and not yet of far neighbours
PAST = 0.02  # rad by which the motor may come to rest beyond such an angle
BACKED = 0.12  # m straight back, out of the fingers' reach
BACKING_TIME = 0.7  # s
RISE, RISING_TIME = 0.03, 0.5  # m and s, to come free of what is near below


class PlaceExecution(StagedExecution):
    """The controller that sets down what the hand holds.

    Args:
        world: The world, with the hand at an arm.
        on_step: Called after each step.
    """

    def __init__(self, world: ArmWorld, on_step: Callable[[], None] = lambda: None) -> None:
        super().__init__(world, on_step)
        self._arm = world.arm

    def place(self, deepest: float) -> None:
        """Lower, open and back off, until the end or a stop.

        Args:
            deepest: m, by which what is held is lowered at most.
        """

        def act() -> None:
            self.stage(StageName.LOWERING, lambda: self._lower(deepest))
            self.stage(StageName.OPENING, lambda: self.turn_to(LET_GO))
            self.stage(StageName.BACKING, self._back_off)

        self.carry_out(act)

    def open_to(self, angle: float) -> None:
        """Open or close the fingers, until the end or a stop.

        Args:
            angle: rad of the closing motor.
        """
        self.carry_out(lambda: self.stage(StageName.OPENING, lambda: self.turn_to(angle)))

    def leave(self) -> None:
        """Open the fingers as far as they go and back off, until the end or a stop."""

        def act() -> None:
            self.stage(StageName.OPENING, lambda: self.turn_to(-self.hand.hand.fingers.widest))
            self.stage(StageName.BACKING, self._back_off)

        self.carry_out(act)

    def rise(self) -> None:
        """Rise straight up by ``RISE``, until the end or a stop."""
        up = np.array([0.0, 0.0, RISE, 0.0, 0.0, 0.0])
        self.carry_out(lambda: self.stage(StageName.LIFT, lambda: self._lead(up, RISING_TIME)))

    def _lower(self, deepest: float) -> str:
        wrist = self.hand.wrist
        self.wait(SETTLED)  # until the arm bears what is held
        borne = wrist.lifting
        goal = wrist.wanted - np.array([0.0, 0.0, deepest, 0.0, 0.0, 0.0])
        ended_by = self.move(goal, deepest / LOWERING_SPEED, until=lambda: borne - wrist.lifting > STANDS)
        # The hand would follow that far down as soon as it lets go.
        wrist.wanted[2] += (borne - wrist.lifting) / self.hand.hand.wrist.stiff
        return ended_by

    def _back_off(self) -> str:
        yaw = float(self.hand.wrist.wanted[3])
        return self._lead(-BACKED * np.array([np.cos(yaw), np.sin(yaw), 0.0, 0.0, 0.0, 0.0]), BACKING_TIME)

    def _lead(self, way: Array, seconds: float) -> str:
        """Move the empty hand by (6,) m and rad, without a lag: the way was proven for where it should be."""
        impedance = self._arm.impedance
        impedance.is_leading = True
        try:
            return self.move(impedance.wanted + way, seconds)
        finally:
            impedance.is_leading = False
