"""What each level of reality costs in points: the same fresh orders with one level after the other switched.

    python -m bench.reality [--orders 4] [--seed 0] [--only NAME,...] [--processes 2] [--json FILE]

Every row plays the same orders with one switch set from its default to its ideal level (docs/reality.md), the
last row with all of them. Trials are kept as those of bench.fresh are. A few orders tell the large influences
only: one item is 15 points of 180, and trials differ by two or three of them for reasons of their own. What
the tool cannot hold follows from the orders and data/items alone.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from bench.deliverable import is_holdable
from bench.fresh import FOLDER, jobs, play_all, summary
from pickcli.cell.cell_file import load_cell
from pickcli.simulation.reality import DEFAULT, IDEAL, Reality
from pickcli.trial.make_order import YEARS, make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.score import item_bonuses, target_points

TOGETHER = ("pose_outlier", "pod")  # beginnings of the names of levels that are switched as one


def switches() -> dict[str, dict[str, Any]]:
    """By name, the levels that one switch sets, at their ideal; "all" is the last."""
    found: dict[str, dict[str, Any]] = {}
    for level in fields(Reality):
        ideal = getattr(IDEAL, level.name)
        if ideal != getattr(DEFAULT, level.name):
            name = next((start for start in TOGETHER if level.name.startswith(start)), level.name)
            found.setdefault(name, {})[level.name] = ideal
    found["all"] = {name: level for levels in found.values() for name, level in levels.items()}
    return found


def written(name: str, levels: dict[str, Any], folder: Path = FOLDER) -> Path:
    """A file for --reality with these levels."""
    path = folder / f"levels_{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = ["format: apc reality", "version: 1", *(f"{k}: {json.dumps(v)}" for k, v in levels.items())]
    path.write_text("\n".join(lines) + "\n")
    return path


def measure(seeds: Sequence[int], only: Sequence[str], processes: int) -> dict[str, Any]:
    """The summary of the fresh orders as they are, and with each switch set."""
    found = {"as it is": summary(play_all(jobs(seeds, 2016, None), processes))}
    for name, levels in switches().items():
        if not only or name in only:
            found[name] = summary(play_all(jobs(seeds, 2016, written(name, levels)), processes))
    return found


def holdable_share(year: int, n_orders: int = 1000) -> float:
    """Share of the points of fresh orders that are on targets which the cup can hold."""
    cell = load_cell("apc2016_delft")
    best = held = 0
    for seed in range(n_orders):
        order = make_order(OrderKind.PICK, year, seed)
        bonus = item_bonuses(cell, order)
        for target in order.work_order:
            points = target_points(order, target.bin, target.item, bonus)
            best += points
            held += points * is_holdable(cell.item(target.item, year), [cell.robot.tool])
    return held / best


def main() -> None:
    """Play, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--orders", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--only", default="", help=f"by comma, of: {', '.join(switches())}")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--json", type=Path, default=Path("runs/reality.json"), metavar="FILE")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.orders)
    figures = measure(seeds, [name for name in given.only.split(",") if name], given.processes)
    base = figures["as it is"]
    table = Table(
        "switched to its ideal", "items", "score, % of the most", "more, % points", "drops", "contacts"
    )
    for name, f in figures.items():
        gain = 100.0 * (f["score_share"] - base["score_share"])
        table.add_row(name, f"{f['items_in_tote_mean']:.2f}", f"{100 * f['score_share']:.1f}", f"{gain:+.1f}",
                      str(f["drops"]), str(f["with_contact"]))  # fmt: skip
    Console(width=110).print(table)
    figures["holdable_share"] = {str(year): holdable_share(year) for year in YEARS}
    for year, share in figures["holdable_share"].items():
        print(f"{year}: {100 * share:.1f} % of the points are on targets that the cup can hold (1000 orders)")
    given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"{given.orders} orders from seed {given.seed}; wrote {given.json}")


if __name__ == "__main__":
    main()
