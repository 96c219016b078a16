"""Making a proven polyline shorter without ever leaving what is proven."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.roadmap.cost import edge_costs, step_costs
from pickcli.roadmap.space import EdgeChecker, JointSpace

# A shortcut must save this share of the whole cost, or vertices multiply for nothing.
_WORTHWHILE = 1e-3


def shorten(
    checker: EdgeChecker, space: JointSpace, path: JointPath, *, seed: int, iterations: int = 100
) -> JointPath:
    """A path with the same ends that costs no more (see ``edge_costs``): every new edge is proven.

    First vertices that are not needed go, then ``iterations`` times two random points of the path are
    joined by a straight edge where that is proven and saves something (Geraerts and Overmars 2007), and
    the needless vertices go again. The edges of ``path`` itself are taken as proven. Repeatable by seed.
    """
    waypoints = _without_needless(checker, path.waypoints)
    if len(waypoints) > 2 and iterations > 0:
        shortcuts = np.random.default_rng(seed).random((iterations, 2))
        waypoints = _with_shortcuts(checker, space, waypoints, np.sort(shortcuts, axis=1))
    return JointPath(path.joint_names, _without_needless(checker, waypoints))


def _without_needless(checker: EdgeChecker, waypoints: Array) -> Array:
    """The polyline without the vertices that a proven edge skips, farthest skips first."""
    kept, at, last = [0], 0, len(waypoints) - 1
    while at < last:
        at = next(
            (to for to in range(last, at + 1, -1) if checker.edge_is_free(waypoints[at], waypoints[to])),
            at + 1,
        )
        kept.append(at)
    return np.asarray(waypoints[kept])


def _with_shortcuts(checker: EdgeChecker, space: JointSpace, waypoints: Array, places: Array) -> Array:
    """The polyline with those shortcuts that are proven and worthwhile, one after the other.

    places: (K, 2) where each begins and ends, as increasing shares of the cost of the polyline then
    """
    k = 0
    while k < len(places):
        # The polyline stays as it is until one is taken: so many at once are worked out.
        taken, waypoints = _with_first(checker, space, waypoints, places[k:])
        k += taken
    return waypoints


def _with_first(
    checker: EdgeChecker, space: JointSpace, waypoints: Array, places: Array
) -> tuple[int, Array]:
    """The polyline with the first of the shortcuts (K, 2) that holds, and how many were gone through."""
    along = np.concatenate([[0.0], np.cumsum(edge_costs(space, waypoints))])
    edges, points = _points(waypoints, along, places * along[-1])
    saved = (places[:, 1] - places[:, 0]) * along[-1] - step_costs(space, points[:, 1] - points[:, 0])
    worthwhile = (edges[:, 0] != edges[:, 1]) & (saved >= _WORTHWHILE * along[-1])
    for k in np.flatnonzero(worthwhile):
        if checker.edge_is_free(points[k, 0], points[k, 1]):
            i, j = edges[k]
            # The rests of the two cut edges are parts of proven edges.
            return int(k) + 1, np.concatenate([waypoints[: i + 1], points[k], waypoints[j + 1 :]])
    return len(places), waypoints


def _points(waypoints: Array, along: Array, costs: Array) -> tuple[NDArray[np.intp], Array]:
    """The edges (...,) on which these costs (...,) from the start are reached, and the points (..., n)."""
    i = np.minimum(along.searchsorted(costs, side="right") - 1, len(along) - 2)
    share = (costs - along[i]) / (along[i + 1] - along[i])
    return i, waypoints[i] + share[..., None] * (waypoints[i + 1] - waypoints[i])
