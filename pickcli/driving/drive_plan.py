"""Plans a drive: a path on the lattice, smoothed, with a straight end, proven free and timed."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.driving.drive_smoothing import smooth_path
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.free_space_proof import Encounter, clearances, first_encounter
from pickcli.driving.lattice_search import LatticePath, LatticeSearch
from pickcli.driving.speed_profile import SpeedProfile, speed_profile
from pickcli.driving.state_lattice import StateLattice
from pickcli.driving.steering_path import SteeringPath, posed, seen_from
from pickcli.errors import InputError, NoPlanError, Reason

AT_GOAL = 1e-3  # m and rad of start and goal, below which there is nothing to drive
SEEN_STEP = 0.02  # m of travel between poses whose clearance is told

_log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class DrivePlan:
    """A drive that is proven to keep the margin of its area all along.

    Attributes:
        area: What it was planned for.
        lattice: The path of the lattice that it was made from, without the straight end.
        path: The path from start to goal.
        profile: Speeds along it.
    """

    area: DrivingArea
    lattice: LatticePath
    path: SteeringPath
    profile: SpeedProfile

    @cached_property
    def clearance(self) -> float:
        """M: least distance from walls and boxes, at samples; all along it is at least the margin."""
        n = int(np.ceil(self.path.length / SEEN_STEP)) + 1
        return float(clearances(self.area, self.path.poses_at(np.linspace(0, self.path.length, n))).min())


def plan_drive(area: DrivingArea) -> DrivePlan:
    """Plan a drive in an area.

    Args:
        area: The area; start and goal keep its margin.

    Returns:
        The drive.

    Raises:
        InputError: The truck is at the goal already.
        NoPlanError: The straight end is not free, the lattice has no path, or none is proven to be free.
    """
    if np.abs(seen_from(area.goal, area.start)).max() < AT_GOAL:
        raise InputError("the truck is at the goal already; state another start or another goal")
    before_end = posed(area.goal, np.array([-area.straight, 0.0, 0.0]))
    end = None
    if area.straight:
        end = SteeringPath(area.truck, before_end, np.array([area.straight]), np.zeros(2))
        if (met := first_encounter(area, end, area.margin)) is not None:
            reason = Reason("not free", "the straight end", _detail(met, area))
            raise NoPlanError("a drive to the goal", [reason])
    lattice = StateLattice(area, before_end)
    search = LatticeSearch(lattice, area.start)
    found = search.run()
    if found is None:
        raise NoPlanError("a drive to the goal", [_reason(area, search)])
    _log.info("lattice: %.2f m after %d states", found.path.length, found.n_expanded)
    unproven: list[Reason] = []
    for path in (smooth_path(lattice, found.path), found.path):
        if path is None:
            continue
        whole = path if end is None else path.then(end)
        met = first_encounter(area, whole, area.margin)
        if met is None:
            return DrivePlan(area, found, whole, speed_profile(whole))
        unproven.append(Reason("not free", "the path", _detail(met, area)))
    raise NoPlanError("a drive to the goal", unproven)


def _detail(met: Encounter, area: DrivingArea) -> str:
    return f"{met.clearance:.3f} m from {met.name}, {area.margin:g} m are to be kept"


def _reason(area: DrivingArea, search: LatticeSearch) -> Reason:
    kept = f"with a margin of {area.margin:g} m"
    if not search.n_out:
        return Reason("no edge out of the start is free", "lattice", kept)
    if not search.n_expanded:
        return Reason("walls and boxes part start and goal", "lattice", kept)
    what = "given up" if search.queue else "no path"
    return Reason(what, "lattice", f"{search.n_expanded} states reached, {kept}")
