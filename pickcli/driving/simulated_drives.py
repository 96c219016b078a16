"""Drives a plan in simulation: poses are known with noise, and the truck acts with errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.drive_overseer import DriveOverseer
from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_tracking import PERIOD, TrackingController
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.steering_path import wrapped
from pickcli.driving.tricycle import Tricycle
from pickcli.geometry import Array
from pickcli.seeds import derived_rng

FIX_GAIN = 0.18  # of what a localisation differs from odometry, by which that is corrected
END_POSITION, END_YAW = 0.03, np.radians(1.0)  # m and rad that APPLE asks for at the end
SEEN_EVERY = 5  # periods between poses whose clearance is looked at
MOST_TIME, MORE_TIME = 3.0, 20.0  # of a plan's duration, and s, after which a drive ends wherever it is


@dataclass(frozen=True)
class DriveNoise:
    """Standard deviations of errors. They are ours: the paper of APPLE states none.

    Attributes:
        position: m, of each localisation along x and y.
        yaw: rad, of each localisation.
        fix_period: s between two localisations.
        start_position: m, of the true start along x and y.
        start_yaw: rad, of the true start.
        wheel_scale: of travel that odometry tells, one for each drive.
        steering_offset: rad of the steering angle that is told, one for each drive.
        speed: of the speed, anew in each period.
        steering: rad, of the angle at which the wheel acts, anew in each period.
    """

    position: float = 0.01
    yaw: float = 0.005
    fix_period: float = 0.1
    start_position: float = 0.01
    start_yaw: float = 0.01
    wheel_scale: float = 0.01
    steering_offset: float = 0.005
    speed: float = 0.03
    steering: float = 0.01


@dataclass(frozen=True, eq=False)
class SimulatedDrives:
    """What came of drives, each (N,).

    Attributes:
        position_errors: m, of the true pose at the end against the goal.
        yaw_errors: rad, not negative.
        deviations: m, most that the axle's middle was off the path.
        clearances: m, least distance of the truck from everything, each ``SEEN_EVERY`` periods.
        durations: s.
        speeds: m/s, largest.
        accelerations: m/s^2, largest.
        steering: rad, largest angle.
        steering_rates: rad/s, largest.
        centripetal: m/s^2, largest.
    """

    position_errors: Array
    yaw_errors: Array
    deviations: Array
    clearances: Array
    durations: Array
    speeds: Array
    accelerations: Array
    steering: Array
    steering_rates: Array
    centripetal: Array

    @property
    def are_within(self) -> NDArray[np.bool_]:
        """(N,) whether the end pose is as APPLE asks."""
        within: NDArray[np.bool_] = (self.position_errors <= END_POSITION) & (self.yaw_errors <= END_YAW)
        return within

    @property
    def figures(self) -> dict[str, Any]:
        """Plain values: number of drives within what is asked, and the worst of each figure."""
        return {
            "number": len(self.durations),
            "within": int(self.are_within.sum()),
            "position_error": round(float(self.position_errors.max()), 6),
            "yaw_error_deg": round(float(np.degrees(self.yaw_errors.max())), 4),
            "clearance": round(float(self.clearances.min()), 6),
            "duration": round(float(self.durations.max()), 3),
        }


@dataclass(frozen=True, eq=False)
class FollowedDrives:
    """What trucks did in every period while they followed a plan.

    Attributes:
        poses: (T, N, 3) m, m, rad: true poses.
        speeds: (T, N) m/s of the steered wheel, as commanded, not negative.
        steering: (T, N) rad, as commanded.
        travel: (T, N) m along the path.
    """

    poses: Array
    speeds: Array
    steering: Array
    travel: Array

    @property
    def durations(self) -> Array:
        """(N,) s until each truck stood at the end."""
        durations: Array = PERIOD * (len(self.speeds) - 1 - (self.speeds[::-1] > 0).argmax(axis=0))
        return durations


class NoisyTruck:
    """True and believed poses of many drives, (N, 3) m, m, rad.

    Args:
        truck: Figures of the truck.
        start: (3,) m, m, rad: where all believe to start.
        noise: Standard deviations of errors.
        n: How many drives.
        rng: Draws them.
    """

    def __init__(
        self, truck: Tricycle, start: Array, noise: DriveNoise, n: int, rng: np.random.Generator
    ) -> None:
        self.truck, self.noise, self.rng = truck, noise, rng
        self.true = start + self._drawn(noise.start_position, noise.start_yaw, n)
        self.believed = np.tile(start, (n, 1))
        self.scale = 1 + noise.wheel_scale * rng.standard_normal(n)
        self.offset = noise.steering_offset * rng.standard_normal(n)

    def _drawn(self, position: float, yaw: float, n: int) -> Array:
        return self.rng.standard_normal((n, 3)) * [position, position, yaw]

    def localise(self) -> None:
        """Correct what is believed by a localisation."""
        off = self.true + self._drawn(self.noise.position, self.noise.yaw, len(self.true)) - self.believed
        off[:, 2] = wrapped(off[:, 2])
        self.believed = self.believed + FIX_GAIN * off

    def move(self, steering: Array, step: Array) -> None:
        """Move as the truck acts, and as odometry tells.

        Args:
            steering: (N,) rad.
            step: (N,) m of signed travel.
        """
        noise, draw = self.noise, self.rng.standard_normal
        acted = steering + self.offset + noise.steering * draw(len(step))
        self.true = self._moved(self.true, acted, step * (1 + noise.speed * draw(len(step))))
        self.believed = self._moved(self.believed, steering, step * self.scale)

    def _moved(self, poses: Array, steering: Array, step: Array) -> Array:
        moved = poses[:, :2] + self.truck.displacement(poses[:, 2], steering, steering, step)
        return np.column_stack([moved, poses[:, 2] + self.truck.yaw_change(steering, steering, step)])


def simulate_drives(
    plan: DrivePlan, n_drives: int, seed: int, noise: DriveNoise | None = None
) -> SimulatedDrives:
    """Drive a plan several times, with noise.

    Args:
        plan: The plan.
        n_drives: How often.
        seed: Seed of the noise.
        noise: The noise; None for the usual one.

    Returns:
        What came of the drives.
    """
    noise = noise or DriveNoise()
    truck = NoisyTruck(plan.area.truck, plan.area.start, noise, n_drives, derived_rng("drives", seed))
    return _judged(plan, followed(plan, truck))


def followed(plan: DrivePlan, truck: NoisyTruck, overseer: DriveOverseer | None = None) -> FollowedDrives:
    """Let trucks follow a plan to its end.

    Args:
        plan: The plan.
        truck: The trucks, near the start of the plan; afterwards they are where the drives ended.
        overseer: Brakes the truck, of which there is one then; None if nothing does.

    Returns:
        What they did.
    """
    controller = TrackingController(plan, len(truck.true))
    n_periods = int((MOST_TIME * plan.profile.duration + MORE_TIME) / PERIOD)
    fix = max(1, round(truck.noise.fix_period / PERIOD))
    poses, speeds, steering, travel = (
        [truck.true],
        [controller.speed],
        [controller.steering],
        [controller.travel],
    )
    n_driven = k = 0
    while n_driven < n_periods:  # periods in which it is braked do not count
        if k % fix == 0:
            truck.localise()
        is_braked = overseer is not None and overseer.brakes(truck.true[0], truck.believed[0], controller)
        controller.control(truck.believed, np.full(len(truck.true), is_braked))
        truck.move(controller.steering, controller.signs * controller.speed * PERIOD)
        controller.advance()
        k, n_driven = k + 1, n_driven + (not is_braked)
        poses.append(truck.true)
        speeds.append(controller.speed)
        steering.append(controller.steering)
        travel.append(controller.travel)
        if controller.is_done.all() or (overseer is not None and overseer.has_given_up):
            break
    return FollowedDrives(*map(np.array, (poses, speeds, steering, travel)))


def _judged(plan: DrivePlan, drives: FollowedDrives) -> SimulatedDrives:
    """Figures of drives."""
    poses, speeds, steering, travel = drives.poses, drives.speeds, drives.steering, drives.travel
    n = poses.shape[1]
    off = poses[-1] - plan.area.goal
    wanted = plan.path.poses_at(travel.ravel()).reshape(poses.shape)
    seen = poses[::SEEN_EVERY].reshape(-1, 3)
    least = clearances(plan.area, seen).min(axis=1).reshape(-1, n).min(axis=0)
    yaw_rate = speeds * np.abs(np.sin(steering)) / plan.area.truck.wheel_base
    return SimulatedDrives(
        np.hypot(off[:, 0], off[:, 1]), np.abs(wrapped(off[:, 2])),
        np.hypot(*np.moveaxis(poses - wanted, -1, 0)[:2]).max(axis=0), least,
        drives.durations, speeds.max(axis=0),
        np.abs(np.diff(speeds, axis=0)).max(axis=0) / PERIOD, np.abs(steering).max(axis=0),
        np.abs(np.diff(steering, axis=0)).max(axis=0) / PERIOD, (speeds * yaw_rate).max(axis=0),
    )  # fmt: skip
