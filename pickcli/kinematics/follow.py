"""The outcome of following tool poses with the joints, and how far the tool may be off the line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class FollowResult:
    """Configurations along a line of tool poses, one per pose, as far as they go.

    Attributes:
        configurations: (M, n), M at most the number of poses.
        reason: Why the line broke; None if it is whole.
    """

    configurations: Array
    reason: Reason | None


@dataclass(frozen=True)
class Deviation:
    """How far the tool is off a line, or may be.

    Attributes:
        position: m.
        angle: rad.
    """

    position: float
    angle: float


HALF_WAY = Deviation(1e-3, float(np.radians(0.5)))  # between two poses that are followed one after the other
