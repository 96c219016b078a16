"""Whether the hold stands where a plan counts on it: by the vacuum gauge, or by the encoder of fingers."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.suction import SEAL_VACUUM
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.vacuum import Vacuum

SEAL_GRACE = 0.05  # s after the lift began by which the seal must stand


class HoldWatch(Protocol):
    """Judges the hold of one execution, step by step."""

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Whether the hold stands; after a step.

        Args:
            segment: The part of the plan that the robot is in.
            t: Simulated time, s.

        Returns:
            The stop to be made, or None.
        """


class NoWatch:
    """Watches a tool that holds nothing."""

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """No reason to stop, for nothing is held.

        Args:
            segment: The part of the plan that the robot is in.
            t: Simulated time, s.

        Returns:
            None.
        """
        return None


class SealWatch:
    """Watches a cup by its vacuum gauge.

    Args:
        gauge: Of the cup.
        thresholds: Beyond which it stops.
    """

    def __init__(self, gauge: Vacuum, thresholds: Thresholds) -> None:
        self._gauge, self._thresholds = gauge, thresholds
        self._sealed_level, self._t_lift = 0.0, np.inf

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Whether the cup has sealed by the lift, and keeps its vacuum; after a step.

        Args:
            segment: The part of the plan that the robot is in.
            t: Simulated time, s.

        Returns:
            The stop to be made, or None.
        """
        level = self._gauge.cup
        if segment.held is None or segment.kind is SegmentKind.CONTACT or not self._gauge.is_valve_open:
            self._sealed_level, self._t_lift = 0.0, np.inf
            return None
        self._t_lift = min(self._t_lift, t)
        if t - self._t_lift < SEAL_GRACE:
            return None
        if self._sealed_level == 0.0 and level < SEAL_VACUUM:
            return _vacuum(StopCause.NOT_SEALED, level, SEAL_VACUUM, t)
        self._sealed_level = max(self._sealed_level, level)
        least = self._thresholds.vacuum * self._sealed_level
        return _vacuum(StopCause.SEAL_LOST, level, least, t) if level < least else None


class GraspWatch:
    """Watches fingers by their encoder.

    Args:
        fingers: The fingers.
        thresholds: Beyond which they stop.
    """

    def __init__(self, fingers: Fingers, thresholds: Thresholds) -> None:
        self._fingers, self._thresholds = fingers, thresholds
        self._has_lifted = False

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Whether the fingers stand at the width at which the plan counts on them; after a step.

        Args:
            segment: The part of the plan that the robot is in.
            t: Simulated time, s.

        Returns:
            The stop to be made, or None.
        """
        planned, width = segment.tool_state.width, self._fingers.width
        if segment.held is None or planned is None:
            self._has_lifted = False
            return None
        off = min(self._thresholds.width, planned / 2)
        cause = StopCause.GRASP_LOST if self._has_lifted else StopCause.NOT_GRASPED
        self._has_lifted = True
        if planned - off <= width <= planned + off:
            return None
        passed = planned - off if width < planned else planned + off
        return ProtectiveStop(cause, "fingers", float(width), float(passed), "m", t)


def _vacuum(cause: StopCause, level: float, least: float, t: float) -> ProtectiveStop:
    return ProtectiveStop(cause, "vacuum", float(level / 1e3), float(least / 1e3), "kPa", t)
