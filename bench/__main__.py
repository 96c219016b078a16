"""Every figure the project promises, measured: ``make bench``.

    python -m bench [--json FILE] [--seeds 1,2,3]

Prints a table of promise and measurement and writes everything to runs/bench.json.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from bench import events, kernel, routes, startup, store, trials

Row = tuple[str, str, float, bool]  # what, promise, measured, kept


def measure(seeds: tuple[int, ...]) -> dict[str, Any]:
    """All benchmarks, the quiet ones first."""
    return {
        "machine": {
            "python": platform.python_version(),
            "processor": platform.processor(),
            "cores": os.cpu_count(),
        },
        "kernel": kernel.measure(),
        "startup": startup.measure(),
        "store": store.measure(),
        "routes": routes.measure(),
        "events": events.measure(),
        "trials": trials.measure(seeds=seeds),
    }


def rows(figures: dict[str, Any]) -> Iterator[Row]:
    """Promise against measurement."""
    t, k, s = figures["trials"], figures["kernel"], figures["startup"]
    pick, seen = t["plan_pick_ms"], t["verification_ms"]
    yield _at_least("items in the tote, mean of all trials (of 12)", 9.0, t["items_in_tote_mean"])
    yield _at_least("items in the tote, worst trial", 7, t["items_in_tote_least"])
    yield _at_most("collisions in executed motion", 0, t["collisions"])
    yield _at_most("limit violations in executed motion", 0, t["limit_violations"])
    for name, limit in (("median", 60), ("p95", 200), ("p99", 500)):
        yield _at_most(f"plan_pick, warm, {name}, ms", limit, pick[name])
    yield _at_most("verification, worst, ms", 1000, seen["max"])
    yield _at_most("kernel: valid edge of 32 configurations, us", 5, k["kernel_us"])
    yield _at_least("kernel against pybullet, same states, times", 100, k["pybullet_ratio"])
    yield _at_least("kernel against python-fcl, same states, times", 100, k["python_fcl_ratio"])
    yield _at_most("from leaving to released in the tote, mean, s", 12, t["delivery_s_mean"])
    yield _at_most("roadmap and trajectories together, MB", 20, figures["store"]["size_mb"])
    yield _at_most("open a file and fetch one motion, median, ms", 2, figures["store"]["fetch_ms"])
    yield _at_most("A* with start and goal connected, warm, median, ms", 5, figures["routes"]["route_ms"])
    yield _at_most("apc --help, s", 0.2, s["help_s"])
    yield _at_most("apc plan-pick, one-shot, s", 2.0, s["plan_pick_s"])
    for robot, figure in figures["events"].items():
        yield _at_most(f"events, robot {robot}: distance from trigger, mm", 2, figure["distance_mm"])
    yield _at_most("events in trials: distance from trigger, mm", 2, t["event_distance_mm_max"])


def _at_least(what: str, promise: float, value: float) -> Row:
    return what, f">= {promise:g}", value, value >= promise


def _at_most(what: str, promise: float, value: float) -> Row:
    return what, f"<= {promise:g}", value, value <= promise


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, default=Path("runs/bench.json"), metavar="FILE")
    parser.add_argument("--seeds", default="1,2,3")
    given = parser.parse_args()
    figures = measure(tuple(int(seed) for seed in given.seeds.split(",")))
    table = Table("figure", "promise", "measured", "")
    for what, promise, value, is_kept in rows(figures):
        table.add_row(what, promise, f"{value:.3g}", "" if is_kept else "missed")
    Console(width=110).print(table)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"wrote {given.json}")


if __name__ == "__main__":
    main()
