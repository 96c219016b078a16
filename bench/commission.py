"""Commissions of apple_booth, played to their end: how often the whole chain succeeds, and how fast.

    python -m bench.commission [--runs 10] [--seed 0] [--task apple_commission] [--cell apple_booth]
        [--keep FOLDER]

Every run has another seed: of the errors of localisation and drives, of where the pallet truly stands within
its tolerance, of pictures, perceived poses and the deviations of the simulated world. A run succeeds if every
item stands in its place on the pallet after the last drive, the pallet stands where it was to be delivered,
nothing collided and no limit was broken, and the truck is out of it. With --keep the records of finished runs
are kept in a folder, and are not played again: delete them after a change of the program.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.commission.commission_file import read_commission
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_statistics import CommissionStatistics
from pickcli.commission.commission_trial import CommissionRequest, play_commission
from pickcli.files.atomic_write import write_text
from pickcli.planning.planning_context import PlanningContext

Record = Mapping[str, Any]


def _line(seed: int, record: Record) -> str:
    off = record["pallet_off"]
    delivered = "not delivered" if off is None else f"delivered {1e3 * off['distance']:.0f} mm off"
    counts = {key.replace("_", " "): record[key] for key in ("collisions", "limit_violations", "stops")}
    failed = [f"{s['action']} {s['target']}: {s['reason']}" for s in record["steps"] if not s["is_success"]]
    return (
        f"seed {seed}: {'success' if record['success'] else 'no success'}, {record['items_placed']} of "
        f"{record['items_ordered']} items, {delivered}, {record['duration_s']:.1f} s, at load "
        f"{record['handling_s']:.1f} s"
        + "".join(f", {what} {n}" for what, n in counts.items() if n)
        + ("; " + "; ".join(failed) if failed else "")
    )


def _summary(records: Mapping[str, Record]) -> list[str]:
    found = CommissionStatistics(records)
    low, high = found.success.interval
    aside = [1e3 * each["at_end"]["aside"] for each in found.items if each["outcome"] == "placed"]
    off = [r["pallet_off"] for r in records.values() if r["pallet_off"] is not None]
    outcomes = Counter(str(each["outcome"]) for each in found.items)
    clearance = [
        1e3 * s["figures"]["clearance_m"]
        for r in records.values() for s in r["steps"] if "clearance_m" in s["figures"]
    ]  # fmt: skip
    return [
        f"{found.success.successes} of {found.success.tries} runs succeeded (95 %: {100 * low:.0f} to "
        f"{100 * high:.0f} %); items: " + ", ".join(f"{n} {what}" for what, n in outcomes.most_common()),
        f"s a run: {_spread(found.durations)}; at the load: {_spread(found.handling)}",
        f"collisions {found.total('collisions')}, limit violations {found.total('limit_violations')}, stops "
        f"{found.total('stops')}; least distance of a drive from walls and boxes, mm: "
        f"{min(clearance, default=np.nan):.0f}",
        f"items off their places at the end, mm: {_spread(aside)}",
        f"pallet off where it was to be delivered, mm: {_spread(1e3 * each['distance'] for each in off)}; "
        f"degrees: {_spread(float(np.degrees(each['turn'])) for each in off)}",
        *(f"failed {n} times: {why}" for n, why in found.failed_steps),
    ]


def _spread(values: Iterable[float]) -> str:
    found = list(values)
    if not found:
        return "none"
    median, p95 = np.percentile(found, [50, 95])
    return f"median {median:.1f}, 95 % {p95:.1f}, worst {max(found):.1f}"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0, help="of the first run")
    parser.add_argument("--task", default="apple_commission", help="a name under data/tasks")
    parser.add_argument("--cell", default="apple_booth", help="a name under data/cells")
    parser.add_argument("--keep", type=Path, help="folder in which records of finished runs are kept")
    given = parser.parse_args()
    commission = read_commission(data_path() / "tasks" / f"{given.task}.json")
    station = CommissionStation.of(load_workcell(given.cell).preferred, commission)
    context, records = PlanningContext(station.cell), {}
    for seed in range(given.seed, given.seed + given.runs):
        kept = None if given.keep is None else given.keep / f"{given.task}-{seed}.json"
        if kept is None or not kept.exists():
            record = play_commission(CommissionRequest(seed=seed), station, context).result.record()
            if kept is not None:
                kept.parent.mkdir(parents=True, exist_ok=True)
                write_text(kept, json.dumps(record))
        else:
            record = json.loads(kept.read_text())
        records[str(seed)] = record
        print(_line(seed, record), flush=True)
    print("\n".join(_summary(records)))


if __name__ == "__main__":
    main()
