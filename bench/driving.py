"""Drives of a truck in random areas: planning times, end poses with noise, distances, limits.

    python -m bench.driving [--drives 1000] [--seed 0] [--plans 50]

An area is a hall of 10 x 10 m with eight boxes of 0.4 to 1.5 m a side, start and goal anywhere at least
0.15 m from everything; every other drive ends with 0.6 m straight backwards. Times are those of the
processor, of planning in one process, the lattice of each area included. Distances between plans and
everything are sampled anew, more finely than a plan's.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass, field
from time import process_time

import numpy as np

from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.simulated_drives import SimulatedDrives, simulate_drives
from pickcli.driving.steering_path import posed
from pickcli.errors import NoPlanError
from pickcli.seeds import derived_rng

SIDE = 10.0  # m of the hall
N_BOXES = 8
LEAST = 0.15  # m between everything and the truck at start and goal
STRAIGHT = -0.6  # m
FINE_STEP = 0.002  # m of travel between samples


def random_area(seed: int, straight: float = 0.0) -> DrivingArea:
    """Draw an area in which the start, the goal and where its straight part begins are free."""
    rng = derived_rng("driving area", seed)
    while True:
        boxes = tuple(
            FloorBox(
                f"box {k + 1}", (rng.uniform(0.5, SIDE - 0.5), rng.uniform(0.5, SIDE - 0.5)),
                (rng.uniform(0.4, 1.5), rng.uniform(0.4, 1.5)), rng.uniform(-np.pi, np.pi),
            )
            for k in range(N_BOXES)
        )  # fmt: skip
        start, goal = (
            np.array([*rng.uniform(1.0, SIDE - 1.0, 2), rng.uniform(-np.pi, np.pi)]) for _ in range(2)
        )
        area = DrivingArea((0.0, 0.0), (SIDE, SIDE), boxes, start, goal, straight)
        before = posed(goal, np.outer(np.linspace(0.0, -straight, 5), [1.0, 0.0, 0.0]))
        if clearances(area, np.vstack([start, before])).min() >= LEAST:
            return area


@dataclass
class Figures:
    """What came of plans and drives."""

    times: list[float] = field(default_factory=list)  # s
    plans: list[DrivePlan] = field(default_factory=list)
    drives: list[SimulatedDrives] = field(default_factory=list)
    least_sampled: float = np.inf  # m beyond the margin, of plans
    n_without: int = 0

    def add(self, area: DrivingArea, n_drives: int, seed: int) -> None:
        """Plan in an area, and drive the plan."""
        began = process_time()
        try:
            plan = plan_drive(area)
        except NoPlanError as error:
            self.n_without += 1
            print(f"seed {seed}: {error}", flush=True)
            return
        finally:
            self.times.append(process_time() - began)
        n = int(plan.path.length / FINE_STEP)
        poses = plan.path.poses_at(np.linspace(0.0, plan.path.length, n))
        self.least_sampled = min(self.least_sampled, float(clearances(area, poses).min()) - area.margin)
        self.plans.append(plan)
        self.drives.append(simulate_drives(plan, n_drives, seed))

    def __str__(self) -> str:
        """A table."""
        joined = {name: np.concatenate([getattr(d, name) for d in self.drives]) for name in (
            "position_errors", "yaw_errors", "are_within", "clearances", "speeds", "accelerations",
            "steering", "steering_rates", "centripetal",
        )}  # fmt: skip
        position, yaw = 1e3 * joined["position_errors"], np.degrees(joined["yaw_errors"])
        shorter = [
            1 - p.profile.travel[-1] / (p.lattice.path.length + abs(p.area.straight)) for p in self.plans
        ]
        rows = {
            "plans / without": f"{len(self.plans)} / {self.n_without}",
            "planning, s: median / p99 / worst": "{:.2f} / {:.2f} / {:.2f}".format(
                *np.percentile(self.times, (50, 99, 100))
            ),
            "shorter than the lattice path, mean": f"{100 * np.mean(shorter):.1f} %",
            "plans, sampled: least distance beyond the margin": f"{1e3 * self.least_sampled:.2f} mm",
            "drives / within 0.03 m and 1 degree": f"{len(position)} / {joined['are_within'].sum()}",
            "end position, mm: median / p99 / worst": "{:.1f} / {:.1f} / {:.1f}".format(
                *np.percentile(position, (50, 99, 100))
            ),
            "end yaw, degrees: median / p99 / worst": "{:.2f} / {:.2f} / {:.2f}".format(
                *np.percentile(yaw, (50, 99, 100))
            ),
            "least distance of a drive from anything": f"{1e3 * joined['clearances'].min():.0f} mm",
            "largest speed, acceleration, centripetal": " / ".join(
                f"{joined[name].max():.3f}" for name in ("speeds", "accelerations", "centripetal")
            ),
            "largest steering angle / rate": " / ".join(
                f"{joined[name].max():.3f}" for name in ("steering", "steering_rates")
            ),
        }
        return "\n".join(f"| {what} | {figure} |" for what, figure in rows.items())


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=1000, help="in all")
    parser.add_argument("--seed", type=int, default=0, help="of the first area")
    parser.add_argument("--plans", type=int, default=50, help="areas with a plan")
    given = parser.parse_args()
    found = Figures()
    while (n := len(found.plans)) < given.plans:
        k = n + found.n_without
        n_drives = given.drives // given.plans + (n < given.drives % given.plans)
        found.add(random_area(given.seed + k, STRAIGHT * (k % 2)), n_drives, given.seed + k)
    print(found)


if __name__ == "__main__":
    main()
