"""First stretches of a lift: short displacements of an item that end all its contacts.

They are sampled at random; if hardly any of those is free (a mailer between two walls), a search climbs to
one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.geometry import Array

N_SAMPLES = 4000
N_LEAVING = 100  # samples with a free end, of which the start is checked
N_DRAWN = 8

CLIMB_SHARE = 1.5  # of the largest sampled displacement, for a climb
FIRST_RISE = 0.33  # of the largest, about which a climb begins
CLIMBS, ROUNDS = 6, 10
N_TRIED, N_KEPT = 60, 8  # samples of a round, and the best of them, around which the next are drawn
N_CHECKED = 3  # of these whose start is checked: the others are much alike
LEAST_SPREAD = 1e-4  # m or rad around those
MAX_MISSING_CLEARANCE = 0.02  # m of clearance that may be missing half-way through a climb
MAX_FAILED_CLIMBS = 2  # that reach no free displacement; in 16 new scenes no search succeeded after two


@dataclass(frozen=True, eq=False)
class LiftSpace:
    """Displacements among which first stretches are sampled.

    Attributes:
        most: (6,) the largest: m along the entry's axes; rad of yaw, pitch and roll.
        up: (3,) unit vector along one of the entry's axes, against gravity.
    """

    most: Array
    up: Array

    def risen(self, D: Array, rises: Array) -> Array:
        """Return displacements (N, 6) with other heights.

        Args:
            D: (N, 6) displacements.
            rises: (N,) m, their heights afterwards.

        Returns:
            The displacements (N, 6).
        """
        moved = D.copy()
        moved[:, :3] += np.outer(rises - self.heights(D), self.up)
        return moved

    def heights(self, D: Array) -> Array:
        """Return the heights (N,) in m of displacements.

        Args:
            D: (N, 6) displacements.

        Returns:
            The heights.
        """
        return np.asarray(D[:, :3] @ self.up)


IN_SHELF = LiftSpace(np.array([0.04, 0.03, 0.045, 0.15, 0.1, 0.3]), np.array([0.0, 0.0, 1.0]))
IN_OPEN_BOX = LiftSpace(np.array([0.045, 0.04, 0.04, 0.15, 0.15, 0.3]), np.array([-1.0, 0.0, 0.0]))


def drawn(
    leaving: FreeItemChecker,
    carrying: FreeItemChecker,
    within: LiftSpace,
    max_length: float,
    rng: np.random.Generator,
) -> list[Array]:
    """Sample first stretches at random.

    Args:
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        within: Space of the displacements.
        max_length: m, of the first stretch.
        rng: Source of the samples.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing; [] if none was found.
    """
    D = rng.uniform(-1.0, 1.0, size=(N_SAMPLES, 6)) * within.most
    D = within.risen(D, np.abs(within.heights(D)))
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
    leaving: FreeItemChecker,
    carrying: FreeItemChecker,
    within: LiftSpace,
    max_length: float,
    rng: np.random.Generator,
) -> list[Array]:
    """Find first stretches by climbing to displacements with the largest clearance.

    Source: the cross-entropy method, R. Rubinstein, D. Kroese (2004): sample, keep the best, sample around
        those.

    Args:
        leaving: Checker of the item while it may touch its support.
        carrying: Checker of the item when it may touch nothing.
        within: Space of the displacements.
        max_length: m, of the first stretch.
        rng: Source of the samples.

    Returns:
        Displacements (6,), in m and rad, after which the item touches nothing; [] if none was found.
    """
    found: list[Array] = []
    n_failed, most = 0, CLIMB_SHARE * within.most
    rise = FIRST_RISE * float(most[:3] @ np.abs(within.up))
    for _ in range(CLIMBS):
        mean, spread = np.append(rise * within.up, np.zeros(3)), most / 1.5
        for k in range(ROUNDS):
            D = _clipped(mean + spread * rng.standard_normal((N_TRIED, 6)), within, max_length)
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


def _clipped(D: Array, within: LiftSpace, max_length: float) -> Array:
    """Clip displacements (N, 6) to the range of the climb and to ``max_length`` m; none goes down."""
    most = CLIMB_SHARE * within.most
    D = np.clip(D, -most, most)
    D = within.risen(D, np.maximum(within.heights(D), 0.0))
    D[:, :3] *= (max_length / np.maximum(np.linalg.norm(D[:, :3], axis=1), max_length))[:, None]
    return D
