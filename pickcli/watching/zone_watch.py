"""Plays a drive through a watched scene: sensors, guards and brake, with the truth beside them."""

from __future__ import annotations

import numpy as np

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_tracking import PERIOD, TrackingController
from pickcli.driving.simulated_drives import DriveNoise, NoisyTruck
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.seeds import derived_rng
from pickcli.watching.drive_watch import DriveWatch, Guards
from pickcli.watching.watch_file import Watch
from pickcli.watching.watched_drive import WatchedDrive
from pickcli.watching.watched_scene import WatchedScene

BELIEVED_EVERY = 0.1  # s between two localisations


class _Play:
    """One drive, instant by instant."""

    def __init__(self, plan: DrivePlan, scene: WatchedScene, watch: Watch, guards: Guards, seed: int) -> None:
        self.controller = TrackingController(plan, 1)
        rng, truck = derived_rng("drives", seed), plan.area.truck
        self.truck = NoisyTruck(truck, plan.area.start, DriveNoise(), 1, rng)
        self.watch = DriveWatch(scene, plan.area, watch, guards, seed)
        self.unwatched = 0.0
        self._n_between = max(1, round(BELIEVED_EVERY / PERIOD))

    def step(self, k: int) -> bool:
        """Play one period; whether the truck is at its goal."""
        if k % self._n_between == 0:
            self.truck.localise()
        is_braked = self.watch.brakes(self.truck.true[0], self.truck.believed[0], self.controller)
        self.controller.control(self.truck.believed, np.array([is_braked]))
        step = self.controller.signs * self.controller.speed * PERIOD
        if self.watch.rear is None:
            self.unwatched += float(np.maximum(-step, 0.0)[0])
        self.truck.move(self.controller.steering, step)
        self.controller.advance()
        return bool(self.controller.is_done[0])


def watch_zone(
    plan: DrivePlan, scene: WatchedScene, watch: Watch, seed: int, guards: Guards | None = None,
    observe: ProgressObserver = nobody,
) -> WatchedDrive:  # fmt: skip
    """Play a drive through a watched scene.

    Args:
        plan: The drive.
        scene: The scene.
        watch: The sensors, fields and brake.
        seed: Seed of all noise.
        guards: Which guards watch; None for both.
        observe: Told of the progress.

    Returns:
        What came of it.
    """
    play = _Play(plan, scene, watch, guards or Guards(), seed)
    n, arrived = int(scene.duration / PERIOD), False
    for k in range(n):
        arrived = play.step(k)
        if arrived:
            break
        if k % 50 == 0:
            observe(Progress(k, n))
    seen, truth = play.watch, play.watch.truth
    return WatchedDrive(
        scene, np.array(truth.poses), np.array([motion.speed for motion in truth.motions]),
        np.array(seen.is_braked), arrived, play.unwatched, truth.people(), seen.reports(), truth.touches(),
        truth.n_false, seen.n_pictures, {number: np.array(rows) for number, rows in seen.tracks.items()},
    )  # fmt: skip
