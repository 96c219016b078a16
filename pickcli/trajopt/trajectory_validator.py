"""Validation of parabolic segments, which a search needs thousands of times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.collision.motion_validator import MotionValidator
from pickcli.geometry import Array
from pickcli.kernel import ParabolicSegment, tube
from pickcli.path_planning.state_space import JointSpace

_CHORDS = (0.04, 0.01, 0.0025)  # s: shorter ones reduce the slack


@dataclass(frozen=True, eq=False)
class TrajectoryValidator:
    """Proves segments and curves free with one checker in one joint space.

    Attributes:
        checker: Proves tubes around edges free.
        space: Position limits.
    """

    checker: MotionValidator
    space: JointSpace

    def is_valid(self, segments: Sequence[ParabolicSegment]) -> bool:
        """Whether every instant of segments is proven free and inside the position limits.

        Args:
            segments: Segments, one after the other.

        Returns:
            True if it is proven.
        """
        return self.proves(lambda step: tube(segments, step))

    def proves(self, tube_of: Callable[[float], tuple[Array, Array]]) -> bool:
        """Whether a curve is proven free and inside the position limits.

        Chords are shortened until the slack around them is small enough for a proof, or their ends are not
        free.

        Args:
            tube_of: Returns for the longest chord (s) chord ends (N, n) and slack (N - 1, n) around each
                chord.

        Returns:
            True if it is proven.
        """
        for step in _CHORDS:
            Q, slack = tube_of(step)
            if not self._is_inside(Q, slack):
                return False
            i = self.checker.first_blocked_edge(Q, slack)
            if i < 0:
                return True
            if not (self.checker.is_valid(Q[i]) and self.checker.is_valid(Q[i + 1])):
                return False  # no shorter chord would help
        return False

    def _is_inside(self, Q: Array, slack: Array) -> bool:
        """Whether the tube stays within the position limits."""
        low, high = np.minimum(Q[:-1], Q[1:]) - slack, np.maximum(Q[:-1], Q[1:]) + slack
        return bool(np.all(low >= self.space.lower) and np.all(high <= self.space.upper))
