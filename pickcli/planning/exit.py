"""Corridors with corners: planned for the item by itself where no simple one is free.

Still nothing but straight pushes inside the bin (KTH, section IV-A.2), but which ones RRT-Connect finds, in
the five dimensions in which an item that hangs on a cup is pushed: along the bin's axes, yaw and pitch.
"""

from __future__ import annotations

import numpy as np

from pickcli.cartesian.corridor import RETREAT_DISTANCE, Corridor
from pickcli.cell.shapes import Shape
from pickcli.collision.ghost import Ghost
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.roadmap.sampling import plan
from pickcli.roadmap.shorten import shorten
from pickcli.roadmap.space import JointSpace

NAMES = ("x", "y", "z", "yaw", "pitch")
LOWER = np.array([-0.8, -0.15, 0.0, -0.5, -0.15])  # m and rad, bounds of the pushes
UPPER = np.array([0.02, 0.15, 0.2, 0.5, 0.15])
SPEED = np.array([1.0, 1.0, 1.0, 3.0, 3.0])  # how far each goes in the time of a metre: weighs the pushes
STARTS = np.array([0.04, 0.03, 0.045, 0.15, 0.1])  # largest displacements of the first stretch
N_SAMPLES = 1500  # of first stretches
N_STARTS = 3
ITERATIONS = 1500
SHORTCUTS = 60
MOST_PUSHES = 5  # more turns than that are no line of a tool any more


class _Item:
    """A ghost as the planner's checker."""

    def __init__(self, ghost: Ghost) -> None:
        self._ghost = ghost

    def is_free(self, q: Array) -> bool:
        return self._ghost.is_free(q)

    def edge_is_free(self, q0: Array, q1: Array) -> bool:
        return self._ghost.path_is_free(np.stack([q0, q1])) == -1

    def path_is_free(self, Q: Array) -> int:
        return self._ghost.path_is_free(Q)

    def explain(self, q: Array) -> Reason:
        return Reason("collision", "", str(self._ghost.clearance(q)))


def planned_corridors(
    T_bin_item: Array, shape: Shape, leaving: Ghost, carrying: Ghost, first: float, seed: int
) -> tuple[Corridor, ...]:
    """Corridors found by RRT-Connect from several first stretches, shortest first; () if none was.

    Arguments as of ``cartesian.corridor.corridors``. Same arguments, same corridors.
    """
    rng = np.random.default_rng(seed)
    checker = _Item(carrying)
    space = JointSpace(NAMES, LOWER, UPPER, SPEED, SPEED)
    goals = _outside(T_bin_item, shape, carrying)
    found: list[tuple[float, Corridor]] = []
    for k, freed in enumerate(_first_stretches(leaving, carrying, first, rng)):
        path = (
            None
            if len(goals) == 0
            else plan(checker, space, freed, goals, seed=seed + k, max_iterations=ITERATIONS)
        )
        if path is None:
            continue
        short = shorten(checker, space, path, seed=seed + k, iterations=SHORTCUTS)
        if len(short.waypoints) <= MOST_PUSHES + 1:
            found.append((_length(short), Corridor(freed, freed, tuple(short.waypoints[1:]))))
    return tuple(corridor for _, corridor in sorted(found, key=lambda f: f[0]))


def _outside(T_bin_item: Array, shape: Shape, carrying: Ghost) -> Array:
    """(G, 5) places in front of the mouth, at several heights, where the whole item is outside."""
    reach = float(np.linalg.norm(shape.reach(T_bin_item[:3, :3])[:2]))
    x = -float(T_bin_item[0, 3]) - reach - RETREAT_DISTANCE
    places = [np.array([x, y, z, 0.0, 0.0]) for z in (0.04, 0.08, 0.12) for y in (0.0, 0.05, -0.05)]
    free = [d for d in places if d[0] >= LOWER[0] and carrying.is_free(d)]
    return np.array(free).reshape(-1, 5)


def _first_stretches(leaving: Ghost, carrying: Ghost, first: float, rng: np.random.Generator) -> list[Array]:
    """Displacements no longer than ``first`` after which the item touches nothing any more."""
    found: list[Array] = []
    for d in rng.uniform(-1.0, 1.0, size=(N_SAMPLES, 5)) * STARTS:
        d[2] = abs(d[2])
        if np.linalg.norm(d[:3]) > first or not carrying.is_free(d):
            continue
        if leaving.path_is_free(np.stack([np.zeros(5), d])) == -1:
            found.append(d)
        if len(found) == N_STARTS:
            break
    return found


def _length(path: JointPath) -> float:
    return float(np.abs(np.diff(path.waypoints, axis=0) / SPEED).sum())
