"""The shortening of polylines in numpy: slow, vectorised otherwise than the kernel, and easy to read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.kernel import Checker


def costs(velocity: Array, calm: float, steps: Array) -> Array:
    """(...,) of edges given by their differences (..., n)."""
    seconds = np.abs(steps) / velocity
    return np.asarray(seconds.max(axis=-1) + calm * np.linalg.norm(seconds, axis=-1))


def shortened(
    checker: Checker, Q: Array, shortcuts: Array, velocity: Array, calm: float, worthwhile: float,
    margin: float,
) -> Array:  # fmt: skip
    """What ``kernel.shorten`` promises."""
    Q = _without_needless(checker, Q, margin)
    for a, b in shortcuts if len(Q) > 2 else ():
        along = np.concatenate([[0.0], np.cumsum(costs(velocity, calm, np.diff(Q, axis=0)))])
        (i, j), ends = _points(Q, along, np.array([a, b]) * along[-1])
        saved = (b - a) * along[-1] - costs(velocity, calm, ends[1] - ends[0])
        parts = np.array([Q[i], *ends, Q[j + 1]])
        if i != j and saved >= worthwhile * along[-1] and checker.first_blocked_edge(parts, margin) == -1:
            Q = np.concatenate([Q[: i + 1], ends, Q[j + 1 :]])
    return _without_needless(checker, Q, margin)


def _without_needless(checker: Checker, Q: Array, margin: float) -> Array:
    kept, at, last = [0], 0, len(Q) - 1
    while at < last:
        skips = (to for to in range(last, at + 1, -1) if checker.edge_is_free(Q[at], Q[to], margin))
        at = next(skips, at + 1)
        kept.append(at)
    return Q[kept]


def _points(Q: Array, along: Array, at: Array) -> tuple[NDArray[np.intp], Array]:
    """The edges on which these costs from the start are reached, and the points."""
    i = np.minimum(along.searchsorted(at, side="right") - 1, len(along) - 2)
    share = (at - along[i]) / (along[i + 1] - along[i])
    return i, Q[i] + share[:, None] * (Q[i + 1] - Q[i])
