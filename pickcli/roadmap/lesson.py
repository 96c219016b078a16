"""What a coarse query found that no file held."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.geometry import Array
from pickcli.roadmap.database import PayloadClass


@dataclass(frozen=True, eq=False)
class Lesson:
    """One query that no stored motion answered.

    q_start, q_goal: (n,) its ends
    payload: class of what was held
    polylines: (K, n) each, that the roadmap could be given; proven in the scene of the query alone
    """

    q_start: Array
    q_goal: Array
    payload: PayloadClass
    polylines: tuple[Array, ...]
