"""Time scaling of a trajectory while it is executed: its rate follows a wanted one as far as limits allow.

At a rate r the path accelerates a joint by q'' r^2 + q' dr, with a jerk of q''' r^3 + 3 q'' r dr + q' ddr,
both bounded by its limits (Dahl and Nielsen, Torque-limited path following by online trajectory time scaling,
IEEE Trans. Robotics and Automation 6 (5), 1990, here with limits of acceleration and jerk instead of torque).
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter1d

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

SOFTNESS = 0.4  # share of the jerk with which the rate comes to the wanted one
CLOSING = 50.0  # 1/s at which the rate comes to the wanted one when it is near
KEPT = 0.97  # share of the limits of acceleration and jerk: differences of set points are judged
LEAST_CHANGE = 0.3  # 1/s of the rate of time, which is always possible
RESTING = 1e-5  # rate of time that is rest, if that is wanted: it is come to by an exponential
AHEAD = 0.1  # s of the trajectory for which a change of the rate must be bearable
NEAR = 3  # set points before and after, over which their differences are judged
SLOW = 0.2  # rad/s or m/s of a joint below which its rate of time hardly makes up for anything
STILL = 1e-3  # rad/s or m/s of a joint below which its limits do not bound the rate


class OnlineTimeScaling:
    """Follows one execution of a trajectory.

    Args:
        trajectory: The trajectory.
        limits: Limits of the joints.
        time_step: s between two set points.

    Attributes:
        t: s of the trajectory at the last set point.
        rate: Of its time there.
        change: Of the rate there, per s.
    """

    def __init__(self, trajectory: Trajectory, limits: Limits, time_step: float) -> None:
        self._time_step, self._duration = time_step, trajectory.duration
        self._acceleration, self._jerk = KEPT * limits.acceleration, KEPT * limits.jerk
        self._most = np.tile(self._acceleration, 2 * NEAR), np.tile(self._jerk, 2 * NEAR)
        steps = np.arange(-NEAR, round(trajectory.duration / time_step) + NEAR + 1, dtype=float)
        grid = np.asarray(time_step * steps, dtype=float)
        self._derivatives = [trajectory.sample(grid, k) for k in (1, 2, 3)]
        around = 2 * round(AHEAD / time_step) + 1
        self._soon = maximum_filter1d(np.abs(self._derivatives[0]), around, axis=0)
        bounds = self._acceleration, self._jerk
        self._used = [
            maximum_filter1d((np.abs(rows) / bound).max(axis=1), around)
            for rows, bound in zip(self._derivatives[1:], bounds, strict=True)
        ]
        self._build_up = float((self._jerk / self._acceleration).min())
        self.t, self.rate = 0.0, 1.0
        self.change, self._wanted = 0.0, 1.0  # the wanted rate before

    def advance(self, wanted: float, most_change: float = np.inf) -> float:
        """Go on to the next set point.

        Args:
            wanted: Wanted rate of the time.
            most_change: Of the rate, per s, while the robot moves.

        Returns:
            s of the trajectory at the next set point.
        """
        at, step, rate = round(self.t / self._time_step), self._time_step, self.rate
        v, a, j = (rows[at : at + 2 * NEAR].ravel() for rows in self._derivatives)
        soon = np.maximum(self._soon[at + NEAR], STILL)
        most_jerk = SOFTNESS * float((self._jerk / soon).min())  # of the time
        gap = wanted - rate
        softly = float(np.sqrt(2.0 * most_jerk * abs(gap)))
        change = (wanted - self._wanted) / step + float(np.sign(gap)) * min(CLOSING * abs(gap), softly)
        most = float((self._acceleration / soon).min())
        if float(soon.max()) > STILL:
            most = min(most, most_change)
        change = min(max(change, -most, -float(np.sqrt(2.0 * most_jerk * rate))), most)
        own = a * rate**2, j * rate**3  # at a steady rate
        most_a, most_j = (np.maximum(most, np.abs(each)) for most, each in zip(self._most, own, strict=True))
        change = _clipped(change, own[0], v, most_a)
        jerk = own[1] + 3.0 * a * rate * self.change
        further = _clipped((change - self.change) / step, jerk, v, most_j)
        self.change, self._wanted = self.change + step * further, wanted
        self.rate = rate + self.change * step
        if self.rate <= (RESTING if wanted == 0.0 else 0.0):
            self.rate = self.change = 0.0
        self.t = min(self.t + self.rate * step, self._duration)
        return self.t

    def begin(self, t: float, rate: float, change: float = 0.0) -> None:
        """Go on from a motion that another one has brought to here.

        Args:
            t: s of the trajectory.
            rate: Of its time.
            change: Of the rate, per s.
        """
        self.t, self.rate, self.change, self._wanted = t, rate, change, rate

    @property
    def bearable_change(self) -> float:
        """Change of the rate per s that the jerk leaves room for, at the rate that is reached."""
        at = round(self.t / self._time_step) + NEAR
        used, jerk = (float(rows[at]) for rows in self._used)
        left = (1.0 - jerk * self.rate**3) / (3.0 * max(used, STILL) * max(self.rate, STILL))
        return max(LEAST_CHANGE, self._build_up * left)

    def hold(self, t: float) -> float:
        """Stay where the trajectory rests.

        Args:
            t: s of the trajectory, at which every joint is at rest.

        Returns:
            The same.
        """
        self.t, self.rate, self.change = t, 0.0, 0.0
        return t


def _clipped(x: float, constant: Array, factor: Array, bound: Array) -> float:
    """Return the number nearest to x for which every |constant + factor x| (n,) is within its bound.

    A slow joint that is beyond its bound already does not get more. Where joints contradict each other, it is
    the number between them.
    """
    moves = np.abs(factor) > STILL
    if not moves.any():
        return x
    constant, factor, bound = constant[moves], factor[moves], bound[moves]
    bound = np.where(np.abs(factor) > SLOW, bound, np.maximum(bound, np.abs(constant)))
    ends = np.sort([(-bound - constant) / factor, (bound - constant) / factor], axis=0)
    low, high = float(ends[0].max()), float(ends[1].min())
    return min(max(x, low), high) if low <= high else (low + high) / 2
