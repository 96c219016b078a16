"""Task that keeps the limits of joints: positions, rates and accelerations.

Limits belong into the first level: rates that are clipped after the solution break the hierarchy. So does the
acceleration, without which rates jump from one period to the next.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.control.hierarchical_qp import BoundedRows
from pickcli.control.tasks.task import ControlState, Task, stopping_rate


@dataclass(frozen=True, eq=False)
class JointLimitTask(Task):
    """Keeps joints within limits of position, rate and acceleration.

    Attributes:
        name: Name of the task in its stack.
        limits: The limits; where they conflict, e.g. too near to the end of a joint to stop, the position
            gives way.
        speed_scale: Share of rates and accelerations that is used.
    """

    name: str
    limits: Limits
    speed_scale: float = 1.0

    def rows(self, state: ControlState) -> BoundedRows:
        """Return one row for each joint: the rates from which it can still stop before its end.

        Args:
            state: The robot now.

        Returns:
            (m, n) rows and their bounds, per s.
        """
        velocity, acceleration = (
            self.speed_scale * each for each in (self.limits.velocity, self.limits.acceleration)
        )
        lower, upper = self.limits.window
        change = acceleration * state.period
        low = np.clip(-stopping_rate(state.q - lower, acceleration, state.period), -velocity, velocity)
        high = np.clip(stopping_rate(upper - state.q, acceleration, state.period), -velocity, velocity)
        low, high = (
            np.clip(low, state.dq - change, state.dq + change),
            np.clip(high, state.dq - change, state.dq + change),
        )
        return BoundedRows(np.eye(len(state.q)), low, high)

    def error(self, state: ControlState) -> float:
        """Return how far a joint is beyond its limit, in rad or m.

        Args:
            state: The robot now.

        Returns:
            Its size, 0 where the task is met.
        """
        lower, upper = self.limits.window
        return max(0.0, float(np.max(np.maximum(lower - state.q, state.q - upper))))
