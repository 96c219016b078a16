"""Corridors with corners: planned for the item by itself where no simple one is free.

Still nothing but straight pushes inside the bin (KTH, section IV-A.2), but which ones RRT-Connect finds, in
the six dimensions in which an item that hangs on a cup is pushed: along the bin's axes, yaw, pitch and roll.
"""

from __future__ import annotations

from collections.abc import Sequence

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
from pickcli.planning.stages.lift_sampling import climbed, drawn

NAMES = ("x", "y", "z", "yaw", "pitch", "roll")
LOWER = np.array([-0.8, -0.15, -0.1, -0.5, -0.15, -1.7])  # m and rad, bounds of the pushes
UPPER = np.array([0.04, 0.15, 0.2, 0.5, 0.15, 1.7])
# How far each goes in the time of a metre: weighs the pushes. Roll turns nothing but the wrist.
SPEED = np.array([1.0, 1.0, 1.0, 3.0, 3.0, 6.0])
ROLLS = (0.0, np.pi / 2, -np.pi / 2)  # in which the item may come out
SHORTCUTS = 60
N_FINE = 3  # of the drawn first stretches, from which a narrow way is looked for
MOST_PUSHES = 5  # more turns than that are no line of a tool any more


COARSE = PlannerOptions(max_iterations=1500, step=0.1)
# What hardly fits through the mouth goes by short edges only; of 14 fresh scenes no pick took more than 2000.
FINE = PlannerOptions(max_iterations=4000, step=0.01)


def planned_corridors(
    T_bin_item: Array,
    shape: Shape,
    leaving: FreeItemChecker,
    carrying: FreeItemChecker,
    first: float,
    seed: int,
) -> tuple[Corridor, ...]:
    """Find corridors by RRT-Connect from several first stretches.

    Args:
        T_bin_item: (4, 4) item in the frame of the way into the place.
        shape: Shape of the item, grown by its uncertainty.
        leaving: The item where it may touch what it rests on.
        carrying: The item where it may touch nothing.
        first: m, length of the stretch in which touching is allowed.
        seed: Seed of all random choices: equal arguments give equal corridors.

    Returns:
        The corridors, shortest first; () if none was found.
    """
    goals = _outside(T_bin_item, shape, carrying)
    if len(goals) == 0:
        return ()
    rng = np.random.default_rng(seed)
    starts = drawn(leaving, carrying, first, rng)
    found = _through(carrying, starts, goals, COARSE, seed)
    if not found:
        starts = [*starts[:N_FINE], *climbed(leaving, carrying, first, rng)]
        found = _through(carrying, starts, goals, FINE, seed)
    return found


def _through(
    carrying: FreeItemChecker, starts: Sequence[Array], goals: Array, search: PlannerOptions, seed: int
) -> tuple[Corridor, ...]:
    """Corridors from the ends of first stretches (6,) to places outside (G, 6), shortest first."""
    space = JointSpace(NAMES, LOWER, UPPER, SPEED, SPEED)
    found: list[tuple[float, Corridor]] = []
    for k, first_stretch in enumerate(starts):
        path = plan(carrying, space, first_stretch, goals, seed=seed + k, options=search)
        if path is None:
            continue
        short = shorten(carrying, space, path, seed=seed + k, iterations=SHORTCUTS)
        if len(short.waypoints) <= MOST_PUSHES + 1:
            found.append((_length(short), Corridor(first_stretch, first_stretch, tuple(short.waypoints[1:]))))
    return tuple(corridor for _, corridor in sorted(found, key=lambda f: f[0]))


def _outside(T_bin_item: Array, shape: Shape, carrying: FreeItemChecker) -> Array:
    """(G, 6) places in front of the mouth, at several heights, where the whole item is outside."""
    reach = float(np.linalg.norm(shape.reach(T_bin_item[:3, :3])[:2]))
    x = -float(T_bin_item[0, 3]) - reach - RETREAT_DISTANCE
    heights, aside = (0.04, 0.08, 0.12, 0.0, -0.04), (0.0, 0.05, -0.05)
    places = np.array([[x, y, z, 0.0, 0.0, roll] for roll in ROLLS for z in heights for y in aside])
    return places[carrying.are_valid(places)] if x >= LOWER[0] else np.zeros((0, len(NAMES)))


def _length(path: JointPath) -> float:
    return float(np.abs(np.diff(path.waypoints, axis=0) / SPEED).sum())
