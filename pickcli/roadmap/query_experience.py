"""Experience of coarse queries: paths that no file held, collected while queries are answered.

An experience-based planner keeps the paths that its planner had to find (Lightning, Berenson et al. 2012;
Thunder, Coleman et al. 2015). Here a query returns its experience and its caller records it; paths that are
worth keeping are proven and stored later.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.roadmap.trajectory_database import PayloadClass


@dataclass(frozen=True, eq=False)
class QueryExperience:
    """Experience of one query that no stored motion answered.

    Attributes:
        q_start: (n,) start configuration.
        q_goal: (n,) goal configuration.
        payload: Payload class of the held item.
        polylines: New paths (K, n) for the roadmap; proven only in the scene of the query.
    """

    q_start: Array
    q_goal: Array
    payload: PayloadClass
    polylines: tuple[Array, ...]


class ExperienceRecorder:
    """Collects the experience of queries, in their order."""

    def __init__(self) -> None:
        """Create an empty recorder."""
        self._recorded: list[QueryExperience] = []
        self._n_taken = 0

    def record(self, experience: Iterable[QueryExperience]) -> None:
        """Add the experience of queries.

        Args:
            experience: The queries with their polylines, in their order.
        """
        self._recorded += experience

    @property
    def recorded(self) -> tuple[QueryExperience, ...]:
        """Everything recorded so far."""
        return tuple(self._recorded)

    def take(self) -> tuple[QueryExperience, ...]:
        """Return the experience recorded since the last call, e.g. to store it in between.

        Returns:
            The experience, in the order of the queries.
        """
        taken = tuple(self._recorded[self._n_taken :])
        self._n_taken = len(self._recorded)
        return taken
