"""Targets with a plan, and planning time, by where grasps come from: side by side on fresh scenes.

    python -m bench.approaches [--scenes 6] [--orders 0] [--task pick] [--seed 0] [--approaches lines region]
                               [--json FILE]

Every item of every bin of scenes from fresh orders that a cup can hold is planned as it is seen in a trial,
with each ``--approach`` of ``apc plan-pick`` in turn, and every plan is verified. Times are those of the
processor: ratios between approaches are of one run, item by item. Then --orders fresh orders are played with
each, as by ``bench.fresh``, order by order; there planning times are by the wall clock.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from bench.fresh import jobs, play_all, summary
from bench.rejections import Tally, fresh_scenes, tally
from bench.warm import context
from pickcli.planning.pick_settings import GraspApproach
from pickcli.simulation.reality import Reality
from pickcli.trial.order import OrderKind
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive


def measure(seeds: range, approaches: Sequence[GraspApproach]) -> dict[str, Tally]:
    """What came of the queries, by approach."""
    warm = context()
    contexts = {str(approach): warm.with_approach(approach) for approach in approaches}
    tallies = {name: Tally() for name in contexts}
    for seed, scene in fresh_scenes(warm, seeds):
        seen = perceive(scene, DEFAULT_NOISE, seed, 1, Reality())
        for name, each in contexts.items():
            if seed == seeds[0]:  # not counted: models are made by who needs them first
                tally(each, seen, seed, Tally())
            tally(each, seen, seed, tallies[name])
        told = (f"{name} {found.plans} of {found.asked.total()}" for name, found in tallies.items())
        print(f"scene {seed}: {', '.join(told)}", flush=True)
    return tallies


def table_of(tallies: dict[str, Tally]) -> Table:
    """A row for each approach."""
    table = Table("approach", "targets", "with a plan", "by region", "refused", "plan, ms: median", "p95",
                  "no plan, ms: median", "p95")  # fmt: skip
    for name, found in tallies.items():
        times = (f"{np.quantile(ms, q):.0f}" for ms in (found.planning, found.failing) for q in (0.5, 0.95))
        numbers = found.asked.total(), found.plans, found.by_region, found.rejected
        table.add_row(name, *map(str, numbers), *times)
    return table


def played(seeds: range, task: OrderKind, approaches: Sequence[GraspApproach]) -> dict[str, dict[str, Any]]:
    """The summary of trials, by approach; each order is played with all of them before the next."""
    of_each = [jobs(seeds, 2016, None, task=task, approach=approach) for approach in approaches]
    trials = play_all([job for of_order in zip(*of_each, strict=True) for job in of_order], processes=1)
    n = len(of_each)  # an order that cannot be stowed is left out for all of them
    return {str(approach): summary(trials[k::n]) for k, approach in enumerate(approaches)}


def table_of_trials(trials: dict[str, dict[str, Any]]) -> Table:
    """A row for each approach."""
    table = Table("approach", "trials", "items, mean", "points, mean", "items by region", "plan, ms: median",
                  "p95", "no plan, ms: median")  # fmt: skip
    for name, found in trials.items():
        took, failed = found["planning_ms"], found["planning_failed_ms"]
        table.add_row(
            name, f"{found['trials']}", f"{found['items_in_tote_mean']:.2f}", f"{found['score_mean']:.1f}",
            f"{found['by_region']}", f"{took['median']:.0f}", f"{took['p95']:.0f}",
            f"{failed.get('median', 0.0):.0f}",
        )  # fmt: skip
    return table


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--orders", type=int, default=0, help="that are played")
    parser.add_argument("--task", choices=("pick", "stow"), default="pick")
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--approaches", type=GraspApproach, nargs="+", default=list(GraspApproach))
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    console, figures = Console(width=110), dict[str, Any]()
    if given.scenes:
        tallies = measure(range(given.seed, given.seed + given.scenes), given.approaches)
        console.print(table_of(tallies))
        figures["queries"] = {name: found.figures() for name, found in tallies.items()}
    if given.orders:
        seeds = range(given.seed, given.seed + given.orders)
        figures["trials"] = played(seeds, OrderKind(given.task), given.approaches)
        console.print(table_of_trials(figures["trials"]))
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
