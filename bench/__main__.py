"""Every figure the project promises, measured: ``make bench``.

    python -m bench [--json FILE] [--orders 20] [--no-builds]

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

from bench import (
    builds,
    carry,
    events,
    first_paths,
    flips,
    fresh,
    kernel,
    kills,
    perception,
    refresh,
    routes,
    startup,
    store,
)

Row = tuple[str, str, float, bool]  # what, promise, measured, kept


def measure(n_orders: int, with_builds: bool) -> dict[str, Any]:
    """All benchmarks, the quiet ones first."""
    slow = {"builds": builds.measure, "kills": kills.measure, "flips": flips.measure}
    return {
        "machine": {
            "python": platform.python_version(),
            "processor": platform.processor(),
            "cores": os.cpu_count(),
        },
        "kernel": kernel.measure(),
        "pictures": perception.measure(),
        "first_paths": first_paths.measure(),
        "startup": startup.measure(),
        "store": store.measure(),
        "refresh": refresh.measure(),
        "routes": routes.measure(),
        "events": events.measure(),
        "carry": carry.measure(),
        "fresh": fresh.measure(range(n_orders)),
        **{name: measured() for name, measured in slow.items() if with_builds},
    }


def rows(figures: dict[str, Any]) -> Iterator[Row]:
    """Promise against measurement."""
    t, k, s = figures["fresh"], figures["kernel"], figures["startup"]
    pick, seen = t["planning_ms"], t["verification_ms"]
    yield from fresh.rows(t)
    yield _at_least("fresh orders: items in the tote, mean (of 12)", 9.0, t["items_in_tote_mean"])
    yield _at_least("fresh orders: items in the tote, worst trial", 7, t["items_in_tote_least"])
    for name, limit in (("median", 60), ("p95", 200), ("p99", 500)):
        yield _at_most(f"plan_pick, warm, {name}, ms", limit, pick[name])
    yield _at_most("verification, worst, ms", 1000, seen["max"])
    yield _at_most("kernel: valid edge of 32 configurations, us", 5, k["kernel_us"])
    yield _at_least("kernel against pybullet, same states, times", 100, k["pybullet_ratio"])
    yield _at_least("kernel against python-fcl, same states, times", 100, k["python_fcl_ratio"])
    pictures = figures["pictures"]
    for sensor in perception.SENSORS:
        yield _at_most(
            f"depth with noise, 640x480, {sensor}, ms", 40, pictures[f"{sensor} 640x480"]["median_ms"]
        )
    yield _at_most("colour picture, 1280x1024, ms", 80, pictures["colour 1280x1024"]["median_ms"])
    first = figures["first_paths"]
    yield _at_most("first path among shelves, boxes, tables, p95, ms", 5, first["all"]["p95_ms"])
    yield _at_least("such queries that are solved, %", 99, 100 * first["solved"] / first["queries"])
    yield _at_most("from leaving to released in the tote, mean, s", 12, t["delivery_s_mean"])
    yield _at_most("roadmap and trajectories together, MB", 20, figures["store"]["size_mb"])
    yield _at_most("open a file and fetch one motion, median, ms", 2, figures["store"]["fetch_ms"])
    yield _at_most("A* with start and goal connected, warm, median, ms", 5, figures["routes"]["route_ms"])
    again = figures["refresh"]
    yield _at_most("a wall moved: motions proven again, worst wall, %", 15, 100 * again["proven_again_share"])
    yield _at_most("a wall moved: refresh, worst wall, % of the build", 10, 100 * again["time_share"])
    yield _at_most("apc --help, s", 0.2, s["help_s"])
    yield _at_most("apc plan-pick, one-shot, s", 2.0, s["plan_pick_s"])
    for robot, figure in figures["events"].items():
        yield _at_most(f"events, robot {robot}: distance from trigger, mm", 2, figure["distance_mm"])
    gain = figures["carry"]["gain_s"]
    if gain is not None:
        yield _at_least("carries whose load binds: quicker than all of it slowed, mean, s", 0.5, gain)
    if "builds" in figures:
        yield from _rows_of_builds(figures["builds"], figures["kills"], figures["flips"])


def _rows_of_builds(built: dict[str, Any], killed: dict[str, Any], flipped: dict[str, Any]) -> Iterator[Row]:
    yield _at_most("build of all motions on 2 processes, min", 1.5, built["build_2_jobs_s"] / 60.0)
    yield _at_least("the same, speed-up from 1 to 2", 1.8, built["speed_up"])
    yield _at_most("roadmap on 2 processes, min", 5, built["roadmap_2_jobs_s"] / 60.0)
    yield _at_most("50 kills: files that do not open as they were", 0, killed["unreadable"])
    yield _at_most("50 kills: finished tasks that were lost", 0, killed["finished_tasks_lost"])
    for name, counts in flipped.items():
        bad = sum(n for outcome, n in counts.items() if outcome not in ("found", "harmless"))
        yield _at_most(f"1,000 flips of the {name}: not found and not harmless", 0, bad)


def _at_least(what: str, promise: float, value: float) -> Row:
    return what, f">= {promise:g}", value, value >= promise


def _at_most(what: str, promise: float, value: float) -> Row:
    return what, f"<= {promise:g}", value, value <= promise


def main() -> None:
    """Measure, print, write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, default=Path("runs/bench.json"), metavar="FILE")
    parser.add_argument("--orders", type=int, default=20, help="fresh orders to play: half a minute each")
    parser.add_argument("--no-builds", action="store_true", help="leave out builds, kills and flips: minutes")
    given = parser.parse_args()
    figures = measure(given.orders, not given.no_builds)
    table = Table("figure", "promise", "measured", "")
    for what, promise, value, is_kept in rows(figures):
        table.add_row(what, promise, f"{value:.3g}", "" if is_kept else "missed")
    Console(width=110).print(table)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"wrote {given.json}")


if __name__ == "__main__":
    main()
