"""Result of following tool poses by inverse kinematics, and tolerances for a line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class FollowResult:
    """Configurations along a line of tool poses, one per pose, up to the last reachable one.

    Attributes:
        configurations: (M, n), M at most the number of poses.
        reason: Why the line is incomplete; None if it is complete.
    """

    configurations: Array
    reason: Reason | None


@dataclass(frozen=True)
class Deviation:
    """Deviation of the tool from a line, or its tolerance.

    Attributes:
        position: m.
        angle: rad.
    """

    position: float
    angle: float


HALF_WAY = Deviation(1e-3, float(np.radians(0.5)))  # between two consecutive poses
