"""Random orders stacked on pallets, with the whole order known and as cartons come, and what stands.

    python -m bench.palletizing [--orders 200] [--seed 0] [--cartons 20,60]

The score is that of BED-BPP: the share of the cartons of an order that are stacked, 0 if any moved by more
than 10 mm in height in the engine. Times are those of the processor.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np

from pickcli.palletizing.drop_test import drop_test
from pickcli.palletizing.pallet_order import PalletOrder
from pickcli.palletizing.pallet_stack import PalletStack
from pickcli.palletizing.random_pallet_order import random_pallet_order
from pickcli.palletizing.stacking import stack_all, stack_as_they_come

WAYS: dict[str, Callable[[PalletOrder], PalletStack]] = {
    "offline": stack_all,
    "online": stack_as_they_come,
    "online, 3 seen": partial(stack_as_they_come, look_ahead=3),
}


def figures(way: Callable[[PalletOrder], PalletStack], orders: list[PalletOrder]) -> str:
    """Score, fill, collapses and times of one way of stacking."""
    scores, fills, times, worst, n_collapsed = [], [], [], 0.0, 0
    for order in orders:
        began = process_time()
        stack = way(order)
        times.append(process_time() - began)
        tested = drop_test(order.pallet, stack.placements)
        n_collapsed += not tested.is_stable
        worst = max(worst, tested.sinking, tested.shift)
        scores.append(stack.share_placed if tested.is_stable else 0.0)
        fills.append(stack.fill)
    return (
        f"score {np.mean(scores):.3f}, fill {np.mean(fills):.2f}, {n_collapsed} of {len(orders)} collapse, "
        f"most moved {1e3 * worst:.1f} mm, s an order: median {np.median(times):.2f}, worst {max(times):.2f}"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--cartons", default="20,60", help="least and most in an order")
    given = parser.parse_args()
    least, most = map(int, given.cartons.split(","))
    numbers = np.random.default_rng(given.seed).integers(least, most + 1, given.orders).tolist()
    orders = [random_pallet_order(n, given.seed + k) for k, n in enumerate(numbers)]
    for name, way in WAYS.items():
        print(f"{name}: {figures(way, orders)}", flush=True)


if __name__ == "__main__":
    main()
