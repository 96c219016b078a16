"""The way off a running belt for an arm whose joints all follow it: on along the plan, by the belt's clock.

To go back along the lines while the belt runs on would be another motion of every joint, which nothing has
proven. The plan's own motion is: it is followed to where the arm rests after the lift, clear of all that the
belt may bring, whether the item was taken or not.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.simulation.belt_clock import AT_REST, BeltClock

STANDS = 1.0  # s after which an arm that waits over a belt at rest counts as at rest


class PlannedWayOff:
    """Follows one way off the belt, from where the plan is.

    Args:
        plan: The plan, with a conveyor.
        clock: The clock of the plan.
        time_step: s between two set points.

    Attributes:
        t: s of the plan.
        is_clear: Whether the arm has come to rest after the lift.
    """

    def __init__(self, plan: Plan, clock: BeltClock, time_step: float) -> None:
        self._trajectory, self._clock, self._time_step = plan.trajectory, clock, time_step
        times, speeds = plan.trajectory.times, np.abs(plan.trajectory.velocities).max(axis=1)
        self._t_rests = float(times[(times >= clock.t_left) & (speeds <= AT_REST)][0])
        self.t, self.is_clear, self._stood = clock.scaling.t, False, 0.0

    @property
    def is_at_rest(self) -> bool:
        """Whether the arm is at rest, clear of the belt or over one that stands."""
        return self.is_clear or self._stood >= STANDS

    def turn_back(self) -> None:
        """Go on: the lines are not gone back."""

    def next(self) -> Array:
        """Return the next set point.

        Returns:
            (n,) configuration.
        """
        self.t = min(self._clock.next(), self._t_rests)
        self.is_clear = self.t >= self._t_rests
        self._stood = 0.0 if self._clock.rate > 0.0 else self._stood + self._time_step
        return np.asarray(self._trajectory.sample(self.t)[0])
