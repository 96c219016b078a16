"""First stretches: short ways of an item by itself, away from all that it touches where it lies.

Drawn at random; where hardly any of those ends free (a mailer between two walls), climbed to.
"""

from __future__ import annotations

import numpy as np

from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.geometry import Array

# Largest displacements that are drawn: m along the bin's axes; rad of yaw, pitch and roll.
MOST_DRAWN = np.array([0.04, 0.03, 0.045, 0.15, 0.1, 0.3])
N_SAMPLES = 4000
N_LEAVING = 100  # of those that end free, of which it is asked whether they begin so
N_DRAWN = 8

MOST_CLIMBED = 1.5 * MOST_DRAWN
CLIMBS, ROUNDS = 6, 10
N_TRIED, N_KEPT = 60, 8  # displacements of a round, and the best of them, around which the next ones lie
N_PUSHED = 3  # of these, of which it is asked whether they begin free: the others are much alike
LEAST_SPREAD = 1e-4  # m or rad around those
HOPELESS = 0.02  # m of room that may be missing half-way through a climb


def drawn(
    leaving: FreeItemChecker, carrying: FreeItemChecker, first: float, rng: np.random.Generator
) -> list[Array]:
    """Draw first stretches at random.

    Args:
        leaving: The item while it may touch what it rests on.
        carrying: The item when it may touch nothing any more.
        first: m, most length of the first stretch.
        rng: Source of the draws.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing any more; [] if none was found.
    """
    D = rng.uniform(-1.0, 1.0, size=(N_SAMPLES, 6)) * MOST_DRAWN
    D[:, 2] = np.abs(D[:, 2])
    D[::2, 5] = 0.0
    D = D[np.linalg.norm(D[:, :3], axis=1) <= first]
    found: list[Array] = []
    for d in D[carrying.are_valid(D)][:N_LEAVING]:
        if _leads(leaving, d):
            found.append(d)
        if len(found) == N_DRAWN:
            break
    return found


def climbed(
    leaving: FreeItemChecker, carrying: FreeItemChecker, first: float, rng: np.random.Generator
) -> list[Array]:
    """Find first stretches by climbing to where the item has more room than anywhere around.

    Source: the cross-entropy method, R. Rubinstein, D. Kroese (2004): draw, keep the best, draw around those.

    Args:
        leaving: The item while it may touch what it rests on.
        carrying: The item when it may touch nothing any more.
        first: m, most length of the first stretch.
        rng: Source of the draws.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing any more; [] if none was found.
    """
    found: list[Array] = []
    for _ in range(CLIMBS):
        mean, spread = MOST_CLIMBED * (0.0, 0.0, 0.33, 0.0, 0.0, 0.0), MOST_CLIMBED / 1.5
        for k in range(ROUNDS):
            D = _within(mean + spread * rng.standard_normal((N_TRIED, 6)), first)
            room = carrying.clearances(D)
            best = np.argsort(-room, kind="stable")[:N_KEPT]
            free = D[best][carrying.are_valid(D[best])]
            if (d := next((d for d in free[:N_PUSHED] if _leads(leaving, d)), None)) is not None:
                found.append(d)
                break
            if k == ROUNDS // 2 and room[best[0]] < carrying.margin - HOPELESS:
                return found
            mean, spread = D[best].mean(axis=0), D[best].std(axis=0) + LEAST_SPREAD
    return found


def _leads(leaving: FreeItemChecker, d: Array) -> bool:
    """Whether the straight push to a displacement (6,) is proven."""
    return leaving.is_valid_path(np.stack([np.zeros(6), d]))


def _within(D: Array, first: float) -> Array:
    """Displacements (N, 6) brought within what may be climbed to, ``first`` m long at most; none sinks."""
    D = np.clip(D, -MOST_CLIMBED, MOST_CLIMBED)
    D[:, 2] = np.maximum(D[:, 2], 0.0)
    D[:, :3] *= (first / np.maximum(np.linalg.norm(D[:, :3], axis=1), first))[:, None]
    return D
