"""Planned corridors with several turns, for an item as a free flyer, if no simple corridor is free.

They consist of straight lines inside the bin (KTH, section IV-A.2), found by RRT-Connect in the six
dimensions in which an item on a cup is moved: along the entry's axes, yaw, pitch and roll.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from pickcli.cartesian.corridor import RETREAT_DISTANCE, Corridor
from pickcli.cell.shapes import Shape
from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.path_planning.state_space import JointSpace
from pickcli.planning.stages.lift_sampling import IN_OPEN_BOX, IN_SHELF, LiftSpace, climbed, drawn

NAMES = ("x", "y", "z", "yaw", "pitch", "roll")
# Weights of the displacements: distance of each in the time of a metre. Roll turns only the wrist.
SPEED = np.array([1.0, 1.0, 1.0, 3.0, 3.0, 6.0])
ROLLS = (0.0, np.pi / 2, -np.pi / 2)  # orientations in which the item may come out
SHORTCUTS = 60
N_FINE = 3  # of the sampled starts, from which a narrow way is searched
MAX_LINES = 5  # lines of the tool in one retreat; a retreat with more is rejected


@dataclass(frozen=True, eq=False)
class ExtractionSpace:
    """Displacements among which ways out of one kind of place are planned.

    Attributes:
        lower: (6,) the least: m along the entry's axes; rad of yaw, pitch and roll.
        upper: (6,) the largest.
        first: Space of the first stretches.
        aside: (K, 2) m along the entry's y and z, of the places outside that are tried, in this order.
    """

    lower: Array
    upper: Array
    first: LiftSpace
    aside: Array


OUT_OF_SHELF = ExtractionSpace(
    np.array([-0.8, -0.15, -0.1, -0.5, -0.15, -1.7]),
    np.array([0.04, 0.15, 0.2, 0.5, 0.15, 1.7]),
    IN_SHELF,
    np.array([(y, z) for z in (0.04, 0.08, 0.12, 0.0, -0.04) for y in (0.0, 0.05, -0.05)]),
)
# Nothing covers an open box: the item may turn as far about both level axes, and leave it beside the rim.
OUT_OF_OPEN_BOX = ExtractionSpace(
    np.array([-0.8, -0.25, -0.25, -0.5, -0.5, -1.7]),
    np.array([0.04, 0.25, 0.25, 0.5, 0.5, 1.7]),
    IN_OPEN_BOX,
    np.array([*product((0.0, 0.08, -0.08), repeat=2)]),
)

COARSE_SEARCH = PlannerOptions(max_iterations=1500, step=0.1)
# An item that hardly fits through the mouth needs short edges; in 14 new scenes no pick took more than 2000.
FINE_SEARCH = PlannerOptions(max_iterations=4000, step=0.01)


def planned_corridors(
    ways: ExtractionSpace,
    T_entry_item: Array,
    shape: Shape,
    leaving: FreeItemChecker,
    carrying: FreeItemChecker,
    max_length: float,
    seed: int,
) -> tuple[Corridor, ...]:
    """Find corridors by RRT-Connect from several first stretches.

    Args:
        ways: Displacements among which ways out are planned.
        T_entry_item: (4, 4) pose of the item in the entry frame of the place.
        shape: Shape of the item, enlarged by its uncertainty.
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        max_length: m, of the first stretch, in which touching is allowed.
        seed: Seed of all random choices: equal arguments give equal corridors.

    Returns:
        The corridors, shortest first; () if none was found.
    """
    goals = _outside(ways, T_entry_item, shape, carrying)
    if len(goals) == 0:
        return ()
    rng = np.random.default_rng(seed)
    space = JointSpace(NAMES, ways.lower, ways.upper, SPEED, SPEED)
    starts = drawn(leaving, carrying, ways.first, max_length, rng)
    found = _through(carrying, space, starts, goals, COARSE_SEARCH, seed)
    if not found:
        starts = [*starts[:N_FINE], *climbed(leaving, carrying, ways.first, max_length, rng)]
        found = _through(carrying, space, starts, goals, FINE_SEARCH, seed)
    return found


def _through(
    carrying: FreeItemChecker,
    space: JointSpace,
    starts: Sequence[Array],
    goals: Array,
    search: PlannerOptions,
    seed: int,
) -> tuple[Corridor, ...]:
    """Plan corridors from the ends of first stretches (6,) to poses outside (G, 6), shortest first."""
    found: list[tuple[float, Corridor]] = []
    for k, start in enumerate(starts):
        path = plan(carrying, space, start, goals, seed=seed + k, options=search)
        if path is None:
            continue
        short = shorten(carrying, space, path, seed=seed + k, iterations=SHORTCUTS)
        if len(short.waypoints) <= MAX_LINES + 1:
            found.append((_length(short), Corridor(start, start, tuple(short.waypoints[1:]))))
    return tuple(corridor for _, corridor in sorted(found, key=lambda f: f[0]))


def _outside(ways: ExtractionSpace, T_entry_item: Array, shape: Shape, carrying: FreeItemChecker) -> Array:
    """Return (G, 6) free displacements in front of the mouth, with the whole item outside."""
    reach = float(np.linalg.norm(shape.reach(T_entry_item[:3, :3])[:2]))
    x = -float(T_entry_item[0, 3]) - reach - RETREAT_DISTANCE
    places = np.array([[x, y, z, 0.0, 0.0, roll] for roll in ROLLS for y, z in ways.aside])
    return places[carrying.are_valid(places)] if x >= ways.lower[0] else np.zeros((0, len(NAMES)))


def _length(path: JointPath) -> float:
    return float(np.abs(np.diff(path.waypoints, axis=0) / SPEED).sum())
