"""Supervision of the hold on an item, by the vacuum gauge or the finger encoder."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.suction import SEAL_VACUUM
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.vacuum import Vacuum

SEAL_GRACE = 0.05  # s after the start of the lift by which the seal must be established


class HoldWatch(Protocol):
    """Supervises the hold during one execution, step by step."""

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Check the hold after a step.

        Args:
            segment: The current segment.
            t: Simulated time, s.

        Returns:
            The required stop, or None.
        """


class NoWatch:
    """Hold watch of a tool that holds nothing."""

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Request no stop, as nothing is held.

        Args:
            segment: The current segment.
            t: Simulated time, s.

        Returns:
            None.
        """
        return None


class SealWatch:
    """Supervises a cup by its vacuum gauge.

    Args:
        gauge: Vacuum gauge of the cup.
        thresholds: Thresholds of a stop.
    """

    def __init__(self, gauge: Vacuum, thresholds: Thresholds) -> None:
        self._gauge, self._thresholds = gauge, thresholds
        self._sealed_level, self._t_lift = 0.0, np.inf

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Check after a step that the cup has sealed by the lift, and keeps its vacuum.

        Args:
            segment: The current segment.
            t: Simulated time, s.

        Returns:
            The required stop, or None.
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
    """Supervises fingers by their encoder.

    Args:
        fingers: The fingers.
        thresholds: Thresholds of a stop.
    """

    def __init__(self, fingers: Fingers, thresholds: Thresholds) -> None:
        self._fingers, self._thresholds = fingers, thresholds
        self._has_lifted = False

    def stop(self, segment: Segment, t: float) -> ProtectiveStop | None:
        """Check after a step that the fingers are at the planned width.

        Args:
            segment: The current segment.
            t: Simulated time, s.

        Returns:
            The required stop, or None.
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
