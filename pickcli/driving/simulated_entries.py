"""Drives into a pallet in simulation: the truck looks at it on the way, and its path is changed each time.

A picture is taken each ``LOOK_PERIOD`` from where the truck truly is. What it says is put where the truck
believes to be, so that errors of localisation cancel as far as they stay the same. While a path is computed
the truck goes on along the old one, which the new one leaves ``LATENCY`` later. Where the path does not lead
to where the pallet was last seen, as too little of it is left to be changed, the truck stops before its
straight part and plans anew from there. So it does right before the pallet if its forks would miss the
pockets, as it could not follow its path.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pickcli.driving.area_view import take_picture
from pickcli.driving.drive_overseer import DriveOverseer
from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.drive_tracking import PERIOD, TrackingController
from pickcli.driving.driving_area import DrivingArea, StatedPallet
from pickcli.driving.pallet_entry import entered_pose, entry_depth, pallet_gap, plan_entry_anew, renewed_entry
from pickcli.driving.pallet_look import look_for_pallet, seen_pallet
from pickcli.driving.simulated_drives import (
    END_POSITION,
    END_YAW,
    MORE_TIME,
    MOST_TIME,
    DriveNoise,
    NoisyTruck,
)
from pickcli.driving.steering_path import posed, seen_from, wrapped
from pickcli.driving.tricycle import PLANNED_SHARE
from pickcli.driving.truck_camera import TruckCamera
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array
from pickcli.seeds import derived_rng, derived_seed

LOOK_PERIOD = 0.5  # s between two pictures
LATENCY = 0.5  # s from a picture to the first change of the path
CHANGED = np.array([0.002, 0.002, 0.002])  # m, m and rad, from which on a path is changed
TRUSTED = np.array(
    [0.012, 0.012, 0.008]
)  # m, m and rad, up to which the truck goes straight into the pockets
STOP_BEFORE = 0.05  # m of travel before the straight part, where a truck comes to rest that does not go on
MOST_STOPS = 3
FIRST_IN_POCKETS = 0.15  # m of the pockets, for which it is looked ahead whether the forks get into them
N_AHEAD = 16  # poses on that way
LEAST_GAP = 0.005  # m that forks keep there from the sides of pockets, as the truck believes
N_MEANT = 5  # last pictures, over whose poses the mean is taken: localisation errs anew in each


@dataclass(frozen=True, eq=False)
class SimulatedEntry:
    """What came of one drive.

    Attributes:
        off: (3,) m, m, rad: the truck at the end against where it should be in the true pallet, in the
            frame of that pose.
        n_seen: Pictures in which the pallet was found.
        n_renewed: How often the path was changed while it was driven.
        n_stops: How often the truck stopped before the straight part, and planned anew.
        has_given_up: Whether it did not get in: the pallet was not seen, there was no path or no time, or it
            was braked for good.
        duration: s.
        poses: (T, 3) m, m, rad: true poses of the truck in every period.
        seen: The pallet where it was seen last, as the truck believed to be; None if it was not.
    """

    off: Array
    n_seen: int
    n_renewed: int
    n_stops: int
    has_given_up: bool
    duration: float
    poses: Array
    seen: StatedPallet | None

    @property
    def is_within(self) -> bool:
        """Whether it is in the pallet as APPLE asks."""
        is_near = np.hypot(*self.off[:2]) <= END_POSITION and abs(self.off[2]) <= END_YAW
        return bool(is_near and not self.has_given_up)


def simulate_entries(
    area: DrivingArea, plan: DrivePlan, n_drives: int, seed: int, noise: DriveNoise | None = None
) -> list[SimulatedEntry]:
    """Drive into a pallet several times.

    Args:
        area: The area, with a camera and the expected pallet. The true one is where the area says, or if it
            says nothing anywhere within the tolerance, anew in each drive.
        plan: A drive into the pallet that was expected.
        n_drives: How often.
        seed: Seed of all noise.
        noise: Of the drives; None for the usual one.

    Returns:
        What came of each.
    """
    assert area.camera is not None and area.pallet is not None
    found = []
    for k in range(n_drives):
        rng = derived_rng("entries", seed, k)
        stated = area.pallet
        if not stated.off.any():
            stated = replace(stated, off=rng.uniform(-1.0, 1.0, 3) * stated.tolerance)
        truck = NoisyTruck(area.truck, plan.area.start, noise or DriveNoise(), 1, rng)
        found.append(enter_pallet(area, plan, stated, truck, derived_seed("looks", seed, k)))
    return found


def enter_pallet(
    area: DrivingArea, plan: DrivePlan, stated: StatedPallet, truck: NoisyTruck, seed: int,
    overseer: DriveOverseer | None = None,
) -> SimulatedEntry:  # fmt: skip
    """Drive one truck into a pallet.

    Args:
        area: The area, with a camera and the expected pallet.
        plan: A drive into the pallet that was expected.
        stated: The pallet that is expected, and how far the real one is off.
        truck: The truck, near the start of the plan; afterwards it is where the drive ended.
        seed: Of the pictures.
        overseer: Brakes the truck; None if nothing does.

    Returns:
        What came of it.
    """
    assert area.camera is not None
    return _Entry(area, area.camera, plan, stated, truck).driven(seed, overseer)


def entry_figures(entries: list[SimulatedEntry]) -> dict[str, Any]:
    """Return the figures of drives that people ask for.

    Args:
        entries: The drives.

    Returns:
        Plain values; the errors are those of the drives that were not given up.
    """
    off = np.array([each.off for each in entries if not each.has_given_up]).reshape(-1, 3)
    return {
        "number": len(entries),
        "within": sum(each.is_within for each in entries),
        "given_up": sum(each.has_given_up for each in entries),
        "position_error": round(float(np.hypot(*off[:, :2].T).max(initial=0.0)), 6),
        "yaw_error_deg": round(float(np.degrees(np.abs(off[:, 2]).max(initial=0.0))), 4),
        "renewals": sum(each.n_renewed for each in entries),
        "stops": sum(each.n_stops for each in entries),
        "duration": round(max(each.duration for each in entries), 3),
    }


class _Entry:
    """One drive."""

    def __init__(
        self, area: DrivingArea, camera: TruckCamera, plan: DrivePlan, stated: StatedPallet, truck: NoisyTruck
    ) -> None:
        assert plan.area.pallet is not None
        self.area, self.camera, self.plan = area, camera, plan
        self.real, self.truck = stated.real, truck
        self.expected = replace(plan.area.pallet, tolerance=stated.tolerance)
        self.seen: StatedPallet | None = None
        self.poses: list[Array] = []  # (3,) m, m, rad, as seen in each picture
        self.driven_poses = [truck.true[0]]
        self.n_seen = self.n_renewed = self.n_stops = 0

    def driven(self, seed: int, overseer: DriveOverseer | None) -> SimulatedEntry:
        """Drive until the truck is in the pallet, or gives up before it."""
        truck, controller = self.truck, TrackingController(self.plan, 1)
        fix, look = max(1, round(truck.noise.fix_period / PERIOD)), round(LOOK_PERIOD / PERIOD)
        n_driven = k = 0
        n_periods, has_given_up = _most_periods(self.plan), False
        while n_driven < n_periods:  # periods in which it is braked do not count
            if k % fix == 0:
                truck.localise()
            if k % look == 0:
                self._look(controller, truck, derived_seed("look", seed, k))
            controller.is_held |= self._has_to_stop(controller) or self._goes_astray(controller, truck)
            if controller.is_held.any() and not controller.speed.any():
                self._look(controller, truck, derived_seed("look at rest", seed, k))
                planned = self._planned_anew(truck)
                if planned is None:
                    has_given_up = True
                    break
                self.plan, controller = planned, TrackingController(planned, 1)
                n_periods = n_driven + _most_periods(planned)
            if controller.is_done.all():
                break
            is_braked = overseer is not None and overseer.brakes(truck.true[0], truck.believed[0], controller)
            if overseer is not None and overseer.has_given_up:
                has_given_up = True
                break
            controller.control(truck.believed, np.array([is_braked]))
            truck.move(controller.steering, controller.signs * controller.speed * PERIOD)
            controller.advance()
            self.driven_poses.append(truck.true[0])
            k, n_driven = k + 1, n_driven + (not is_braked)
        else:
            has_given_up = True  # it did not arrive in the time that there is
        return SimulatedEntry(
            self._off(truck), self.n_seen, self.n_renewed, self.n_stops, has_given_up, PERIOD * k,
            np.array(self.driven_poses), self.seen,
        )  # fmt: skip

    def _look(self, controller: TrackingController, truck: NoisyTruck, seed: int) -> None:
        """Take a picture; if the pallet is elsewhere than the path leads, change the path if it can be."""
        travel = float(controller.travel[0] + controller.speed[0] * LATENCY)
        if controller.speed.any() and controller.travel[0] > self._straight_at:
            return
        believed = truck.believed[0]
        try:
            picture = take_picture(self.area, self.camera, truck.true[0], self.real, seed)
            seen = look_for_pallet(picture, self.camera, believed, self.expected)
        except InputError:
            return
        self.poses.append(seen_pallet(seen, believed, self.expected).pose)
        last = np.array(self.poses[-N_MEANT:])
        turns = wrapped(last[:, 2] - last[-1, 2])
        mean = np.array([*last[:, :2].mean(axis=0), last[-1, 2] + turns.mean()])
        self.seen = replace(self.expected, pose=mean)
        self.n_seen += 1
        if controller.is_held.any() or self._leads_to(self.seen, CHANGED):
            return
        renewed = renewed_entry(self.plan, travel, self.seen)
        if renewed is not None:
            self.n_renewed += 1
            self.plan = renewed
            controller.follow(renewed)

    def _leads_to(self, pallet: StatedPallet, within: Array) -> bool:
        """Whether the path leads to a pallet within m, m and rad."""
        assert self.plan.area.pallet is not None
        off = seen_from(self.plan.area.pallet.pose, pallet.pose)
        off[2] = wrapped(off[2])
        return bool((np.abs(off) <= within).all())

    def _has_to_stop(self, controller: TrackingController) -> bool:
        """Whether the truck has to brake now to stay before a pallet to which the path does not lead."""
        speed, travel = float(controller.speed[0]), float(controller.travel[0])
        braking = speed**2 / (2 * PLANNED_SHARE * self.area.truck.acceleration) + speed * PERIOD
        is_near = travel + braking + STOP_BEFORE > self._straight_at > travel
        return is_near and (self.seen is None or not self._leads_to(self.seen, TRUSTED))

    def _goes_astray(self, controller: TrackingController, truck: NoisyTruck) -> bool:
        """Whether the truck has to brake now, as straight on its forks would not get into the pockets.

        It is asked just before braking would be too late: until then the truck may still come onto its path.
        """
        if self.seen is None:
            return False
        speed, travel = float(controller.speed[0]), float(controller.travel[0])
        before = self.plan.path.length - travel - entry_depth(self.area, self.seen)  # m from tips to pallet
        braking = speed**2 / (2 * PLANNED_SHARE * self.area.truck.acceleration) + speed * PERIOD
        if not 0.0 < before < braking + STOP_BEFORE:
            return False
        ahead = np.linspace(0.0, before + FIRST_IN_POCKETS, N_AHEAD)
        poses = np.array([posed(truck.believed[0], np.array([-each, 0.0, 0.0])) for each in ahead])
        return pallet_gap(self.area, self.seen, poses) < LEAST_GAP

    def _planned_anew(self, truck: NoisyTruck) -> DrivePlan | None:
        """A drive from where the truck rests into the pallet where it was seen; None if there is none."""
        self.n_stops += 1
        if self.seen is None or self.n_stops > MOST_STOPS:
            return None
        try:
            return plan_entry_anew(replace(self.area, start=truck.believed[0]), self.seen)
        except (InputError, NoPlanError):
            return None

    @property
    def _straight_at(self) -> float:
        """Travel (m) at which the straight part begins."""
        return self.plan.path.length - abs(self.plan.area.straight)

    def _off(self, truck: NoisyTruck) -> Array:
        """(3,) of the truck against where it should be in the true pallet; far off if there is none."""
        wanted = [entered_pose(self.area, pallet) for pallet in self.real]
        off = seen_from(wanted[0], truck.true[0]) if wanted else np.array([np.inf, np.inf, 0.0])
        return np.array([off[0], off[1], wrapped(off[2])])


def _most_periods(plan: DrivePlan) -> int:
    """In how many periods the truck has to be there."""
    return int((MOST_TIME * plan.profile.duration + MORE_TIME) / PERIOD)
