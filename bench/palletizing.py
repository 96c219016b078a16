"""Random orders stacked on pallets, with the whole order known and as cartons come, and what stands.

    python -m bench.palletizing [--orders 200] [--seed 0] [--cartons 50,50] [--ways offline,online]

The score is that of BED-BPP: the share of the cartons of an order that are stacked, 0 if any moved by more
than 10 mm in height in the engine. Every stack is verified. Times are those of the processor. For scale, a
height map (cells of 10 mm, the lowest place with 3/4 of the base and three corners borne) says how many
cartons of the same orders it finds a place for, from the largest base to the smallest, and as they come.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from pickcli.geometry import Array
from pickcli.palletizing.drop_test import DropTest, drop_test
from pickcli.palletizing.pallet_order import Carton, PalletOrder
from pickcli.palletizing.pallet_stack import PalletStack
from pickcli.palletizing.pallet_stack_file import read_pallet_stack, write_pallet_stack
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stack_verification import verify_stack
from pickcli.palletizing.stacking import stack_all, stack_as_they_come

EVERY = 20  # orders after which the figures so far are told
CELL = 0.01  # m, of a height map
WAYS: dict[str, Callable[[PalletOrder], PalletStack]] = {
    "offline": stack_all,
    "online": stack_as_they_come,
    "online-3": partial(stack_as_they_come, look_ahead=3),
}


@dataclass
class Figures:
    """Score, fill, collapses, refusals by the verifier, and times of one way of stacking."""

    way: Callable[[PalletOrder], PalletStack]
    scores: list[float] = field(default_factory=list)
    fills: list[float] = field(default_factory=list)
    times: list[float] = field(default_factory=list)  # s
    worst: float = 0.0  # m that a carton moved
    n_collapsed: int = 0
    n_refused: int = 0

    def add(self, order: PalletOrder) -> None:
        """Stack an order, put it up in the engine, and have it verified."""
        began = process_time()
        stack = self.way(order)
        self.times.append(process_time() - began)
        tested = drop_test(order.pallet, stack.placements)
        self.n_collapsed += not tested.is_stable
        self.n_refused += is_refused(stack, tested)
        self.worst = max(self.worst, tested.sinking, tested.shift)
        self.scores.append(stack.share_placed if tested.is_stable else 0.0)
        self.fills.append(stack.fill)

    def __str__(self) -> str:
        """All of them, in a line."""
        return (
            f"score {np.mean(self.scores):.3f}, fill {np.mean(self.fills):.2f}, {self.n_collapsed} of "
            f"{len(self.scores)} collapse, {self.n_refused} refused, most moved {1e3 * self.worst:.1f} mm, "
            f"s an order: median {np.median(self.times):.2f}, worst {max(self.times):.2f}"
        )


def is_refused(stack: PalletStack, tested: DropTest) -> bool:
    """Whether the verifier refuses a stack, from its file."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "stack.json"
        write_pallet_stack(path, stack, tested)
        return bool(verify_stack(read_pallet_stack(path), stack.order).reasons)


def share_by_height_map(order: PalletOrder, cartons: Sequence[Carton]) -> float:
    """Share of the cartons for which a height map finds a place, in a sequence."""
    pallet = order.pallet
    heights, n = np.zeros([round(side / CELL) for side in pallet.size]), 0
    for carton in cartons:
        length, width, height = carton.size
        places = [
            found
            for across in {(length, width), (width, length)}
            if (found := lowest_place(heights, across, pallet.height - pallet.deck - height))
        ]
        if places:
            z, base = min(places, key=lambda place: (place[0], place[1][0].start, place[1][1].start))
            heights[base] = z + height
            n += 1
    return n / len(cartons)


def lowest_place(
    heights: Array, across: tuple[float, float], most: float
) -> tuple[float, tuple[slice, slice]] | None:
    """Height (m, at most a given one) and cells of the lowest place of a base, None if there is none."""
    i, j = (round(side / CELL) for side in across)
    if i > heights.shape[0] or j > heights.shape[1]:
        return None
    windows = np.lib.stride_tricks.sliding_window_view
    z = windows(windows(heights, i, 0).max(axis=-1), j, 1).max(axis=-1)
    stands, (n_x, n_y) = z <= most + 1e-9, z.shape
    for height in np.unique(z[stands]).tolist():
        bears = (heights >= height - CELL / 2).astype(int)
        counts = np.pad(bears.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
        borne = counts[i:, j:] - counts[:-i, j:] - counts[i:, :-j] + counts[:-i, :-j]
        corners = sum(bears[x : x + n_x, y : y + n_y] for x in (0, i - 1) for y in (0, j - 1))
        stands &= (z != height) | ((borne >= 0.75 * i * j) & (corners >= 3))
    if not stands.any():
        return None
    x, y = np.unravel_index(np.where(stands, z, np.inf).argmin(), z.shape)
    return float(z[x, y]), (slice(int(x), int(x) + i), slice(int(y), int(y) + j))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--cartons", default="50,50", help="least and most in an order")
    parser.add_argument("--ways", default=",".join(WAYS), help=f"of {', '.join(WAYS)} and height-map")
    given = parser.parse_args()
    least, most = map(int, given.cartons.split(","))
    numbers = np.random.default_rng(given.seed).integers(least, most + 1, given.orders).tolist()
    orders = [random_pallet_order(n, given.seed + k) for k, n in enumerate(numbers)]
    names = given.ways.split(",")
    if "height-map" in names:
        names.remove("height-map")
        by_area = [sorted(o.cartons, key=lambda c: -c.size[0] * c.size[1]) for o in orders]
        offline = np.mean(list(map(share_by_height_map, orders, by_area)))
        online = np.mean([share_by_height_map(order, order.cartons) for order in orders])
        print(f"height map: placed {offline:.3f} from large to small, {online:.3f} as they come", flush=True)
    ways = {name: Figures(WAYS[name]) for name in names}
    for k, order in enumerate(orders):
        for name, found in ways.items():
            found.add(order)
            if (k + 1) % EVERY == 0 or k + 1 == len(orders):
                print(f"{name}: {found}", flush=True)


if __name__ == "__main__":
    main()
