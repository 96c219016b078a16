"""Which bins of fresh orders can be stowed, by the number of their items, and how long that takes.

python -m bench.stowing [--orders 20] [--seed 0] [--task pick] [--year 2016] [--least 1]
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.random_scenes.bin_layout import ItemInstance
from pickcli.random_scenes.make_scene import fill_bin
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.trial.make_order import YEARS, make_order
from pickcli.trial.order import OrderKind

CELL = "apc2016_delft"


@dataclass(frozen=True)
class Stowed:
    """What came of one bin."""

    seed: int
    bin: str
    n_items: int
    seconds: float  # CPU time of the process
    failure: str  # "" if it was stowed


def stow(seeds: range, task: OrderKind, year: int, least: int) -> Iterator[Stowed]:
    """Every bin of fresh orders with at least so many items, stowed from the seed of its order."""
    cell = load_cell(CELL)
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise(), 0)
    for seed in seeds:
        for name, items in make_order(task, year, seed).bin_contents.items():
            if len(items) < least:
                continue
            contents = [ItemInstance(f"{k}:{item}", cell.item(item, year)) for k, item in enumerate(items)]
            begun, failure = time.process_time(), ""
            try:
                fill_bin(scene, name, contents, seed)
            except InputError as error:
                failure = str(error)
            yield Stowed(seed, name, len(items), time.process_time() - begun, failure)


def main() -> None:
    """Stow, print the table and every failure."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--orders", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--task", choices=["pick", "stow"], default="pick")
    parser.add_argument("--year", type=int, choices=YEARS, default=2016)
    parser.add_argument("--least", type=int, default=1, help="items in a bin")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.orders)
    by_number: dict[int, list[Stowed]] = defaultdict(list)
    for stowed in stow(seeds, OrderKind(options.task), options.year, options.least):
        by_number[stowed.n_items].append(stowed)
        if stowed.failure:
            print(f"order {stowed.seed}, {stowed.seconds:.1f} s: {stowed.failure}", flush=True)
    table = Table("items", "bins", "stowed", "CPU s median", "95 %", "max")
    everything = [stowed for those in by_number.values() for stowed in those]
    for n_items, those in [*sorted(by_number.items()), ("all", everything)]:
        seconds = [stowed.seconds for stowed in those]
        table.add_row(
            str(n_items), str(len(those)), str(sum(not stowed.failure for stowed in those)),
            *(f"{np.percentile(seconds, q):.2f}" for q in (50, 95, 100)),
        )  # fmt: skip
    Console().print(table)


if __name__ == "__main__":
    main()
