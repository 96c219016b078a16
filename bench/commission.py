"""Commissions of apple_booth, played to their end: how often the whole chain succeeds, and how fast.

    python -m bench.commission [--runs 10] [--seed 0] [--task apple_commission] [--cell apple_booth]

Every run has another seed: of the errors of localisation and drives, of where the pallet truly stands within
its tolerance, of pictures, perceived poses and the deviations of the simulated world. A run succeeds if every
item stands in its place on the pallet after the last drive, the pallet stands where it was to be delivered,
nothing collided and no limit was broken, and the truck is out of it.
"""

from __future__ import annotations

import argparse
from collections import Counter

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.commission.commission_file import read_commission
from pickcli.commission.commission_result import CommissionResult
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import CommissionRequest, play_commission
from pickcli.planning.planning_context import PlanningContext


def _line(seed: int, result: CommissionResult) -> str:
    off = result.delivered
    delivered = "not delivered" if off is None else f"delivered {1e3 * off.distance:.0f} mm off"
    counts = {
        "collisions": result.n_collisions,
        "limit violations": result.n_limit_violations,
        "stops": result.n_stops,
    }
    failed = [f"{each.action} {each.target}: {each.reason}" for each in result.steps if not each.is_success]
    return (
        f"seed {seed}: {'success' if result.is_success else 'no success'}, {result.n_placed} of "
        f"{len(result.items)} items, {delivered}, {result.duration:.1f} s, at load {result.handling:.1f} s"
        + "".join(f", {what} {n}" for what, n in counts.items() if n)
        + ("; " + "; ".join(failed) if failed else "")
    )


def _summary(results: list[CommissionResult]) -> list[str]:
    items = [item for result in results for item in result.items]
    times, handling = ([getattr(r, name) for r in results] for name in ("duration", "handling"))
    aside = [1e3 * each.at_end.aside for each in items if each.at_end is not None]
    off = [r.delivered for r in results if r.delivered is not None]
    outcomes = Counter(str(each.outcome) for each in items)
    return [
        f"{sum(r.is_success for r in results)} of {len(results)} runs succeeded; items: "
        + ", ".join(f"{n} {what}" for what, n in outcomes.most_common()),
        f"s a run: {_spread(times)}; at the load: {_spread(handling)}",
        f"collisions {sum(r.n_collisions for r in results)}, limit violations "
        f"{sum(r.n_limit_violations for r in results)}, stops {sum(r.n_stops for r in results)}",
        f"items off their places at the end, mm: {_spread(aside)}",
        f"pallet off where it was to be delivered, mm: {_spread([1e3 * each.distance for each in off])}; "
        f"degrees: {_spread([float(np.degrees(each.turn)) for each in off])}",
    ]


def _spread(values: list[float]) -> str:
    if not values:
        return "none"
    median, p95 = np.percentile(values, [50, 95])
    return f"median {median:.1f}, 95 % {p95:.1f}, worst {max(values):.1f}"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--task", default="apple_commission", help="a name under data/tasks")
    parser.add_argument("--cell", default="apple_booth", help="a name under data/cells")
    given = parser.parse_args()
    commission = read_commission(data_path() / "tasks" / f"{given.task}.json")
    station = CommissionStation.of(load_workcell(given.cell).preferred, commission)
    context, results = PlanningContext(station.cell), []
    for seed in range(given.seed, given.seed + given.runs):
        results.append(play_commission(CommissionRequest(seed=seed), station, context).result)
        print(_line(seed, results[-1]), flush=True)
    print("\n".join(_summary(results)))


if __name__ == "__main__":
    main()
