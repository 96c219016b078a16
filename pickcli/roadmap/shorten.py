"""Making a proven polyline shorter without ever leaving what is proven."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.roadmap.cost import edge_costs
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
    rng = np.random.default_rng(seed)
    waypoints = _without_needless(checker, path.waypoints)
    for _ in range(iterations if len(waypoints) > 2 else 0):
        waypoints = _with_shortcut(checker, space, waypoints, rng)
        if len(waypoints) == 2:
            break
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


def _with_shortcut(
    checker: EdgeChecker, space: JointSpace, waypoints: Array, rng: np.random.Generator
) -> Array:
    """The polyline with one random shortcut, or as it was."""
    costs = edge_costs(space, waypoints)
    along = np.concatenate([[0.0], np.cumsum(costs)])
    s0, s1 = np.sort(rng.random(2)) * along[-1]
    i, j = (min(int(np.searchsorted(along, s, side="right")) - 1, len(costs) - 1) for s in (s0, s1))
    if i == j:
        return waypoints
    p0, p1 = (waypoints[k] + (s - along[k]) / costs[k] * (waypoints[k + 1] - waypoints[k])
              for k, s in ((i, s0), (j, s1)))  # fmt: skip
    saved = (s1 - s0) - float(edge_costs(space, np.stack([p0, p1]))[0])
    if saved < _WORTHWHILE * along[-1] or not checker.edge_is_free(p0, p1):
        return waypoints
    # The rests of the two cut edges are parts of proven edges, hence proven.
    return np.concatenate([waypoints[: i + 1], [p0, p1], waypoints[j + 1 :]])
