"""People in vests seen from a truck, and brakes: shares found, false tracks, delays, contacts.

    python -m bench.vests [--pictures 300] [--drives 10] [--crossings 40] [--seed 0]

Pictures are single sets of four: four people anywhere within 1 to 20 m and the field of view, four
reflectors, four boxes, sun; a vest counts where both cameras see at least 0.75 of its body. Drives are 12 m
through a hall of 16 x 8 m with three boxes, past three people who cross the path where the truck is by plan,
blind to it, at 0.3 to 2 m/s, or stand; the vest cameras alone brake. Crossings are such drives with the
scanner alone: with the field of the watch, and with one for people who stand, without any approach.
"""

from __future__ import annotations

import argparse
from collections import Counter
from dataclasses import dataclass, field, replace
from functools import cache
from time import process_time

import numpy as np

from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.steering_path import seen_from
from pickcli.geometry import Array
from pickcli.seeds import derived_rng
from pickcli.watching.drawn_scene import draw_watched_scene
from pickcli.watching.drive_watch import Guards
from pickcli.watching.flash_pictures import FlashRenderer
from pickcli.watching.vest_detection import find_vests
from pickcli.watching.watch_file import Watch, read_watch, watch_file
from pickcli.watching.watch_truth import IN_VIEW, NEAR
from pickcli.watching.watched_drive import WatchedDrive
from pickcli.watching.watched_scene import Reflector, ReflectorKind, SunPatch, Walker, WatchedScene
from pickcli.watching.zone_watch import watch_zone

POSE = np.array([1.5, 0.0, 0.0])  # of the truck in pictures
N_PEOPLE, N_REFLECTORS, N_BOXES = 4, 4, 4
SPLIT = 10.0  # m from the cameras, between near and far
SCENES_OF_A_HALL = 4


def picture_scene(seed: int) -> WatchedScene:
    """Draw people, reflectors and boxes anywhere before the cameras."""
    rng = derived_rng("vest pictures", seed)

    def place(least: float) -> tuple[float, float]:
        far, angle = rng.uniform(least, 20.0), rng.uniform(-0.85, 0.85)
        return float(2.7 + far * np.cos(angle)), float(far * np.sin(angle))

    walkers = []
    for k in range(N_PEOPLE):
        x, y = place(1.2)
        angle = rng.uniform(-np.pi, np.pi)
        route = ((x, y), (float(x + 2 * np.cos(angle)), float(y + 2 * np.sin(angle))))
        walkers.append(Walker(f"person {k + 1}", route, rng.uniform(0.0, 2.0), 0.0, rng.uniform(1.6, 1.95)))
    reflectors = []
    for _ in range(N_REFLECTORS):
        (x, y), kind = place(3.0), ReflectorKind(rng.choice([str(each) for each in ReflectorKind]))
        yaw = float(np.arctan2(-y, 2.7 - x) + rng.uniform(-0.6, 0.6))
        size = {
            ReflectorKind.SIGN: tuple(rng.uniform(0.1, 0.6, 2).tolist()),
            ReflectorKind.TAPE: (rng.uniform(0.2, 2.0), 0.05),
            ReflectorKind.POST: (0.1, 1.2),
        }[kind]
        z = 0.6 if kind is ReflectorKind.POST else rng.uniform(0.35, 1.9)
        reflectors.append(Reflector(kind, (x, y, z), (size[0], size[1]), yaw))
    boxes = tuple(
        FloorBox(f"box {k}", place(2.5), (rng.uniform(0.4, 2.0), rng.uniform(0.4, 2.0)), rng.uniform(0, 3))
        for k in range(N_BOXES)
    )
    area = DrivingArea((-2.0, -25.0), (30.0, 25.0), boxes, POSE, POSE)
    (x, y), heights = place(2.0), tuple(rng.uniform(0.4, 2.2, N_BOXES).tolist())
    sun = (SunPatch((x, y), (3.0, 2.0), rng.uniform(0.0, 3.0), 15.0),)
    return WatchedScene(area, heights, tuple(walkers), tuple(reflectors), sun)


@dataclass
class PictureFigures:
    """What came of pictures."""

    in_view: Counter[str] = field(default_factory=Counter)
    found: Counter[str] = field(default_factory=Counter)
    n_false: int = 0
    distances: list[float] = field(default_factory=list)  # squared statistical ones of those found
    times: list[float] = field(default_factory=list)  # s

    def add(self, seed: int, watch: Watch) -> None:
        """Take one set of pictures in a scene, while the truck drives on and turns."""
        scene, rng = picture_scene(seed), derived_rng("vest noise", seed)
        renderer = FlashRenderer(watch.pair, scene, seed)

        def pose_at(at: float) -> Array:
            return POSE + (at - 1.0) * np.array([1.0, 0.0, 0.3])

        pictures = renderer.pictures(1.0, pose_at, rng)
        began = process_time()
        vests = find_vests(watch.pair, pictures)
        self.times.append(process_time() - began)
        shares = renderer.visible_shares(1.0, POSE)
        used: set[int] = set()
        for walker, share in zip(scene.walkers, shares.tolist(), strict=True):
            at = seen_from(POSE, np.array([*walker.place(1.0), 0.0]))[:2]
            off = [vest.place[:2] - at for vest in vests]
            near = [
                j for j, each in enumerate(off)
                if np.hypot(*each) < NEAR + 3 * np.sqrt(vests[j].covariance.trace() / 2)
            ]  # fmt: skip
            used |= set(near)
            if share < IN_VIEW:
                continue
            band = "near" if np.hypot(*(at - [watch.pair.forward, 0.0])) < SPLIT else "far"
            self.in_view[band] += 1
            self.found[band] += bool(near)
            if near:
                j = min(near, key=lambda which: float(np.hypot(*off[which])))
                self.distances.append(float(off[j] @ np.linalg.solve(vests[j].covariance, off[j])))
        self.n_false += len(vests) - len(used)

    def __str__(self) -> str:
        """Rows of a table."""
        rows = {
            f"found, {name}": f"{self.found[band]} of {self.in_view[band]}, "
            f"{100 * self.found[band] / max(1, self.in_view[band]):.1f} %"
            for band, name in (("near", "1 to 10 m"), ("far", "10 to 20 m"))
        }
        squared = f"{np.mean(self.distances):.2f} / {np.percentile(self.distances, 99):.1f}"
        rows["squared statistical distance of those found, mean / p99 (2 / 9.2 if right)"] = squared
        rows["found where nobody is, of sets of pictures"] = f"{self.n_false} of {len(self.times)}"
        rows["detection in a set, processor ms: median / p99"] = "{:.0f} / {:.0f}".format(
            *(1e3 * np.percentile(self.times, (50, 99)))
        )
        return _table(rows)


@cache
def hall_plan(seed: int) -> DrivePlan:
    """Draw a hall, and plan a drive of some 12 m through it."""
    rng = derived_rng("watched hall", seed)
    boxes = tuple(
        FloorBox(f"box {k}", (rng.uniform(4.0, 11.0), y), (rng.uniform(0.5, 3.0), rng.uniform(0.8, 1.4)))
        for k, y in enumerate((1.2, 6.8, float(rng.choice([1.5, 6.5]))))
    )
    start, goal = np.array([1.5, rng.uniform(3.0, 5.0), 0.0]), np.array([13.5, rng.uniform(3.0, 5.0), 0.0])
    return plan_drive(DrivingArea((0.0, 0.0), (16.0, 8.0), boxes, start, goal))


@dataclass
class DriveFigures:
    """What came of drives."""

    drives: list[WatchedDrive] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def add(self, seed: int, watch: Watch, guards: Guards) -> None:
        """Play one drive."""
        plan = hall_plan(seed // SCENES_OF_A_HALL)
        began = process_time()
        self.drives.append(watch_zone(plan, draw_watched_scene(plan, 3, seed), watch, seed, guards))
        self.times.append(process_time() - began)

    def __str__(self) -> str:
        """Rows of a table."""
        touches = [touch for drive in self.drives for touch in drive.touches]
        people = [person for drive in self.drives for person in drive.people]
        hours = sum(PERIOD * len(drive.poses) for drive in self.drives) / 3600
        by_truck = [touch for touch in touches if touch.is_by_truck]
        n_people = sum(len(drive.scene.walkers) for drive in self.drives)
        rows = {
            "drives / people / at the goal": f"{len(self.drives)} / {n_people} / "
            f"{sum(drive.arrived for drive in self.drives)}",
            "time watched, h": f"{hours:.3f}",
            "touched by the truck / of them avoidable / walked into it": f"{len(by_truck)} / "
            f"{sum(t.is_avoidable for t in by_truck)} / {len(touches) - len(by_truck)}",
            "processor s of a drive, median": f"{np.median(self.times):.1f}",
        }
        for by in ("scanner", "vests"):
            made = [each for drive in self.drives for each in drive.requests if each.by == by]
            delays = [1e3 * each.delay for each in made if each.delay is not None]
            if made:
                worst = "{:.0f} / {:.0f}".format(*np.percentile(delays, (50, 100))) if delays else "-"
                rows[f"requests by the {by} / without anybody"] = f"{len(made)} / {len(made) - len(delays)}"
                rows[f"delay of requests by the {by}, ms: median / worst"] = worst
        seen = [each for each in people if each.seen_time is not None]
        if seen:
            n_in_view, n_found = sum(each.n_in_view for each in people), sum(each.n_found for each in people)
            rows["in view / of them seen"] = f"{sum(each.n_in_view > 0 for each in people)} / {len(seen)}"
            rows["found, of sets of pictures with the vest in view"] = (
                f"{n_found} of {n_in_view}, {100 * n_found / n_in_view:.1f} %"
            )
            off = [float(each.velocity_error or 0.0) for each in seen]
            rows["error of velocity, m/s: median / worst person"] = f"{np.median(off):.2f} / {max(off):.2f}"
            n_false = sum(drive.n_false for drive in self.drives)
            rows["false tracks / an hour"] = f"{n_false} / {n_false / hours:.1f}"
        return _table(rows)


def _table(rows: dict[str, str]) -> str:
    return "\n".join(f"| {what} | {figure} |" for what, figure in rows.items())


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=int, default=300, help="sets of pictures")
    parser.add_argument("--drives", type=int, default=10, help="with the vest cameras alone")
    parser.add_argument("--crossings", type=int, default=40, help="drives with the scanner alone")
    parser.add_argument("--seed", type=int, default=0, help="of the first of each")
    given = parser.parse_args()
    watch = read_watch(watch_file("citi_truck"))
    if given.pictures:
        pictures = PictureFigures()
        for k in range(given.pictures):
            pictures.add(given.seed + k, watch)
        print(f"pictures\n{pictures}", flush=True)
    narrow = replace(watch, fields=replace(watch.fields, approach=0.0))
    for what, n, of, guards in (
        ("crossings, scanner alone", given.crossings, watch, Guards(vests=False)),
        ("crossings, scanner alone, fields without approach", given.crossings, narrow, Guards(vests=False)),
        ("drives, vest cameras alone", given.drives, watch, Guards(scanner=False)),
    ):
        drives = DriveFigures()
        for k in range(n):
            drives.add(given.seed + k, of, guards)
        if n:
            print(f"{what}\n{drives}", flush=True)


if __name__ == "__main__":
    main()
