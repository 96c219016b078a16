"""ARA* on the workspace lattice: whether its bound on the cost is kept, and what its searches cost.

    python -m bench.lattice [--streams 2] [--items 4] [--seed 0] [--arm left] [--expansions 300]
        [--exact 3000]

Queries are those of ``apc compare-planners --stream`` on streams of fresh seeds. Each is searched with
``--expansions``; and once more from the start with epsilon 1 alone, which is A* and ends with the least cost,
with at most ``--exact``. Of the queries whose least cost is known so, it prints by how much the first and the
last path exceed it, beside the bounds that were stated for them. A bound is broken if a path costs more.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.errors import Reason
from pickcli.kinematics.arm import Arm
from pickcli.path_planning.ara_star import AraStarSettings
from pickcli.path_planning.lattice_planner import LatticePlan, LatticePlannerSettings, plan_on_lattice
from pickcli.path_planning.workspace_lattice import HandGoals
from pickcli.planner_benchmark.benchmark_entries import BenchmarkQuery
from pickcli.planner_benchmark.stream_queries import stream_queries
from pickcli.planning.planning_context import PlanningContext
from pickcli.random_scenes.make_stream import StreamRequest, make_stream

CELL, SPEED, GAP = "pr2_belt", 0.33, (1.8, 2.4)
ROUNDING = 1e-9


@dataclass(frozen=True)
class Searched:
    """One query: the search, its processor time in ms, and the least cost, None if not known."""

    plan: LatticePlan | None
    ms: float
    least: float | None


def search(query: BenchmarkQuery, settings: AraStarSettings) -> LatticePlan | None:
    """Search one query; None if no path is found."""
    arm = Arm(query.cell.robot)
    goals = HandGoals(arm.tips(query.goals, query.planning.tool_state), query.goals)
    found = plan_on_lattice(arm, query.planning, query.start, goals, LatticePlannerSettings(settings))
    return None if isinstance(found, Reason) else found


def searched(query: BenchmarkQuery, expansions: int, exact: int) -> Searched:
    """Search one query anytime and exactly."""
    began = time.process_time()
    plan = search(query, AraStarSettings(max_expansions=expansions))
    ms = 1e3 * (time.process_time() - began)
    best = search(query, AraStarSettings((1.0,), exact))
    is_least = best is not None and best.cost_bound <= 1.0 + ROUNDING
    return Searched(plan, ms, best.cost if best is not None and is_least else None)


def queries(arm: str, n_streams: int, n_items: int, seed: int) -> Iterator[BenchmarkQuery]:
    """Yield the queries of the streams of several seeds."""
    workcell = load_workcell(CELL)
    context = PlanningContext(workcell.cell(arm))
    for k in range(n_streams):
        stream = make_stream(workcell.preferred, StreamRequest(n_items, SPEED, GAP), seed + k)
        yield from stream_queries(context, replace(stream, cell=context.cell), seed + k).queries.values()


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--streams", type=int, default=2)
    parser.add_argument("--items", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--arm", default="left")
    parser.add_argument("--expansions", type=int, default=300)
    parser.add_argument("--exact", type=int, default=3000)
    given = parser.parse_args()
    asked = list(queries(given.arm, given.streams, given.items, given.seed))
    found = [searched(query, given.expansions, given.exact) for query in asked]
    solved = [(each.plan, each.least) for each in found if each.plan is not None]
    known = [(plan, least) for plan, least in solved if least is not None]
    print(f"{len(found)} queries, {len(solved)} solved, the least cost known of {len(known)}")
    ms = [each.ms for each in found]
    print(
        f"processor time with at most {given.expansions} expansions: {np.median(ms):.0f} ms, "
        f"p95 {np.percentile(ms, 95):.0f}"
    )
    n_first = [plan.found[0].n_expanded for plan, _ in solved]
    print(f"expansions to the first path: {np.median(n_first):.0f}, worst {max(n_first)}")
    for name, k in (("first", 0), ("last", -1)):
        stated = [plan.found[k].cost_bound for plan, _ in known]
        over = [plan.found[k].cost / least for plan, least in known]
        broken = sum(o > s + ROUNDING for o, s in zip(over, stated, strict=True))
        figures = f"stated {np.median(stated):.3f}, worst {max(stated):.3f}"
        figures += f"; true {np.median(over):.3f}, worst {max(over):.3f}"
        print(f"{name} path over the least cost: {figures}; broken {broken}")


if __name__ == "__main__":
    main()
