"""How soon is a first path found: RRT-Connect of two arms among shelves, boxes and tables.

    python -m bench.first_paths [--queries N] [--seed SEED] [--json FILE]

The queries are those of `bench/arm_queries.py`, none of which a straight edge answers. Every one is asked
three times and the least time counts, as other load only ever adds time; entering the world is not counted.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from bench.arm_queries import ARMS, MARGIN, Query, QueryArm, enter, make_queries, read_arm
from pickcli.kernel import rrt_connect
from pickcli.path_planning.planner_options import DEFAULT_OPTIONS

_N_RUNS = 3


def measure(n_queries: int = 500, seed: int = 1) -> dict[str, Any]:
    """Times until a first path, ms, and how many of the queries were solved.

    Args:
        n_queries: Of both arms together.
        seed: Of the queries.

    Returns:
        Figures over all queries, and of every arm in every setting. What is not solved counts with
        the time that it took.
    """
    times: dict[str, list[float]] = {}
    n_solved = 0
    for name in ARMS:
        arm = read_arm(name)
        for number, query in enumerate(make_queries(name, arm, n_queries // len(ARMS), seed)):
            found, seconds = _first_path(arm, query, number)
            n_solved += found
            times.setdefault(f"{name}, {query.setting}", []).append(1e3 * seconds)
    together = [t for some in times.values() for t in some]
    return {
        "queries": len(together),
        "solved": n_solved,
        "all": _spread(together),
        "of": {name: _spread(some) for name, some in times.items()},
    }


def _first_path(arm: QueryArm, query: Query, seed: int) -> tuple[bool, float]:
    """Whether a path was found, and the least time of several runs, s."""
    checker = arm.checker()
    enter(checker, query.T_world_box, query.half_extents)
    step = DEFAULT_OPTIONS.step * float(np.linalg.norm(arm.upper - arm.lower))
    least = np.inf
    for _ in range(_N_RUNS):
        began = perf_counter()
        path = rrt_connect(
            checker, query.start, query.goals, arm.lower, arm.upper, seed, DEFAULT_OPTIONS.max_iterations,
            step, MARGIN,
        )  # fmt: skip
        least = min(least, perf_counter() - began)
    return len(path) > 0, least


def _spread(times: list[float]) -> dict[str, float]:
    names = ("median_ms", "p95_ms", "p99_ms")
    return {
        "mean_ms": float(np.mean(times)),
        **dict(zip(names, np.percentile(times, (50, 95, 99)), strict=True)),
    }


def main() -> None:
    """Print the figures and, if asked, write them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--queries", type=int, default=500, help="of both arms together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures to FILE as well")
    given = parser.parse_args()
    figures = measure(given.queries, given.seed)
    print(f"{figures['solved']} of {figures['queries']} solved")
    for name, spread in {"all": figures["all"], **figures["of"]}.items():
        print(f"{name:24} " + "  ".join(f"{figure} {value:.3g}" for figure, value in spread.items()))
    if given.json:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
