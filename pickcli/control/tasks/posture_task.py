"""Task that draws the joints to a configuration."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.control.hierarchical_qp import BoundedRows
from pickcli.control.tasks.task import ControlState, Task
from pickcli.geometry import Array

REACHED = 1e-3  # rad or m that a joint may be off: what is approached exponentially never is at its end


@dataclass(frozen=True, eq=False)
class PostureTask(Task):
    """Draws the joints to a configuration.

    Attributes:
        name: Name of the task in its stack.
        q: (n,) the configuration.
        gain: 1/s.
    """

    name: str
    q: Array
    gain: float

    def rows(self, state: ControlState) -> BoundedRows:
        """Return one equality for each joint.

        Args:
            state: The robot now.

        Returns:
            (m, n) rows and their bounds, per s.
        """
        return BoundedRows.equal(np.eye(len(self.q)), self.gain * (self.q - state.q))

    def error(self, state: ControlState) -> float:
        """Return by how much the farthest joint is off the configuration, beyond ``REACHED``, in rad or m.

        Args:
            state: The robot now.

        Returns:
            Its size, 0 where the task is met.
        """
        return max(0.0, float(np.abs(self.q - state.q).max()) - REACHED)
