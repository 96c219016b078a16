"""The truck of a commission: its drives, with noise, and the pallet on its forks.

Drives are planned on the lattice from where the truck believes to be, while it stands. The pallet is found in
simulated depth pictures on the way into it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pickcli.commission.commission_result import ActionError, FloorDeviation
from pickcli.commission.commission_station import CommissionStation, with_thing_at
from pickcli.commission.people_watch import MOST_WAIT, PeopleWatch, WatchedOutcome
from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.driving_area import DrivingArea, StatedPallet
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import pallet_gap, plan_entry, plan_entry_anew, plan_exit
from pickcli.driving.simulated_drives import DriveNoise, FollowedDrives, NoisyTruck, followed
from pickcli.driving.simulated_entries import enter_pallet
from pickcli.driving.steering_path import posed, seen_from, wrapped
from pickcli.driving.tricycle import Tricycle
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array
from pickcli.seeds import derived_rng, derived_seed

NEAR = 0.02, float(np.deg2rad(0.7))  # m and rad of its goal, where a truck believes to have arrived
STRAIGHT_TO_LOAD, STRAIGHT_TO_DELIVERY = 0.2, -0.3  # m of the last part of drives, negative backwards
ENTRY = "enter_pallet"  # name of drives into the pallet


@dataclass(frozen=True, eq=False)
class TruckDrive:
    """One drive as it was driven.

    Attributes:
        name: What it was for.
        duration: s.
        poses: (T, 3) m, m, rad: true poses of the truck, ``PERIOD`` apart.
        felt: (T - 1, 2) m/s^2: accelerations of the pallet on the forks from pose to pose, in the frame of
            the truck; none without a pallet.
        figures: Plain values by name.
        watched: What came of its watch for people; None if it was not watched.
    """

    name: str
    duration: float
    poses: Array
    felt: Array
    figures: dict[str, Any]
    watched: WatchedOutcome | None = None


class CommissionTruck:
    """The truck and its pallet.

    Args:
        station: The commission in its cell.
        noise: Errors of localisation and of drives.
        seed: Seed of all random choices.
        oversee: Makes what watches a drive, from its name and area; None if nobody watches.

    Attributes:
        on_forks: (3,) m, m, rad: where the pallet truly is in the frame of the truck; None if it is not
            entered.
        is_raised: Whether the forks are raised with it.
        set_down_at: (3,) m, m, rad: where it truly stands after it was set down.
        drives: All drives, in order.
        n_collisions: How many of them met something, and how many people the truck touched.
    """

    def __init__(
        self, station: CommissionStation, noise: DriveNoise, seed: int,
        oversee: Callable[[str, DrivingArea], PeopleWatch] | None = None,
    ) -> None:  # fmt: skip
        commission = station.commission
        self._oversee = oversee
        self.station, self.seed = station, seed
        self._truck = NoisyTruck(
            commission.area.truck, commission.area.start, noise, 1, derived_rng("commission drives", seed)
        )
        self._pallet = _really_off(commission.pallet, seed)
        self._expected = commission.pallet  # where it was seen last, after a first entry
        self.on_forks: Array | None = None
        self.is_raised = False
        self.set_down_at: Array | None = None
        self._left_behind: Array | None = None  # (3,) m, m, rad, where that is believed to be
        self.drives: list[TruckDrive] = []
        self.n_collisions = 0

    @property
    def true(self) -> Array:
        """(3,) m, m, rad: where the truck truly is."""
        true: Array = self._truck.true[0].copy()
        return true

    @property
    def believed(self) -> Array:
        """(3,) m, m, rad: where it believes to be."""
        believed: Array = self._truck.believed[0].copy()
        return believed

    def enter(self) -> TruckDrive:
        """Drive into the pallet where it is seen on the way; again from right before it if that failed.

        Returns:
            The drive.

        Raises:
            ActionError: There is no way, the pallet was not seen, or it was met.
        """
        if self.on_forks is not None:
            raise ActionError("the forks are in the pallet already")
        self._truck.localise()
        area, expected = self.station.entering(self.believed), self._expected
        again = any(each.name == ENTRY for each in self.drives)
        plan = _planned(lambda: (plan_entry_anew if again else plan_entry)(area, expected))
        seed = derived_seed("commission looks", self.seed, len(self.drives))
        watch = self._watch_of(ENTRY, area)
        entry = enter_pallet(area, plan, self._pallet, self._truck, seed, watch)
        self._expected = entry.seen or self._expected
        figures = {"pictures": entry.n_seen, "renewals": entry.n_renewed, "stops": entry.n_stops}
        driven = TruckDrive(ENTRY, entry.duration, entry.poses, np.zeros((0, 2)), figures, _outcome(watch))
        drive = self._driven(driven, area, self._pallet.real)
        if entry.has_given_up:
            why = "the pallet was not seen, or there is no path into it where it was seen"
            raise ActionError(why, drive.figures)
        (real,) = self._pallet.real
        self.on_forks = seen_from(self.true, real.pose)
        return drive

    def to_load(self) -> TruckDrive | None:
        """Drive to the load with the pallet on the forks.

        Returns:
            The drive; None if the truck stands there.

        Raises:
            ActionError: No pallet is raised, there is no way, or the truck did not get there.
        """
        return self._loaded("drive load", self.station.at_load, STRAIGHT_TO_LOAD)

    def to_delivery(self, on_forks: Array) -> TruckDrive | None:
        """Drive to where the pallet is to be set down.

        Args:
            on_forks: (3,) m, m, rad: where the pallet was seen in the frame of the truck.

        Returns:
            The drive; None if the truck stands there.

        Raises:
            ActionError: As for ``to_load``.
        """
        at = with_thing_at(self.station.commission.delivery, on_forks)
        return self._loaded("drive delivery", at, STRAIGHT_TO_DELIVERY)

    def leave(self) -> TruckDrive | None:
        """Drive out of the pallet that was set down, if the truck is in it, to the end of the commission.

        Returns:
            The drive; None if the truck stands there.

        Raises:
            ActionError: The pallet is not set down, there is no way, or the truck did not get there.
        """
        if self.set_down_at is None:
            raise ActionError("the pallet is not set down")
        self._truck.localise()
        area, end = self.station.leaving(self.believed), self.station.commission.end
        if is_near(self.believed, end):
            return None
        if self._left_behind is None:
            self._left_behind = posed(self.believed, self.station.pallet_in_truck)
        pallet = replace(self.station.commission.pallet, pose=self._left_behind)
        plan, real = _planned(lambda: _plan_leaving(area, pallet)), replace(pallet, pose=self.set_down_at)
        return self._arrived(end, self._followed("drive end", plan, area, (real,)))

    def raise_forks(self) -> None:
        """Raise the forks with the pallet. Raises ActionError without one."""
        if self.on_forks is None:
            raise ActionError("no pallet is on the forks")
        self.is_raised = True

    def set_down(self) -> FloorDeviation:
        """Lower the forks with the pallet.

        Returns:
            How far it truly stands from where it was to be delivered.

        Raises:
            ActionError: No pallet is raised.
        """
        if not self.is_raised or self.on_forks is None:
            raise ActionError("no pallet is raised")
        self.is_raised, self.set_down_at = False, posed(self.true, self.on_forks)
        return deviation(self.set_down_at, self.station.commission.delivery)

    def _loaded(self, name: str, at: Array, straight: float) -> TruckDrive | None:
        if not self.is_raised:
            raise ActionError("no pallet is raised")
        self._truck.localise()
        if is_near(self.believed, at):
            return None
        area = self.station.loaded(self.believed, at, straight)
        return self._arrived(at, self._followed(name, _planned(lambda: plan_drive(area)), area))

    def _followed(
        self, name: str, plan: DrivePlan, area: DrivingArea, pallets: Sequence[StatedPallet] = ()
    ) -> TruckDrive:
        watch = self._watch_of(name, area)
        run = followed(plan, self._truck, watch)
        duration = float(run.durations[0])
        felt = np.zeros((0, 2))
        if self.is_raised:
            felt = _felt(run, area.truck, float(self.station.pallet_in_truck[0]))
        figures = {"planned_s": plan.profile.duration}
        driven = TruckDrive(name, duration, run.poses[:, 0], felt, figures, _outcome(watch))
        return self._driven(driven, area, pallets)

    def _watch_of(self, name: str, area: DrivingArea) -> PeopleWatch | None:
        """What watches a drive."""
        return None if self._oversee is None else self._oversee(name, area)

    def _driven(
        self, drive: TruckDrive, area: DrivingArea, pallets: Sequence[StatedPallet] = ()
    ) -> TruckDrive:
        """Keep a drive up to its end, and count whether the truck met anything: pallets on the floor, too.

        Raises:
            ActionError: Somebody stayed before the truck for so long that the drive was given up, or it met a
                pallet.
        """
        n, figures, watched = round(drive.duration / PERIOD) + 1, drive.figures, drive.watched
        least = self._clearance(area, drive.poses)
        drive = replace(drive, poses=drive.poses[:n], felt=drive.felt[: n - 1])
        self.n_collisions += least <= 0.0
        figures |= {"drive_s": drive.duration, "clearance_m": least}
        gap = min((pallet_gap(area, each, drive.poses) for each in pallets), default=np.inf)
        if pallets:
            figures["pallet_gap_m"] = gap
            self.n_collisions += gap <= 0.0
        if watched is not None:
            figures |= watched.figures
            self.n_collisions += len(watched.touched)
        self.drives.append(drive)
        if watched is not None and watched.has_given_up:
            raise ActionError(
                f"somebody stayed in the protective field: the truck did not get on for {MOST_WAIT:g} s",
                figures,
            )
        if gap <= 0.0:
            raise ActionError(f"the forks or the truck met the pallet, {-1e3 * gap:.0f} mm deep", figures)
        return drive

    def _clearance(self, area: DrivingArea, poses: Array) -> float:
        """Least distance of truck and raised pallet from walls and boxes, m, the pallet where it truly is."""
        if not self.is_raised or self.on_forks is None:
            return float(clearances(area, poses).min())
        bare, shape = self.station.commission.area.truck, self.station.commission.pallet.shape
        pallet = replace(bare, front=shape.length / 2, back=shape.length / 2, width=shape.width)
        carried = clearances(replace(area, truck=pallet), posed(poses, self.on_forks))
        return float(min(carried.min(), clearances(replace(area, truck=bare), poses).min()))

    def _arrived(self, goal: Array, drive: TruckDrive) -> TruckDrive:
        """Raise ActionError unless the truck believes to be where a drive was to lead."""
        off = deviation(self.true, goal)
        drive.figures.update(off_m=off.distance, turned_rad=off.turn)
        if not is_near(self.believed, goal):
            far = deviation(self.believed, goal).distance
            raise ActionError(f"the truck believes to stand {far:.3f} m beside its goal", drive.figures)
        return drive


def deviation(at: Array, wanted: Array) -> FloorDeviation:
    """Return how far something is from where it should be.

    Args:
        at: (3,) m, m, rad.
        wanted: (3,) m, m, rad.

    Returns:
        The deviation.
    """
    off = seen_from(wanted, at)
    return FloorDeviation(float(np.hypot(*off[:2])), abs(float(wrapped(off[2:])[0])))


def is_near(at: Array, wanted: Array) -> bool:
    """Tell whether a truck has arrived.

    Args:
        at: (3,) m, m, rad: where it is.
        wanted: (3,) m, m, rad: its goal.

    Returns:
        True within ``NEAR``.
    """
    off = deviation(at, wanted)
    return off.distance <= NEAR[0] and off.turn <= NEAR[1]


def _plan_leaving(area: DrivingArea, pallet: StatedPallet) -> DrivePlan:
    """Plan a drive from in, or right before, a pallet that was set down, or from farther off past it."""
    past = replace(area, boxes=(*area.boxes, pallet.footprint))
    is_out = clearances(past, area.start[None])[0, -1] >= area.margin
    return plan_drive(past) if is_out else plan_exit(area, pallet)


def _planned(plan: Callable[[], DrivePlan]) -> DrivePlan:
    try:
        return plan()
    except (InputError, NoPlanError) as error:
        raise ActionError(str(error)) from None


def _really_off(stated: StatedPallet, seed: int) -> StatedPallet:
    """The pallet as the commission states it, or anywhere within the tolerance if it says nothing."""
    if stated.off.any():
        return stated
    off = derived_rng("pallet", seed).uniform(-1.0, 1.0, 3) * stated.tolerance
    return replace(stated, off=off)


def _outcome(watch: PeopleWatch | None) -> WatchedOutcome | None:
    """What a watch saw, if there was one."""
    return None if watch is None else watch.outcome()


def _felt(run: FollowedDrives, truck: Tricycle, x: float) -> Array:
    """(T, 2) m/s^2: accelerations of a point (x, 0) of the truck in its frame, as speeds are commanded."""
    poses, steering = run.poses[:, 0], run.steering[:, 0]
    moved = np.diff(poses[:, :2], axis=0, prepend=poses[:1, :2])
    forwards = np.sign(moved[:, 0] * np.cos(poses[:, 2]) + moved[:, 1] * np.sin(poses[:, 2]))
    speed = forwards * run.speeds[:, 0]
    along, yaw_rate = speed * np.cos(steering), speed * np.sin(steering) / truck.wheel_base
    gain, turn = np.gradient(along, PERIOD), np.gradient(yaw_rate, PERIOD)
    return np.column_stack([gain - yaw_rate**2 * x, along * yaw_rate + turn * x])
