"""Drives into a pallet that the truck sees on the way: end poses in the true pallet, with all noise.

    python -m bench.pallet_entry [--areas 25] [--drives 4] [--seed 0] [--sensor carmine]

A hall of 9 x 7 m with four boxes of 0.4 to 1.2 m a side, a full or half EUR pallet with or without load, and
a start from which its entry side is 2.5 to 5 m away and less than 60 degrees aside. The true pallet is off
the expected pose anywhere within 0.1 m, 0.1 m and 0.1 rad. The truck knows its pose with the noise of apc
plan-drive --drives, its camera is where it should be, and it looks each half second. A drive counts if it
ends within 0.03 m and 1 degree of where it should be in the true pallet.
"""

from __future__ import annotations

import argparse
from time import process_time

import numpy as np

from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.driving.driving_area import DrivingArea, FloorBox, StatedPallet
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import entered_pose, plan_entry, straight_length
from pickcli.driving.simulated_entries import SimulatedEntry, simulate_entries
from pickcli.driving.steering_path import posed
from pickcli.driving.truck_camera import TruckCamera
from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.perception.pallets.pallet_shape import EUR_FULL, EUR_HALF
from pickcli.seeds import derived_rng

HALL = (9.0, 7.0)  # m
N_BOXES = 4
LEAST = 0.15  # m between the truck at its start or before the pallet and everything
TOLERANCE = np.array([0.1, 0.1, 0.1])  # m, m and rad
DISTANCE, BESIDE = (2.5, 5.0), np.radians(60.0)  # m and rad, of the start from the entry side


def random_area(seed: int, camera: TruckCamera) -> tuple[DrivingArea, StatedPallet]:
    """Draw a hall with a pallet that can be entered."""
    rng = derived_rng("pallet hall", seed)
    while True:
        shape = EUR_FULL if rng.random() < 0.5 else EUR_HALF
        at = np.array([rng.uniform(1.2, 3.0), rng.uniform(1.5, HALL[1] - 1.5), rng.uniform(-0.5, 0.5)])
        pallet = StatedPallet(shape, at, float(rng.choice([0.0, 0.6])), TOLERANCE)
        boxes = tuple(
            FloorBox(
                f"box {k + 1}", (rng.uniform(0.5, HALL[0] - 0.5), rng.uniform(0.5, HALL[1] - 0.5)),
                (rng.uniform(0.4, 1.2), rng.uniform(0.4, 1.2)), rng.uniform(-np.pi, np.pi),
            )
            for k in range(N_BOXES)
        )  # fmt: skip
        beside = rng.uniform(-BESIDE, BESIDE)
        entry = posed(at, np.array([shape.length / 2, 0.0, beside]))
        start = posed(entry, np.array([rng.uniform(*DISTANCE), 0.0, 0.0]))
        start[2] += rng.uniform(-0.3, 0.3)
        area = DrivingArea(
            (0.0, 0.0), HALL, boxes, start, np.zeros(3), camera=camera, pallet=pallet, enters=True
        )
        inside = entered_pose(area, pallet)
        way = posed(inside, np.outer(np.linspace(0.0, straight_length(area, pallet), 6), [1.0, 0.0, 0.0]))
        is_free = clearances(area, np.vstack([start, way])).min() >= LEAST
        from_pallet = np.array([box.distance(pallet.footprint.corners).min() for box in boxes]).min()
        if is_free and from_pallet > LEAST and pallet.footprint.distance(start[:2]) > 1.0:
            return area, pallet


def table(times: list[float], entries: list[SimulatedEntry], n_without: int) -> str:
    """The figures."""
    off = np.array([each.off for each in entries if not each.has_given_up]).reshape(-1, 3)
    rows = {
        "areas with a plan / without": f"{len(times) - n_without} / {n_without}",
        "planning, s: median / worst": f"{np.median(times):.2f} / {max(times):.2f}",
        "drives / in the true pallet within 0.03 m and 1 degree": (
            f"{len(entries)} / {sum(each.is_within for each in entries)}"
        ),
        "given up before it": str(sum(each.has_given_up for each in entries)),
        "end position, mm: median / p95 / worst": _three(1e3 * np.hypot(*off[:, :2].T), 1),
        "of that across, mm: median / p95 / worst": _three(1e3 * np.abs(off[:, 1]), 1),
        "end yaw, degrees: median / p95 / worst": _three(np.degrees(np.abs(off[:, 2])), 2),
        "pictures with the pallet / changes of the path / stops, per drive": " / ".join(
            f"{np.mean([getattr(each, name) for each in entries]):.1f}"
            for name in ("n_seen", "n_renewed", "n_stops")
        ),
        "drives without a stop": str(sum(not each.n_stops for each in entries)),
    }
    return "\n".join(f"| {what} | {figure} |" for what, figure in rows.items())


def _three(values: Array, digits: int) -> str:
    return " / ".join(f"{each:.{digits}f}" for each in np.percentile(values, (50, 95, 100)))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--areas", type=int, default=25)
    parser.add_argument("--drives", type=int, default=4, help="in each")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--sensor", default="carmine")
    given = parser.parse_args()
    camera = TruckCamera(read_sensor(sensor_file(given.sensor)))
    times: list[float] = []
    entries: list[SimulatedEntry] = []
    n_without = 0
    for k in range(given.areas):
        area, pallet = random_area(given.seed + k, camera)
        began = process_time()
        try:
            plan = plan_entry(area, pallet)
        except NoPlanError as error:
            n_without += 1
            print(f"seed {given.seed + k}: {error}", flush=True)
            continue
        finally:
            times.append(process_time() - began)
        for each in simulate_entries(area, plan, given.drives, given.seed + k):
            entries.append(each)
            if not each.is_within:
                off = each.off * [1e3, 1e3, np.degrees(1.0)]
                print(f"seed {given.seed + k}: {off.round(2)}, {each}", flush=True)
    print(table(times, entries, n_without))


if __name__ == "__main__":
    main()
