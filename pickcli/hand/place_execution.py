"""Sets down what a hand holds: lowering until it stands, opening, backing off.

Source: Krug et al., RA-L 2016, Fig. 7, placement.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.staged_execution import SETTLED, StagedExecution, StageName

STANDS = 8.0  # N that the arm presses down more than before: what is held stands
LOWERING_SPEED = 0.03  # m/s in the mean
LET_GO = -0.56  # rad of the closing motor, at which pads are clear of cans, and not yet of far neighbours
PAST = 0.02  # rad by which the motor may come to rest beyond such an angle
OPENING_SPEED = 0.4  # rad/s of the closing motor
OPENING_TIME = 4.0  # s, after which opening is given up
BACKED = 0.12  # m straight back, out of the fingers' reach
BACKING_TIME = 1.2  # s


class PlaceExecution(StagedExecution):
    """The controller that sets down what the hand holds."""

    def place(self, deepest: float) -> None:
        """Lower, open and back off, until the end or a stop.

        Args:
            deepest: m, by which what is held is lowered at most.
        """

        def act() -> None:
            self.stage(StageName.LOWERING, lambda: self._lower(deepest))
            self.stage(StageName.OPENING, lambda: self._turn_to(LET_GO))
            self.stage(StageName.BACKING, self._back_off)

        self.carry_out(act)

    def open_to(self, angle: float) -> None:
        """Open or close the fingers, until the end or a stop.

        Args:
            angle: rad of the closing motor.
        """
        self.carry_out(lambda: self.stage(StageName.OPENING, lambda: self._turn_to(angle)))

    def leave(self) -> None:
        """Open the fingers as far as they go and back off, until the end or a stop."""

        def act() -> None:
            self.stage(StageName.OPENING, lambda: self._turn_to(-self.hand.hand.fingers.widest))
            self.stage(StageName.BACKING, self._back_off)

        self.carry_out(act)

    def _lower(self, deepest: float) -> str:
        wrist = self.hand.wrist
        self.wait(SETTLED)  # until the arm bears what is held
        borne = wrist.lifting
        goal = wrist.wanted - np.array([0.0, 0.0, deepest, 0.0, 0.0, 0.0])
        ended_by = self.move(goal, deepest / LOWERING_SPEED, until=lambda: borne - wrist.lifting > STANDS)
        # The hand would follow that far down as soon as it lets go.
        wrist.wanted[2] += (borne - wrist.lifting) / self.hand.hand.wrist.stiff
        return ended_by

    def _turn_to(self, angle: float) -> str:
        """Turn the closing motor to an angle (rad)."""
        motor = self.hand.motor
        way = 1.0 if angle > motor.angle else -1.0
        motor.wanted = way * OPENING_SPEED
        t_end = self.world.time + OPENING_TIME
        while way * (angle - motor.angle) > 0.0 and self.world.time < t_end:
            self.step()
        is_there = way * (angle - motor.angle) <= 0.0
        motor.wanted = 0.0
        self.wait(SETTLED)
        return "open" if is_there else "time"

    def _back_off(self) -> str:
        yaw, wanted = float(self.hand.wrist.wanted[3]), self.hand.wrist.wanted
        back: Array = wanted - BACKED * np.array([np.cos(yaw), np.sin(yaw), 0.0, 0.0, 0.0, 0.0])
        return self.move(back, BACKING_TIME)
