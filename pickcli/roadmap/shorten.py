"""Making a proven polyline shorter without ever leaving what is proven."""

from __future__ import annotations

import numpy as np

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
    """The polyline with those shortcuts that are proven and worthwhile.

    places: (K, 2) where each begins and ends, as increasing shares of the cost of the polyline then
    """
    along = _along(space, waypoints)
    for s0, s1 in places:
        i, p0 = _point(waypoints, along, s0 * along[-1])
        j, p1 = _point(waypoints, along, s1 * along[-1])
        saved = (s1 - s0) * along[-1] - step_costs(space, p1 - p0)
        if i == j or saved < _WORTHWHILE * along[-1] or not checker.edge_is_free(p0, p1):
            continue
        # The rests of the two cut edges are parts of proven edges.
        waypoints = np.concatenate([waypoints[: i + 1], [p0, p1], waypoints[j + 1 :]])
        along = _along(space, waypoints)
    return waypoints


def _along(space: JointSpace, waypoints: Array) -> Array:
    """(N,): cost from the start to each vertex."""
    return np.concatenate([[0.0], np.cumsum(edge_costs(space, waypoints))])


def _point(waypoints: Array, along: Array, s: float) -> tuple[int, Array]:
    """The edge on which the cost s is reached, and the configuration there."""
    i = min(int(along.searchsorted(s, side="right")) - 1, len(along) - 2)
    share = (s - along[i]) / (along[i + 1] - along[i])
    return i, waypoints[i] + share * (waypoints[i + 1] - waypoints[i])
