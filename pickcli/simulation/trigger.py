"""Distance along the tool path from a fired event to its trigger, measured without the tracker."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan

SAMPLE_TIME = 1e-3  # s between samples of the path
FINE_SAMPLE_TIME = 2e-5  # s between samples around the nearest one: 0.06 mm of tool path at 3 m/s
LOOK_BACK = 0.5  # s of the plan's time, more than a robot lags behind its command


class TriggerDistance:
    """Distance of tool path (m) between a measured configuration and an event's resolved trigger.

    Args:
        plan: The plan.
        arm: The robot's kinematics.
    """

    def __init__(self, plan: Plan, arm: Arm) -> None:
        self._trajectory, self._arm = plan.trajectory, arm

    def __call__(self, event: Event, q: Array, t_command: float) -> float:
        """q: measured configuration (n,); t_command: time on the plan of the present set point, s."""
        if event.t_trigger is None:
            return 0.0
        where = self._project(q, t_command)
        first, last = sorted((where, max(0.0, event.t_trigger)))
        n = max(2, int((last - first) / SAMPLE_TIME) + 2)
        path = self._trajectory.sample(np.linspace(first, last, n))
        tips = self._arm.tips(path, self._arm.robot.tool.default_state)[:, :3, 3]
        return float(np.linalg.norm(np.diff(tips, axis=0), axis=1).sum())

    def _project(self, q: Array, t_command: float) -> float:
        """Time of the plan's point nearest to q, not later than the present command."""
        first = max(0.0, t_command - LOOK_BACK)
        near = self._nearest(q, np.linspace(first, t_command, int(LOOK_BACK / SAMPLE_TIME) + 1))
        around = np.arange(
            max(first, near - SAMPLE_TIME),
            min(t_command, near + SAMPLE_TIME) + FINE_SAMPLE_TIME / 2,
            FINE_SAMPLE_TIME,
        )
        return self._nearest(q, around)

    def _nearest(self, q: Array, times: Array) -> float:
        offsets = np.linalg.norm(self._trajectory.sample(times) - q, axis=1)
        return float(times[int(np.argmin(offsets))])
