"""Executes grasps: closing, separation of two objects, pulling in, firm grasp, lift.

The stages are those of Krug et al. (RA-L 2016, section III-C and figure 4).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pickcli.hand.belt_hand import GraspObject
from pickcli.hand.staged_execution import HandWorld, StagedExecution, StageName

REACHED = 0.95  # share of a current that counts as reached
CLOSING_TIME = 5.0  # s, after which closing is given up
CLEARLY = 0.05  # rad beyond the angle of two objects, where one has left


class GraspExecution(StagedExecution):
    """The controller of a grasp in a world.

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
        super().__init__(world, on_step)
        self._kind, self._height = kind, self.control.lift if lift is None else lift

    def grasp(self) -> None:
        """Grasp from where the open hand is, and lift, until the end or a stop."""
        self.hand.motor.set_point = self._kind.low_current

        def act() -> None:
            self._close_on_one()
            self._lift_held()

        self.carry_out(act)

    def _close_on_one(self) -> None:
        self.hand.wrist.is_level_soft = True
        self.stage(StageName.CLOSING, self._close)
        if self.hand.motor.angle < self.control.two_objects:
            self.stage(StageName.SEPARATION, self._separate)
            self.stage(StageName.CLOSING, self._close)

    def _lift_held(self) -> None:
        self.stage(StageName.PULL_IN, self._pull_in)
        self.stage(StageName.FIRM, self._hold_firmly)
        self.stage(StageName.LIFT, self._lift)

    def _has_contact(self) -> bool:
        """Current reached, and the encoder stands."""
        motor = self.hand.motor
        return motor.current >= REACHED * motor.set_point and abs(motor.rate) < self.control.standing

    def _close(self) -> str:
        self.hand.motor.wanted = self.hand.hand.drive.speed
        return "contact" if self.wait_for(self._has_contact, CLOSING_TIME) else "time"

    def _separate(self) -> str:
        """Run the belts in opposite directions until the fingers stand closer than on two objects."""
        speed, t_end = self.hand.hand.belts.speed, self.world.time + self.control.separation
        self.hand.run_belts(speed, -speed)
        while self.hand.motor.angle < self.control.two_objects + CLEARLY and self.world.time < t_end:
            self.step()
        self.hand.run_belts(0.0, 0.0)
        return "one object left" if self.world.time < t_end else "time"

    def _has_blocked(self) -> bool:
        return {link.split("_")[0] for link in self.blocked()} == {"left", "right"}

    def _pull_in(self) -> str:
        speed = self.hand.hand.belts.speed
        self.hand.run_belts(speed, speed)
        return "belts blocked" if self.wait_for(self._has_blocked, self.control.pull_in) else "time"

    def _hold_firmly(self) -> str:
        self.hand.run_belts(0.0, 0.0)
        self.hand.motor.set_point = self._kind.high_current
        self.wait(self.control.firm)
        return "time"

    def _lift(self) -> str:
        goal = self.hand.wrist.wanted + np.array([0.0, 0.0, self._height, 0.0, 0.0, 0.0])
        # As hard an acceleration as over the height of the file.
        self.move(goal, self.control.lift_time * float(np.sqrt(self._height / self.control.lift)))
        self.wait(self.control.hold)
        return "arrived"
