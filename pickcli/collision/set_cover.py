"""Set cover over cells: few candidate spheres such that each cell lies inside one of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class CoverProblem:
    """Cells that partition one piece of a solid, and K spheres that may cover them.

    The piece is a fundamental domain of the solid's symmetry: spheres that cover it cover, together with all
    their mirror images or rotations, the solid.

    Attributes:
        depth: (K,) m, distance of each centre to the solid's surface.
        images: (K,) number of spheres of the final cover that one candidate stands for.
        farthest: (K, C) m, distance from each centre to the farthest point of each cell.
    """

    depth: Array
    images: Array
    farthest: Array


def solve_greedily(problem: CoverProblem, excess: float) -> tuple[NDArray[np.int64], Array] | None:
    """Choose few spheres such that each cell lies inside one of them.

    The radius of a candidate is at most its depth plus ``excess``, so no sphere reaches farther than
    ``excess`` out of the solid. Radii are then reduced to what the cells need.

    Args:
        problem: Cells and candidates.
        excess: m.

    Returns:
        (M,) indices of the chosen candidates and (M,) their radii in m; None if some cell stays uncovered.
    """
    covers = problem.farthest <= (problem.depth + excess)[:, None]
    if not covers.any(axis=0).all():
        return None
    chosen = _drop_superfluous(covers, _pick(covers, problem.images), problem.images)
    return chosen, _least_radii(problem, covers, chosen)


def _pick(covers: NDArray[np.bool_], images: Array) -> list[int]:
    gain = covers.sum(axis=1)
    is_open = np.ones(covers.shape[1], dtype=bool)
    chosen: list[int] = []
    while is_open.any():
        best = int(np.argmax(gain / images))
        newly = is_open & covers[best]
        gain = gain - covers[:, newly].sum(axis=1)
        is_open &= ~newly
        chosen.append(best)
    return chosen


def _drop_superfluous(covers: NDArray[np.bool_], chosen: list[int], images: Array) -> NDArray[np.int64]:
    """Drop spheres whose cells all lie inside others, the most expensive ones first."""
    count = covers[chosen].sum(axis=0)
    kept = list(chosen)
    for k in sorted(chosen, key=lambda c: (-images[c], int(covers[c].sum()))):
        if (count[covers[k]] >= 2).all():
            count = count - covers[k]
            kept.remove(k)
    return np.array(kept, dtype=np.int64)


def _least_radii(problem: CoverProblem, covers: NDArray[np.bool_], chosen: NDArray[np.int64]) -> Array:
    """Assign each cell to the chosen sphere that sticks out least for it; return the radii."""
    need = problem.farthest[chosen] - problem.depth[chosen, None]
    owner = np.argmin(np.where(covers[chosen], need, np.inf), axis=0)
    radii = np.zeros(len(chosen))
    np.maximum.at(radii, owner, problem.farthest[chosen][owner, np.arange(len(owner))])
    return radii
