"""What coarse queries found that no file held, and where it is collected while they are answered.

An experience-based planner keeps the paths that its planner had to find (Lightning, Berenson et al. 2012;
Thunder, Coleman et al. 2015). Here a query returns
its experience, and who asked it records that; what is worth keeping is proven and stored later.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.roadmap.trajectory_database import PayloadClass


@dataclass(frozen=True, eq=False)
class QueryExperience:
    """One query that no stored motion answered.

    Attributes:
        q_start: (n,) where the motion begins.
        q_goal: (n,) where it ends.
        payload: Class of what was held.
        polylines: Paths (K, n) that the roadmap could be given; proven in the scene of the query alone.
    """

    q_start: Array
    q_goal: Array
    payload: PayloadClass
    polylines: tuple[Array, ...]


class ExperienceRecorder:
    """Collects the experience of queries, in the order in which they were asked."""

    def __init__(self) -> None:
        """Begin with nothing."""
        self._recorded: list[QueryExperience] = []
        self._n_taken = 0

    def record(self, experience: Iterable[QueryExperience]) -> None:
        """Add what queries found.

        Args:
            experience: The queries and their polylines, in the order in which they were asked.
        """
        self._recorded += experience

    @property
    def recorded(self) -> tuple[QueryExperience, ...]:
        """Everything recorded so far."""
        return tuple(self._recorded)

    def take(self) -> tuple[QueryExperience, ...]:
        """Take what was recorded since the last call, for who stores it meanwhile.

        Returns:
            The experience, in the order of the queries.
        """
        taken = tuple(self._recorded[self._n_taken :])
        self._n_taken = len(self._recorded)
        return taken
