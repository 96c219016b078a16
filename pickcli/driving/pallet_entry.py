"""Drives into a pallet: an approach on the lattice, then straight into the pockets.

The approach keeps away from the pallet as from any box. Of the straight part, which is long enough for the
controller to come to rest across it, the forks are proven to fit the pockets, and the body of the truck to
keep its margin from pallet and load.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.drive_smoothing import smooth_path
from pickcli.driving.driving_area import DrivingArea, StatedPallet
from pickcli.driving.free_space_proof import clearances, first_encounter
from pickcli.driving.speed_profile import speed_profile
from pickcli.driving.state_lattice import StateLattice
from pickcli.driving.steering_path import SteeringPath, posed, seen_from
from pickcli.errors import InputError, NoPlanError, Reason
from pickcli.geometry import Array

INSET = 0.05  # m from the tips of the forks to the far side of a pallet, at least
HEEL_GAP = 0.01  # m beyond the margin, from their heels to its near side
RUN_UP = 0.4  # m before the pallet, in which the tips go straight already
LEAST_STRAIGHT = 1.0  # m
FORK_GAP = 0.02  # m beside and above the forks in the pockets, at least
BACK_OUT = 1.2  # m that a truck drives away from a pallet before it tries again
LEAST_OUT = 0.02  # m of a drive out of a pallet that go straight
N_AWAY = 60  # poses on that way, at which the forks are to be free of the sides of pockets
N_ALONG = 8  # points along the side of a fork, at which its distance from a pocket is taken
LEAST_REST = 0.4  # m of the approach that is left to be changed
# m that a truck drives straight on out of a pallet, from each of which a way onward is looked for in turn:
# on a lattice it may hang on where between its cells a way begins
FARTHER = (0.0, 0.03, 0.07, 0.12, 0.17)


def entered_pose(area: DrivingArea, pallet: StatedPallet) -> Array:
    """Return the pose of the truck with its forks all in a pallet.

    Args:
        area: The area.
        pallet: The pallet.

    Returns:
        (3,) m, m, rad.
    """
    return posed(
        pallet.pose, np.array([pallet.shape.length / 2 - entry_depth(area, pallet) + area.truck.back, 0, 0])
    )


def straight_length(area: DrivingArea, pallet: StatedPallet) -> float:
    """Return how far a truck drives straight into a pallet.

    Args:
        area: The area.
        pallet: The pallet.

    Returns:
        m.
    """
    return max(LEAST_STRAIGHT, entry_depth(area, pallet) + RUN_UP)


def entry_depth(area: DrivingArea, pallet: StatedPallet) -> float:
    """Return how far forks go into a pallet.

    Args:
        area: The area.
        pallet: The pallet.

    Returns:
        m from its near side to the tips.
    """
    return min(pallet.shape.length - INSET, area.forks.length - area.margin - HEEL_GAP)


def plan_in_area(area: DrivingArea) -> DrivePlan:
    """Plan the drive that an area asks for: to its goal past the pallet that is expected, or into that.

    Args:
        area: The area.

    Returns:
        The drive.

    Raises:
        InputError: The truck is at the goal already, or its forks do not fit the pallet.
        NoPlanError: There is no way.
    """
    if area.pallet is None:
        return plan_drive(area)
    if area.enters:
        return plan_entry(area, area.pallet)
    return plan_drive(replace(area, boxes=(*area.boxes, area.pallet.footprint)))


def plan_entry(area: DrivingArea, pallet: StatedPallet) -> DrivePlan:
    """Plan a drive into a pallet.

    Args:
        area: The area; its goal does not matter.
        pallet: The pallet, where it is believed to stand.

    Returns:
        The drive.

    Raises:
        InputError: The forks do not fit its pockets.
        NoPlanError: There is no way to it, or into it.
    """
    _refuse_forks(area, pallet)
    end = _end(area, pallet)
    approach = plan_drive(_approached(area, pallet, end.start))
    return _joined(area, pallet, approach, approach.path, end)


def plan_entry_anew(area: DrivingArea, pallet: StatedPallet) -> DrivePlan:
    """Plan a drive into a pallet from right before it: first straight away from it, if there is room.

    Without that a path is short and has many cusps, on which a controller cannot follow it well.

    Args:
        area: The area, in which the truck starts before the pallet.
        pallet: The pallet, where it is believed to stand.

    Returns:
        The drive.

    Raises:
        InputError: The forks do not fit its pockets.
        NoPlanError: There is no way to it, or into it.
    """
    away = SteeringPath(area.truck, area.start, np.array([BACK_OUT]), np.zeros(2))
    try:
        # A truck that braked late stands within the margin of the pallet, or with its tips in the pockets.
        _prove_straight(area, pallet, away, "a drive away from the pallet")
    except NoPlanError:
        return plan_entry(area, pallet)
    if pallet_gap(area, pallet, away.poses_at(np.linspace(0.0, away.length, N_AWAY))) <= 0.0:
        return plan_entry(area, pallet)
    try:
        plan = plan_entry(replace(area, start=away.end), pallet)
    except NoPlanError:
        return plan_entry(area, pallet)
    path = away.then(plan.path)
    return replace(plan, area=replace(plan.area, start=area.start), path=path, profile=speed_profile(path))


def plan_exit(area: DrivingArea, pallet: StatedPallet) -> DrivePlan:
    """Plan a drive out of a pallet that stands on the floor: straight until the forks are out, then on.

    Args:
        area: The area, in which the truck starts with its forks in the pallet, all of them or their tips.
        pallet: The pallet, where it is believed to stand.

    Returns:
        The drive to the goal of the area.

    Raises:
        InputError: The goal is where the forks are out already.
        NoPlanError: There is no way out of it, or from there to the goal.
    """
    failed: list[NoPlanError] = []
    is_out = float(seen_from(entered_pose(area, pallet), area.start)[0])  # m of the way, on a second drive
    left = max(LEAST_OUT, straight_length(area, pallet) - is_out)
    for more in FARTHER:
        length = left + more
        out = SteeringPath(area.truck, area.start, np.array([length]), np.zeros(2))
        try:
            _prove_straight(area, pallet, out, "a drive out of the pallet")
            onward = plan_drive(_passed(area, pallet, out.end))
        except NoPlanError as error:
            failed.append(error)
            continue
        path = out.then(onward.path)
        return DrivePlan(replace(area, boxes=onward.area.boxes), onward.lattice, path, speed_profile(path))
    raise failed[0]


def _passed(area: DrivingArea, pallet: StatedPallet, start: Array) -> DrivingArea:
    return replace(area, boxes=(*area.boxes, pallet.footprint), start=start, pallet=None, enters=False)


def pallet_gap(area: DrivingArea, pallet: StatedPallet, poses: Array) -> float:
    """Return the least distance of a truck from a pallet into which its forks go.

    Args:
        area: The area.
        pallet: The pallet, where it truly stands.
        poses: (N, 3) m, m, rad: true poses of the truck.

    Returns:
        m: of the forks in it from the sides of its pockets, and of the truck's body from it; not over 0 if
        one of them meets it.
    """
    heels = area.forks.length - area.truck.back
    body = replace(area, truck=replace(area.truck, back=-heels), boxes=(pallet.footprint,))
    return min(_pocket_gap(area, pallet, poses), float(clearances(body, poses)[:, 1].min()))


def _pocket_gap(area: DrivingArea, pallet: StatedPallet, poses: Array) -> float:
    """Distance (m) of forks from the sides of their pockets, negative if one meets a side, or infinite."""
    forks, back = area.forks, area.truck.back
    edges = forks.aside + np.array([-0.5, 0.5]) * forks.width
    along = np.linspace(-back, forks.length - back, N_ALONG)
    points = np.array([(x, y, 0.0) for x in along for y in (*-edges, *edges)])
    at = seen_from(pallet.pose, posed(poses[:, None], points))
    side = pallet.shape.pockets[(points[:, 1] > 0.0).astype(int)]
    gaps = np.minimum(at[..., 1] - side[:, 0], side[:, 1] - at[..., 1])
    half = np.array([pallet.shape.length, pallet.shape.width]) / 2
    inside = (np.abs(at[..., :2]) <= half).all(axis=-1)
    return float(gaps[inside].min(initial=np.inf))


def renewed_entry(plan: DrivePlan, travel: float, pallet: StatedPallet) -> DrivePlan | None:
    """Change a drive into a pallet while it is driven, as the pallet is seen elsewhere.

    Args:
        plan: The drive.
        travel: m from its start, up to which it stays as it is.
        pallet: The pallet, where it is seen.

    Returns:
        The drive, with the same steering there; None if too little is left to be changed, or no path that is
        like it is proven to be free.
    """
    until = plan.path.length - abs(plan.area.straight)
    if until - travel < LEAST_REST:
        return None
    driven, rest = plan.path.divided(until)[0].divided(travel)
    try:
        end = _end(plan.area, pallet)
    except NoPlanError:
        return None
    area = replace(_approached(plan.area, pallet, end.start), start=rest.start)
    smooth = smooth_path(StateLattice(area, end.start), rest)
    return None if smooth is None else _joined(plan.area, pallet, plan, driven.then(smooth), end)


def _approached(area: DrivingArea, pallet: StatedPallet, goal: Array) -> DrivingArea:
    return replace(area, boxes=(*area.boxes, pallet.footprint), goal=goal, straight=0.0)


def _joined(
    area: DrivingArea, pallet: StatedPallet, of: DrivePlan, approach: SteeringPath, end: SteeringPath
) -> DrivePlan:
    path = approach.then(end)
    inside = replace(
        area, goal=entered_pose(area, pallet), straight=-straight_length(area, pallet), pallet=pallet
    )
    return DrivePlan(inside, of.lattice, path, speed_profile(path))


def _end(area: DrivingArea, pallet: StatedPallet) -> SteeringPath:
    """The straight part, proven."""
    inside, straight = entered_pose(area, pallet), straight_length(area, pallet)
    start = posed(inside, np.array([straight, 0.0, 0.0]))
    end = SteeringPath(area.truck, start, np.array([-straight]), np.zeros(2))
    _prove_straight(area, pallet, end, "a drive into the pallet")
    return end


def _prove_straight(area: DrivingArea, pallet: StatedPallet, path: SteeringPath, what: str) -> None:
    """Raise NoPlanError unless forks are free of all but the pallet, and the truck's body of that, too."""
    heels = area.forks.length - area.truck.back
    forks = replace(area.truck, front=heels, width=2 * area.forks.aside + area.forks.width)
    body = replace(area.truck, back=-heels)
    for part in (
        replace(area, truck=forks), replace(area, truck=body, boxes=(*area.boxes, pallet.footprint)),
    ):  # fmt: skip
        if (met := first_encounter(part, path, area.margin)) is not None:
            detail = f"{met.clearance:.3f} m from {met.name}, {area.margin:g} m are to be kept"
            raise NoPlanError(what, [Reason("not free", "the straight part", detail)])


def _refuse_forks(area: DrivingArea, pallet: StatedPallet) -> None:
    forks, shape = area.forks, pallet.shape
    outer, inner = forks.aside + forks.width / 2, forks.aside - forks.width / 2
    least, most = shape.pockets[1]
    if inner - FORK_GAP < least or outer + FORK_GAP > most:
        raise InputError(
            f"the forks, {inner:.3f} to {outer:.3f} m from the middle, do not fit the pockets of a "
            f"{shape.name} pallet, {least:.3f} to {most:.3f} m, with {FORK_GAP:g} m beside; state others"
        )
    if forks.height + FORK_GAP / 2 > shape.opening:
        raise InputError(
            f"the forks, {forks.height:g} m high, do not fit the pockets, {shape.opening:g} m; "
            "state lower ones"
        )
