"""The five pick orders of 2016 with several seeds: what ends in the tote, how fast, how exactly.

    python -m bench.trials [--orders NAME,...] [--seeds 1,2,3] [--json FILE]

One warm process plans, verifies and plays all of it, as ``apc run-trial`` does. Planning times are those of
successful queries; failed ones are reported apart.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.load import load_cell
from pickcli.planning.context import Planner
from pickcli.precompute.artifacts import ensure_artifacts
from pickcli.roadmap.store import read_database, read_roadmap
from pickcli.trial.arena import SimulatedArena, crew_of
from pickcli.trial.loop import run_trial
from pickcli.trial.make_scene import make_scene
from pickcli.trial.order import read_order
from pickcli.trial.player import TrialSettings
from pickcli.trial.result import Outcome, TrialResult

ORDERS = ("jsk_pick_sample", "delft_pick_2", "delft_pick_3", "delft_pick_4", "delft_pick_5")
TASKS = Path(__file__).parent.parent / "data" / "tasks"


def planner() -> Planner:
    """A warm planner with the default cell's own files."""
    cell = load_cell("apc2016_delft")
    paths = ensure_artifacts(cell)
    return Planner(cell, read_roadmap(paths.roadmap, cell), read_database(paths.trajectories, cell))


def play(warm: Planner, order_name: str, seed: int) -> TrialResult:
    """One trial, from the order to the score."""
    order = read_order(TASKS / f"{order_name}.json", warm.cell)
    scene = make_scene(order.bin_contents, warm.cell, seed, order.year)
    return run_trial(order, crew_of(warm, SimulatedArena(scene)), TrialSettings(seed))


def measure(orders: tuple[str, ...] = ORDERS, seeds: tuple[int, ...] = (1, 2, 3)) -> dict[str, Any]:
    """All trials, and what they have in common."""
    warm = planner()
    play(warm, orders[0], 99)  # covers and caches of a warm process
    trials: list[dict[str, Any]] = []
    planned: list[float] = []
    failed: list[float] = []
    verified: list[float] = []
    delivery: list[float] = []
    for order in orders:
        for seed in seeds:
            result = play(warm, order, seed)
            trials.append(_summary(order, seed, result))
            print(json.dumps(trials[-1]), flush=True)
            for attempt in result.attempts:
                ms = attempt.statistics.get("planning_ms")
                if ms is not None:
                    (planned if attempt.plan else failed).append(ms)
                if "verification_ms" in attempt.statistics:
                    verified.append(attempt.statistics["verification_ms"])
                if attempt.outcome is Outcome.IN_TOTE and attempt.plan:
                    held = [s for s in attempt.plan.segments if s.held is not None]
                    delivery.append(held[-1].t_end)
    delivered = [t["items_in_tote"] for t in trials]
    return {
        "items_in_tote_mean": float(np.mean(delivered)),
        "items_in_tote_least": int(min(delivered)),
        "collisions": sum(t["collisions"] for t in trials),
        "limit_violations": sum(t["limit_violations"] for t in trials),
        "plan_pick_ms": _spread(planned),
        "plan_pick_failed_ms": _spread(failed),
        "verification_ms": _spread(verified),
        "delivery_s_mean": float(np.mean(delivery)) if delivery else None,
        "event_distance_mm_max": max(trial["event_distance_mm"] for trial in trials),
        "trials": trials,
    }


def _distances(result: TrialResult) -> Iterator[float]:
    """m of tool path between each fired event and its trigger."""
    for attempt in result.attempts:
        for run in attempt.executions:
            yield from (event["distance"] for event in run.events)


def _summary(order: str, seed: int, result: TrialResult) -> dict[str, Any]:
    return {
        "order": order,
        "seed": seed,
        "items_in_tote": sum(t.outcome is Outcome.IN_TOTE for t in result.targets),
        "score": result.score.total,
        "max_score": result.score.maximum,
        "collisions": result.n_collisions,
        "limit_violations": result.n_limit_violations,
        "event_distance_mm": 1e3 * max(_distances(result), default=0.0),
        "missed": {
            t.target.item: f"{t.outcome}: {t.reason}"[:160]
            for t in result.targets
            if t.outcome is not Outcome.IN_TOTE
        },
    }


def _spread(values: list[float]) -> dict[str, float]:
    if not values:
        return {"n": 0}
    median, p95, p99 = np.percentile(values, [50, 95, 99])
    return {
        "n": len(values),
        "median": float(median),
        "p95": float(p95),
        "p99": float(p99),
        "max": max(values),
    }


def main() -> None:
    """Play and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", default=",".join(ORDERS))
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(tuple(given.orders.split(",")), tuple(int(s) for s in given.seeds.split(",")))
    print(json.dumps({k: v for k, v in figures.items() if k != "trials"}, indent=2))
    if given.json:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
