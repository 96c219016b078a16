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
    began, began_cpu = time.perf_counter(), time.process_time()
    found = plan_coarse(
        planner, query.checker, query.q_start, query.q_goal[None], [0.0], seed, "coarse motion"
    )
    took, cpu = time.perf_counter() - began, time.process_time() - began_cpu
    path = None if isinstance(found, Reason) else found.waypoints.tolist()
    source = "nobody" if isinstance(found, Reason) else found.source
    return {
        "first": path, "first_s": took, "first_cpu_s": cpu, "short": path, "short_s": took, "source": source
    }  # fmt: skip
