"""Random orders stacked by the arm of pallet_sia20, played to their end: what is put up, and how fast.

    python -m bench.arm_pallets [--orders 20] [--seed 0] [--cartons 5,10] [--heaviest 10] [--noise 1,0.2]

The score is that of BED-BPP: the share of an order's cartons that are put up, 0 if any moved by more than
10 mm in height afterwards. The pace is that of all orders together, 0.3 s for each query included. Every
order is another, drawn from the next seed.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.commands.options.trial_options import parse_noise
from pickcli.pallet_trials.pallet_result import CartonOutcome, PalletTrialResult
from pickcli.pallet_trials.pallet_station import PalletStation, side_of_arm
from pickcli.pallet_trials.pallet_trial import PalletTrialRequest, PlayedPallet, play_pallet
from pickcli.palletizing.arm_sequence import seen_from
from pickcli.palletizing.drop_test import what_stands
from pickcli.palletizing.pallet_order import CONTAINERS, PalletOrder
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.palletizing.random_pallet_order import CartonBounds, random_pallet_order
from pickcli.palletizing.stack_verification import verify_stack
from pickcli.palletizing.stacking import stack_all
from pickcli.planning.planning_context import PlanningContext

CELL, CLEARANCE, EDGE, FALL, HEIGHT, LONGEST = "pallet_sia20", 0.015, 0.01, 0.006, 0.694, 0.45


@dataclass
class Figures:
    """Figures of all orders so far."""

    results: list[PalletTrialResult] = field(default_factory=list)
    seconds: Counter[str] = field(default_factory=Counter)  # s of plans by kind of segment
    n_plans: int = 0
    least_clearance: float = np.inf  # m, outside of planned contacts

    def add(self, played: PlayedPallet) -> None:
        """Count an order."""
        self.results.append(played.result)
        for each in played.plans:
            self.n_plans += 1
            for segment in each.plan.segments:
                self.seconds[str(segment.kind)] += segment.t_end - segment.t_start  # type: ignore[assignment]
            if each.plan.certificate is not None:
                self.least_clearance = min(self.least_clearance, each.plan.certificate.min_clearance)

    def lines(self) -> list[str]:
        """All figures as text."""
        cartons = [each for result in self.results for each in result.cartons]
        placed = [each for each in cartons if each.outcome is CartonOutcome.PLACED]
        lost = sum(each.outcome is CartonOutcome.LOST for each in cartons)
        total = sum(result.t_end for result in self.results)
        down = [each.set_down for each in placed if each.set_down is not None]
        ms = {
            "planning": [t for each in cartons for t in each.planning_ms],
            "verifying": [t for each in cartons for t in each.verifying_ms],
        }
        ordered = sum(result.n_ordered for result in self.results)
        return [
            f"{len(self.results)} orders, {ordered} cartons, {len(cartons)} with a place in the stack, "
            f"{len(placed)} put up, {lost} lost; score {np.mean([r.score for r in self.results]):.3f}, "
            f"{sum(result.has_collapsed for result in self.results)} collapsed",
            f"{3600 * len(placed) / total:.0f} boxes an hour, slowest order "
            f"{min(result.boxes_an_hour for result in self.results):.0f}",
            ", ".join(
                f"{what} {sum(getattr(r, f'n_{what}') for r in self.results)}"
                for what in ("collisions", "limit_violations", "stops")
            )
            + f", least proven clearance {1e3 * self.least_clearance:.1f} mm",
            f"set down beside the planned place, mm: {_spread([1e3 * each.aside for each in down])}; turned, "
            f"degrees: {_spread([np.degrees(each.turn) for each in down])}",
            f"sinking until the end, mm: {_spread([1e3 * each.sinking for each in placed])}",
            *(f"{what}, ms a query: {_spread(values)}" for what, values in ms.items()),
            "s a carton: "
            + ", ".join(f"{kind} {s / self.n_plans:.2f}" for kind, s in self.seconds.most_common())
            + f", in all {total / max(len(placed), 1):.2f}",
        ]


def _spread(values: list[float]) -> str:
    if not values:
        return "none"
    median, p95 = np.percentile(values, [50, 95])
    return f"median {median:.2f}, 95 % {p95:.2f}, worst {max(values):.2f}"


def stack_of(order: PalletOrder, side: str, seed: int) -> StackedPallet:
    """The verified stack of an order, in the sequence of the arm."""
    stack = StackedPallet.of(*what_stands(seen_from(stack_all(order, seed), side)))
    assert not verify_stack(stack).reasons
    return stack


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--orders", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--cartons", default="5,10", help="least and most in an order")
    parser.add_argument("--heaviest", type=float, default=10.0, help="kg")
    parser.add_argument("--noise", default="1,0.2", help="mm and degrees")
    given = parser.parse_args()
    least, most = map(int, given.cartons.split(","))
    cell, noise = load_workcell(CELL).preferred, parse_noise(None, None, given.noise)
    pallet = replace(CONTAINERS["half_pallet"], height=HEIGHT, edge=EDGE)
    sizes, figures = CartonBounds(longest=LONGEST, heaviest=given.heaviest), Figures()
    for seed in range(given.seed, given.seed + given.orders):
        n = int(np.random.default_rng(seed).integers(least, most + 1))
        order = replace(random_pallet_order(n, seed, pallet, sizes, CLEARANCE), fall=FALL)
        stack = stack_of(order, side_of_arm(cell), seed)
        station = PalletStation.of(cell, stack)
        played = play_pallet(
            PalletTrialRequest(stack, noise, seed=seed), station, PlanningContext(station.cell)
        )
        figures.add(played)
        result = played.result
        print(f"seed {seed}: {result.n_placed} of {n}, {result.boxes_an_hour:.0f} an hour", flush=True)
        for each in result.cartons:
            if each.reason:
                print(f"  {each.carton}: {each.outcome}: {each.reason}", flush=True)
    print("\n".join(figures.lines()))


if __name__ == "__main__":
    main()
