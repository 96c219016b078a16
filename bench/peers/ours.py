"""What ``apc`` does online for a coarse motion: straight edge, database, roadmap, RRT-Connect, shortened."""

from __future__ import annotations

import time
from typing import Any

from bench.peers.queries import Query
from pickcli.errors import Reason
from pickcli.planning.coarse import plan_coarse
from pickcli.planning.context import Planner


def answer(planner: Planner, query: Query, seed: int) -> dict[str, Any]:
    """One answer like a peer's (see ``worker``), and who found it. What it finds is shortened already."""
    began = time.perf_counter()
    found = plan_coarse(
        planner, query.checker, query.q_start, query.q_goal[None], [0.0], seed, "coarse motion"
    )
    took = time.perf_counter() - began
    if isinstance(found, Reason):
        return {"first": None, "first_s": took, "short": None, "short_s": took, "source": "none"}
    path = found.waypoints.tolist()
    return {"first": path, "first_s": took, "short": path, "short_s": took, "source": found.source}
