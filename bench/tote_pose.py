"""How well the tote is located by touching it, at random poses of its tolerance.

    python -m bench.tote_pose [--shifts 12] [--seed 0] [--touches 8] [--tilt] [--draws 20000]

In each run the tote of Delft's cell is displaced by up to 30 mm and 3 degrees on its table and by up to 1.5
mm in height, the bellows are up to 10 % stiffer or softer than stated, joints are read with errors of up to
0.1 mrad and 0.1 mm, motor torques with noise of 2 %, and a contact is known 8 ms after the filter of the
torques. Everything is played: moves, guarded moves and contacts. Bounds are kept if all that is estimated is
within its own. A few runs cannot tell how often that is: ``--draws`` draws sets of touches from the errors of
all that were made, walls and rims each among themselves, fits them, and says in how many all bounds are kept.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time

import numpy as np

from pickcli.calibration.tote_fit import TouchedPoint, fit_tote
from pickcli.calibration.tote_location import (
    LocatedTote,
    LocatingSettings,
    locate_in_simulation,
    tote_offset,
    tote_pose_in_simulation,
)
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, inverse, pose
from pickcli.planning.planning_context import PlanningContext

HEIGHT = 1.5e-3  # m, either way, of the true tote


@dataclass(frozen=True, eq=False)
class Run:
    """One tote that was located."""

    located: LocatedTote
    T_true: Array

    @property
    def offsets(self) -> Array:
        """(k,) what the estimate is off, m and rad."""
        estimate = self.located.estimate
        return np.array([*tote_offset(estimate.T_world_tote, self.T_true, estimate.names).values()])

    @property
    def is_kept(self) -> bool:
        """Whether all bounds hold."""
        return bool((np.abs(self.offsets) <= self.located.estimate.bounds).all())

    @property
    def errors(self) -> Array:
        """(N,) m by which each touched point is outside of the true face."""
        return np.array([outside(each.touched, self.T_true) for each in self.located.touches])


def outside(touched: TouchedPoint, T_world_tote: Array) -> float:
    """How far a touched point is outside of its face, m."""
    point = (inverse(T_world_tote) @ [*touched.point, 1.0])[:3]
    return float(touched.aim.face.normal @ (point - touched.aim.point))


def play(n: int, seed: int, settings: LocatingSettings) -> list[Run]:
    """Locate the tote at random poses."""
    cell = load_cell("apc2016_delft")
    context, runs = PlanningContext(cell), []
    for k in range(seed, seed + n):
        began = process_time()
        height = float(np.random.default_rng([k, 1]).uniform(-HEIGHT, HEIGHT))
        T_true = tote_pose_in_simulation(cell, "random", k) @ pose((0.0, 0.0, height))
        try:
            run = Run(locate_in_simulation(context, T_true, settings, k), T_true)
        except (InputError, NoPlanError) as fault:
            print(f"seed {k}: {fault}", flush=True)
            continue
        runs.append(run)
        x, y, z, yaw, *_ = run.offsets
        forces = [each.record.most_force for each in run.located.touches]
        print(
            f"seed {k}: {1e3 * np.hypot(x, y):.3f} mm, {1e3 * z:+.3f} mm in z, {np.degrees(yaw):+.4f} deg; "
            f"bounds {'kept' if run.is_kept else 'BROKEN'}; {max(forces):.1f} N; "
            f"{len(run.located.collisions)} unplanned contacts; {run.located.duration:.1f} s simulated, "
            f"{process_time() - began:.0f} s of processor", flush=True,
        )  # fmt: skip
    return runs


def kept_share(runs: list[Run], draws: int, seed: int) -> float:
    """Share of drawn sets of touches whose fit keeps all its bounds."""
    rng, names = np.random.default_rng(seed), runs[0].located.estimate.names
    errors: dict[str, list[float]] = {"wall": [], "rim": []}
    for run in runs:
        for each, error in zip(run.located.touches, run.errors, strict=True):
            errors[each.touched.aim.face.name.split()[0]].append(error)
    kept = 0
    for _ in range(draws):
        run = runs[rng.integers(len(runs))]
        moved = []
        for point in (touch.touched for touch in run.located.touches):
            off = float(rng.choice(errors[point.aim.face.name.split()[0]]))
            T = run.T_true
            shift = (off - outside(point, T)) * (T[:3, :3] @ point.aim.face.normal)
            moved.append(replace(point, point=point.point + shift))
        fit = fit_tote(moved, run.T_true, names)
        offsets = np.array([*tote_offset(fit.T_world_tote, run.T_true, names).values()])
        kept += bool((np.abs(offsets) <= fit.bounds).all())
    return kept / draws


def figures(runs: list[Run]) -> dict[str, float]:
    """Errors and bounds (mm and degrees), forces (N) and times (s)."""
    offsets = np.array([run.offsets for run in runs])
    bounds = np.array([run.located.estimate.bounds for run in runs])
    of = {
        "position_mm": 1e3 * np.hypot(offsets[:, 0], offsets[:, 1]),
        "z_mm": 1e3 * np.abs(offsets[:, 2]),
        "yaw_deg": np.degrees(np.abs(offsets[:, 3])),
        "touch_mm": 1e3 * np.abs(np.concatenate([run.errors for run in runs])),
        "force_N": np.array([touch.record.most_force for run in runs for touch in run.located.touches]),
        "overshoot_mm": 1e3 * np.array([t.record.overshoot for run in runs for t in run.located.touches]),
        "simulated_s": np.array([run.located.duration for run in runs]),
    }
    found = {
        f"{name}_{what}": float(np.percentile(values, share))
        for name, values in of.items()
        for what, share in (("median", 50), ("p95", 95), ("most", 100))
    }
    for i, name in enumerate(runs[0].located.estimate.names):
        scale = 1e3 if name in ("x", "y", "z") else float(np.degrees(1.0))
        found[f"bound_{name}_median"] = scale * float(np.median(bounds[:, i]))
    found["bounds_kept"] = float(np.mean([run.is_kept for run in runs]))
    found["unplanned_contacts"] = float(sum(len(run.located.collisions) for run in runs))
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--shifts", type=int, default=12)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--touches", type=int, default=8)
    parser.add_argument("--tilt", action="store_true")
    parser.add_argument("--draws", type=int, default=20_000)
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    runs = play(given.shifts, given.seed, LocatingSettings(given.touches, given.tilt))
    values = {**figures(runs), "located": len(runs), "refused": given.shifts - len(runs)}
    values["bounds_kept_drawn"] = kept_share(runs, given.draws, given.seed)
    for key, value in values.items():
        print(f"{key:>24} {value:.4f}")
    if given.json is not None:
        given.json.write_text(json.dumps(values, indent=2) + "\n")


if __name__ == "__main__":
    main()
