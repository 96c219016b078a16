"""What all tasks of a stack have in common.

A task is an error e(q) that is to vanish, or not to be positive, by e-dot* = -gain e: its rows J dq = e-dot*,
or J dq <= e-dot*. Krug et al., RA-L 2016, section III-B, after Kanoun, Lamiraux and Wieber, IEEE T-RO 27(4),
2011.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

from pickcli.control.hierarchical_qp import BoundedRows
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class ControlState:
    """State of the robot at an instant of control.

    Attributes:
        q: (n,) configuration in rad or m.
        dq: (n,) joint rates of the last period, in rad/s or m/s.
        period: s until the next instant.
    """

    q: Array
    dq: Array
    period: float


class Task(ABC):
    """A task: what it asks of joint rates, and how far it is from met."""

    name: str

    @abstractmethod
    def rows(self, state: ControlState) -> BoundedRows:
        """Return the task's rows on joint rates.

        Args:
            state: The robot now.

        Returns:
            (m, n) rows and their bounds, per s.
        """

    @abstractmethod
    def error(self, state: ControlState) -> float:
        """Return how far the task is from met.

        Args:
            state: The robot now.

        Returns:
            Its largest error in its own unit, 0 where it is met.
        """


def stopping_rate(distance: Array, deceleration: Array, period: float) -> Array:
    """Return rates from which something stops within a distance, braked anew in every period.

    Args:
        distance: (N,) m or rad that are left; where it is negative, no rate is left.
        deceleration: (N,) per s^2.
        period: s.

    Returns:
        (N,) per s; negative, by the distance in one period, where the distance is.
    """
    # What is braked by whole steps goes up to an eighth of a step farther than v^2 / 2 a + v period / 2.
    step = deceleration * period
    left = np.maximum(0.0, distance - step * period / 8)
    rate = np.sqrt(step**2 / 4 + 2 * deceleration * left) - step / 2
    return np.asarray(np.where(distance > 0.0, rate, distance / period))
