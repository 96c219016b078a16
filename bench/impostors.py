"""Whether an item is answered where another one of like shape, which nobody listed, stands in its place.

    python -m bench.impostors --seeds 2 --seed 5200 [--sensor ensenso] [--looks 3]

Each plain item of 2016 is listed alone in a bin. Once it is there; then each of the three items of 2016 whose
extents are most like its own is there instead, once for each seed. Prints are not looked for.
Printed is how many are answered, how many of these with a bound, and how many are refused for their colours.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator, Sequence

import numpy as np

from bench.perceived import seen_bins
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.errors import InputError
from pickcli.perception.items.confidence import LEAST_OWN_COLOUR
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.product_model import product_model
from pickcli.random_scenes.make_scene import make_scene

YEAR, N_ALIKE = 2016, 3
BIN = "bin_A"


def most_alike(item: Item, items: Sequence[Item]) -> list[Item]:
    """Those whose extents differ least from an item's, the most alike first."""

    def off(other: Item) -> float:
        return float(np.abs(np.sort(other.shape.extents) - np.sort(item.shape.extents)).max())

    return sorted((each for each in items if each != item), key=off)[:N_ALIKE]


def answers(
    cell: Cell, cameras: tuple[SensorModel, int], listed: Item, there: Item, seeds: Sequence[int]
) -> Iterator[str]:
    """What is said of a listed item where it, or another one, is there: once for each seed.

    cameras: the sensor, and from how many places it looks
    """
    for seed in seeds:
        scene = make_scene({BIN: [there.name]}, cell, seed)
        seen = next(iter(seen_bins(scene, *cameras)))
        try:
            (answer,) = seen.perceived([ListedItem.of(listed.name, listed, False)]).items
        except InputError:
            yield "too little seen"
            continue
        if answer.is_answer:
            yield "answered" if answer.bound is None else "answered with a bound"
        else:
            own = 1.0 if answer.support is None else answer.support.own_colour
            yield "refused for its colours" if own < LEAST_OWN_COLOUR else "refused"


def main() -> None:
    """Look, and print the counts."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=2, help="how many scenes of each pair")
    parser.add_argument("--seed", type=int, default=5200, help="the first")
    parser.add_argument("--sensor", default="ensenso", help="a file under data/sensors")
    parser.add_argument("--looks", type=int, default=1, help="into the bin, from so many places")
    given = parser.parse_args()
    cell, cameras = load_cell("apc2016_delft"), (read_sensor(sensor_file(given.sensor)), given.looks)
    items = [item for (_, year), item in sorted(cell.items.items()) if year == YEAR]
    items = [each for each in items if _has_model(each)]
    seeds = range(given.seed, given.seed + given.seeds)
    right, wrong = Counter[str](), Counter[str]()
    for item in (each for each in items if not each.is_printed):
        right.update(answers(cell, cameras, item, item, seeds))
        for other in most_alike(item, items):
            told = Counter(answers(cell, cameras, item, other, seeds))
            wrong.update(told)
            if answered := sum(n for what, n in told.items() if what.startswith("answered")):
                print(f"{item.name}: answered {answered} times for {other.name}")
    print(f"there: {told_of(right)}\nanother is there: {told_of(wrong)}")


def _has_model(item: Item) -> bool:
    try:
        product_model(item)
    except InputError:
        return False
    return True


def told_of(counts: Counter[str]) -> str:
    """Counts, the most frequent first."""
    return ", ".join(f"{what} {n}" for what, n in counts.most_common()) + f", of {counts.total()}"


if __name__ == "__main__":
    main()
