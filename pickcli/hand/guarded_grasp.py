"""Approaches an object by a guarded move before it is grasped: the hand stops and backs off where it meets something.

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
from pickcli.hand.grasp_world import GraspWorld
from pickcli.hand.staged_execution import SETTLED, StageName

MET = 0.7  # N in the horizontal plane: the hand has met an object
LIES = 2.0  # N upwards before the approach: the hand lies on something
CLEAR = 1e-3  # m that it is raised beyond that
BACKED = 0.01  # m straight back from what was met, so that it stands upright again
BACKING_TIME = 0.3  # s
RIGHTING_TIME = 0.3  # s in which an object that leaned on the hand comes to rest


class GuardedGrasp(GraspExecution):
    """The controller of a grasp with its approach.

    Args:
        world: The world.
        kind: The object for which currents are set.
        on_step: Called after every step.
    """

    def __init__(
        self, world: GraspWorld, kind: GraspObject, on_step: Callable[[], None] = lambda: None
    ) -> None:
        super().__init__(world, kind, on_step)
        self._wrist = world.wrist

    def run(self, pre_grasp: Array, seconds: float) -> None:
        """Approach, grasp and lift, until the end or a stop.

        Args:
            pre_grasp: (6,) m and rad of the wrist before the fingers close, if nothing is met before.
            seconds: s of the approach.
        """
        self.hand.motor.set_point = self._kind.low_current

        def act() -> None:
            self.stage(StageName.APPROACH, lambda: self._approach(pre_grasp, seconds))
            self._grasp()

        self.carry_out(act)

    def _approach(self, pre_grasp: Array, seconds: float) -> str:
        ended_by = self.move(pre_grasp + self._raise(), seconds, until=self._has_met)
        if ended_by == "contact":
            self._back_off()
        return ended_by

    def _raise(self) -> Array:
        """Raise the hand off what it lies on, and return by how much ((6,) m and rad)."""
        wrist, way = self._wrist, np.zeros(6)
        self.wait(SETTLED)
        if wrist.felt[2] > LIES:
            way[2] = wrist.felt[2] / wrist.wrist.stiff + CLEAR
            self.move(wrist.wanted + way, BACKING_TIME)
        return way

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
