"""What ``apc`` does online for a coarse motion: a first path, and the whole answer of a query."""

from __future__ import annotations

import time
from typing import Any

from bench.peers.queries import Query
from pickcli.errors import Failures
from pickcli.path_planning.sampling_planner import plan
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import PlanningContext


def answer(context: PlanningContext, query: Query, seed: int) -> dict[str, Any]:
    """One answer like a peer's (see ``worker``), and who found it.

    The whole answer does not begin with the first path: it is asked for again.
    """
    began, began_cpu = time.perf_counter(), time.process_time()
    first = plan(query.checker, context.space, query.q_start, query.q_goal[None], seed=seed)
    first_s, first_cpu_s = time.perf_counter() - began, time.process_time() - began_cpu
    began = time.perf_counter()
    whole = plan_coarse(
        context, query.checker, query.q_start, query.q_goal[None], [0.0], seed, "coarse motion"
    )
    whole_s = time.perf_counter() - began
    path = None if isinstance(whole, Failures) else whole
    return {
        "first": None if first is None else first.waypoints.tolist(),
        "first_s": first_s,
        "first_cpu_s": first_cpu_s,
        "short": None if path is None else path.waypoints.tolist(),
        "short_s": whole_s,
        "source": "nobody" if path is None else path.source,
    }
