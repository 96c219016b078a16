"""How often plain items of like shape and colour are taken for each other in one look.

    python -m bench.twins --seeds 8 --seed 5100 [--sensor ensenso]

Each seed is a bin with two plain boxes, drawn in size and colour, of which the second is larger by a
difference along each side, or of another colour. An item is swapped if its answer is nearer to the other one
than to itself. Printed is the share of answers that are, by the difference of size of boxes of one colour,
and by the overlap of the colours of boxes of one size. The refusal of twins is left out of it, as that is
what these figures are for.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.perceived import SeenBin, seen_bins
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.sensors.sensor_model import SensorModel
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.product_model import product_model
from pickcli.random_scenes.make_scene import make_scene
from pickcli.seeds import derived_rng

MM = (0.0, 1.0, 2.0, 4.0, 8.0)
SHIFTS = (0, 5, 15, 30)  # of 255, of which red loses and blue gains so much
BIN = "bin_E"
PATTERN = "dove_beauty_bar"


@dataclass(frozen=True)
class Pair:
    """What became of two boxes: how much their colours overlap, and how many answers are swapped."""

    mm: float
    shift: int
    overlap: float
    answers: int
    swapped: int


def boxes(cell: Cell, seed: int, mm: float, shift: int) -> tuple[Item, Item]:
    """Two plain boxes."""
    rng = derived_rng("twins", seed)
    size = rng.uniform([0.09, 0.06, 0.03], [0.13, 0.08, 0.05])
    red, green, blue = (int(v) for v in rng.integers(70, 190, 3))
    one = replace(
        cell.item(PATTERN, 2016), name="one", is_printed=False, colour=(red, green, blue),
        shape=Shape(ShapeKind.BOX, tuple(size.tolist())),
    )  # fmt: skip
    larger = Shape(ShapeKind.BOX, tuple((size + 1e-3 * mm).tolist()))
    return one, replace(one, name="other", shape=larger, colour=(red - shift, green, blue + shift))


def looked_at(cell: Cell, sensor: SensorModel, seed: int, pair: tuple[Item, Item]) -> SeenBin:
    """The bin with both."""
    own = replace(cell, items={**cell.items, **{(each.name, 2016): each for each in pair}})
    scene = make_scene({BIN: [each.name for each in pair]}, own, seed)
    return next(seen for seen in seen_bins(scene, sensor) if seen.place.name == BIN)


def swapped(seen: SeenBin) -> list[bool]:
    """Of each answer whether it is nearer to the other item."""
    (look,) = seen.looks([ListedItem.of(each.id, each.item, False) for each in seen.items])
    at = [each.T_world_item[:3, 3] for each in seen.items]
    found = []
    for i, T in look.poses.items():
        if look.confidence(i) >= 0.8:
            off = [float(np.linalg.norm(T[:3, 3] - other)) for other in at]
            found.append(off[1 - i] < off[i])
    return found


def pairs(cell: Cell, sensor: SensorModel, seeds: Sequence[int]) -> Iterator[Pair]:
    """All differences of size, then all of colour, on the same seeds."""
    for mm, shift in [*((mm, 0) for mm in MM), *((0.0, shift) for shift in SHIFTS[1:])]:
        for seed in seeds:
            one, other = boxes(cell, seed, mm, shift)
            shares = product_model(one).label_shares, product_model(other).label_shares
            told = swapped(looked_at(cell, sensor, seed, (one, other)))
            overlap = float(np.sqrt(shares[0] * shares[1]).sum())
            yield Pair(mm, shift, overlap, len(told), sum(told))


def main() -> None:
    """Look, and print the shares."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seeds", type=int, default=8, help="how many pairs of each difference")
    parser.add_argument("--seed", type=int, default=5100, help="the first")
    parser.add_argument("--sensor", default="ensenso", help="a file under data/sensors")
    given = parser.parse_args()
    cell, sensor = load_cell("apc2016_delft"), read_sensor(sensor_file(given.sensor))
    found = list(pairs(cell, sensor, range(given.seed, given.seed + given.seeds)))
    for mm in MM:
        own = [each for each in found if each.mm == mm and each.shift == 0]
        print(f"{mm:4.0f} mm larger: {share(own)}")
    for low, high in ((0.2, 0.6), (0.6, 0.8), (0.8, 0.9), (0.9, 0.99), (0.99, 1.01)):
        own = [each for each in found if each.mm == 0.0 and low <= each.overlap < high]
        print(f"colours overlap {low:g} to {min(high, 1.0):g}: {share(own)}")


def share(own: Sequence[Pair]) -> str:
    """How many answers are swapped."""
    return f"{sum(each.swapped for each in own)} of {sum(each.answers for each in own)} answers swapped"


if __name__ == "__main__":
    main()
