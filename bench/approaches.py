"""Targets with a plan, and planning time, by where grasps come from: side by side on fresh scenes.

    python -m bench.approaches [--scenes 6] [--seed 0] [--json FILE]

Every item of every bin of scenes from fresh orders that a cup can hold is planned as it is seen in a trial, with
each ``--approach`` of ``apc plan-pick`` in turn, and every plan is verified. Times are those of the processor:
ratios between approaches are of one run, item by item.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from bench.rejections import Tally, fresh_scenes, tally
from bench.warm import context
from pickcli.planning.pick_settings import GraspApproach
from pickcli.simulation.reality import Reality
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive


def measure(seeds: range) -> dict[str, Tally]:
    """What came of the queries, by approach."""
    warm = context()
    contexts = {str(approach): warm.with_approach(approach) for approach in GraspApproach}
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


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    tallies = measure(range(given.seed, given.seed + given.scenes))
    Console().print(table_of(tallies))
    if given.json is not None:
        figures: dict[str, Any] = {name: found.figures() for name, found in tallies.items()}
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
