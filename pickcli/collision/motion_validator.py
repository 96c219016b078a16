"""Protocol of validators for all moving bodies: the robot, an item, the tool.

OMPL has two classes for this, StateValidityChecker and MotionValidator; here one object does both, because
the kernel proves a whole edge at the cost of a few of its configurations.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.kernel import Checker


class MotionValidator(Protocol):
    """Proves which motions are free, for a held item and tool state that it knows itself.

    It may require more than its kernel checker with its margin: paths of the kernel's planner have to be
    validated once more.
    """

    @property
    def kernel(self) -> Checker:
        """Kernel checker with the moving body and the world around it."""

    @property
    def margin(self) -> float:
        """Clearance in m that is kept from everything."""

    def is_valid(self, q: Array) -> bool:
        """Whether a configuration keeps the margin.

        Args:
            q: (n,) configuration.

        Returns:
            True if it does.
        """

    def are_valid(self, Q: Array) -> NDArray[np.bool_]:
        """Whether each of many configurations keeps the margin.

        Args:
            Q: (N, n) configurations.

        Returns:
            (N,) True for those that do.
        """

    def is_valid_edge(self, q0: Array, q1: Array) -> bool:
        """Whether every point of a straight edge is proven to keep the margin.

        Args:
            q0: (n,) configuration at the start.
            q1: (n,) configuration at the end.

        Returns:
            True if it is proven.
        """

    def is_valid_path(self, Q: Array, slack: Array | None = None) -> bool:
        """Whether every edge of a polyline is proven.

        Args:
            Q: (N, n) waypoints.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            True if all are.
        """

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        """Find the first edge of a polyline that is not proven.

        Args:
            Q: (N, n) waypoints.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            Index of the edge, -1 if all are proven.
        """

    def explain(self, q: Array) -> Reason:
        """Explain why a configuration is not valid.

        Args:
            q: (n,) configuration.

        Returns:
            Part of the body, obstacle and depth.
        """

    def explain_path(self, Q: Array, slack: Array | None = None) -> Reason:
        """Explain why a polyline is not proven, by its first edge that is not.

        Args:
            Q: (N, n) waypoints.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            Part of the body, obstacle, depth, and location on the edge.
        """


def explain_each(checker: MotionValidator, Q: Array, what: str, where: str) -> Failures:
    """Explain what blocks each of several configurations, none of which is valid; evaluated lazily.

    Args:
        checker: The validator.
        Q: (N, n) configurations.
        what: What cannot be done in any of them.
        where: Name of the segment.

    Returns:
        One reason for each configuration, with the item that is in the way, if there is one.
    """

    def blocked() -> Iterator[Reason]:
        for why in map(checker.explain, Q):
            yield Reason(what, where, str(why), why.in_the_way)

    return Failures((blocked,))
