"""First stretches of a lift: short displacements of an item that end all its contacts.

They are sampled at random; if hardly any of those is free (a mailer between two walls), a search climbs to
one.
"""

from __future__ import annotations

import numpy as np

from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.geometry import Array

# Largest sampled displacements: m along the entry's axes; rad of yaw, pitch and roll.
MOST_DRAWN = np.array([0.04, 0.03, 0.045, 0.15, 0.1, 0.3])
N_SAMPLES = 4000
N_LEAVING = 100  # samples with a free end, of which the start is checked
N_DRAWN = 8

MOST_CLIMBED = 1.5 * MOST_DRAWN
CLIMBS, ROUNDS = 6, 10
N_TRIED, N_KEPT = 60, 8  # samples of a round, and the best of them, around which the next are drawn
N_CHECKED = 3  # of these whose start is checked: the others are much alike
LEAST_SPREAD = 1e-4  # m or rad around those
MAX_MISSING_CLEARANCE = 0.02  # m of clearance that may be missing half-way through a climb
MAX_FAILED_CLIMBS = 2  # that reach no free displacement; in 16 new scenes no search succeeded after two


def drawn(
    leaving: FreeItemChecker, carrying: FreeItemChecker, max_length: float, rng: np.random.Generator
) -> list[Array]:
    """Sample first stretches at random.

    Args:
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        max_length: m, of the first stretch.
        rng: Source of the samples.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing; [] if none was found.
    """
    D = rng.uniform(-1.0, 1.0, size=(N_SAMPLES, 6)) * MOST_DRAWN
    D[:, 2] = np.abs(D[:, 2])
    D[::2, 5] = 0.0
    D = D[np.linalg.norm(D[:, :3], axis=1) <= max_length]
    found: list[Array] = []
    for d in D[carrying.are_valid(D)][:N_LEAVING]:
        if _leads(leaving, d):
            found.append(d)
        if len(found) == N_DRAWN:
            break
    return found


def climbed(
    leaving: FreeItemChecker, carrying: FreeItemChecker, max_length: float, rng: np.random.Generator
) -> list[Array]:
    """Find first stretches by climbing to displacements with the largest clearance.

    Source: the cross-entropy method, R. Rubinstein, D. Kroese (2004): sample, keep the best, sample around
        those.

    Args:
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        max_length: m, of the first stretch.
        rng: Source of the samples.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing; [] if none was found.
    """
    found: list[Array] = []
    n_failed = 0
    for _ in range(CLIMBS):
        mean, spread = MOST_CLIMBED * (0.0, 0.0, 0.33, 0.0, 0.0, 0.0), MOST_CLIMBED / 1.5
        for k in range(ROUNDS):
            D = _within(mean + spread * rng.standard_normal((N_TRIED, 6)), max_length)
            best, clearances = carrying.clearest(D, N_KEPT)
            free = D[best][carrying.are_valid(D[best])]
            if (d := next((d for d in free[:N_CHECKED] if _leads(leaving, d)), None)) is not None:
                found.append(d)
                break
            if k == ROUNDS // 2 and clearances[0] < carrying.margin - MAX_MISSING_CLEARANCE:
                return found
            mean, spread = D[best].mean(axis=0), D[best].std(axis=0) + LEAST_SPREAD
        else:
            n_failed += bool(clearances[0] < carrying.margin)
        if n_failed == MAX_FAILED_CLIMBS:
            return found
    return found


def _leads(leaving: FreeItemChecker, d: Array) -> bool:
    """Whether the straight line to a displacement (6,) is proven free."""
    return leaving.is_valid_path(np.stack([np.zeros(6), d]))


def _within(D: Array, max_length: float) -> Array:
    """Clip displacements (N, 6) to the range of the climb and to ``max_length`` m; none goes down."""
    D = np.clip(D, -MOST_CLIMBED, MOST_CLIMBED)
    D[:, 2] = np.maximum(D[:, 2], 0.0)
    D[:, :3] *= (max_length / np.maximum(np.linalg.norm(D[:, :3], axis=1), max_length))[:, None]
    return D
