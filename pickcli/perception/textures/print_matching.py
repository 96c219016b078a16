"""Which features of a picture are like which features of a model.

The two ways of KTH (paper 000, III-B): *simtrack* compares with the features of all views as one set,
*simtect* with those of each view by itself, which is dearer and finds more where sides are alike. How large
a feature is in m follows from the depth of the picture, so only features of about one size are compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.perception.surface_view import FloatPicture
from pickcli.perception.textures.print_features import PrintFeatures, products
from pickcli.perception.textures.print_model import N_VIEWS, PrintModel
from pickcli.perception.textures.sift_views import SiftViews

_STEP = 0.5  # octaves of a feature's length, of those that are compared at once
_OFF = 0.35  # octaves by which lengths may differ besides
_RATIO = 0.85  # of the distances to the most and to the second most like feature (Lowe: 0.8)
_ELSEWHERE = 0.008  # m on the item, from which on the second one is another
_N_LIKE = 8  # features among which that is looked for


@dataclass(frozen=True, eq=False)
class Matches:
    """Pairs of features that are alike.

    Attributes:
        seen: (M,) indices in the picture's features.
        known: (M,) indices in the model's.
        unlike: (M,) ratios of the distance to that of the second most like feature; the smaller, the surer.
    """

    seen: NDArray[np.intp]
    known: NDArray[np.intp]
    unlike: Array

    def __len__(self) -> int:
        return len(self.seen)

    def only(self, kept: NDArray[np.bool_] | NDArray[np.intp]) -> Matches:
        """Keep some of the pairs.

        Args:
            kept: (M,) which ones, or (K,) their indices.

        Returns:
            These pairs.
        """
        return Matches(self.seen[kept], self.known[kept], self.unlike[kept])


def matches_of(
    features: PrintFeatures, lengths: Array, model: PrintModel, views: SiftViews
) -> tuple[Matches, ...]:
    """Match features with those of a model.

    Args:
        features: Features of a picture.
        lengths: (N,) m, how large they are.
        model: The model.
        views: Which of its views are taken as one set.

    Returns:
        The matches by set: one for all views, or one for each view.
    """
    n_sets = 1 if views is SiftViews.ALL else N_VIEWS
    found: list[list[Matches]] = [[] for _ in range(n_sets)]
    with np.errstate(divide="ignore"):
        octaves, known_octaves = np.log2(lengths), np.log2(model.lengths)
    projected = products(features.descriptors, model.directions)
    steps = np.floor(octaves / _STEP)
    for step in np.unique(steps[np.isfinite(steps)]):
        seen = np.flatnonzero(steps == step)
        ends = np.array([step * _STEP - _OFF, (step + 1) * _STEP + _OFF])
        first, last = np.searchsorted(known_octaves, ends)
        if last - first < 2:
            continue
        known = np.arange(first, last)
        alike = products(projected[seen], model.projected[first:last])
        if views is SiftViews.ALL:
            likely = known[_largest(alike)]
            found[0].append(_matched(features, model, seen, likely))
            continue
        for view in range(N_VIEWS):
            own = np.flatnonzero(model.views[first:last] == view)
            if len(own) > 1:
                likely = known[own[_largest(alike[:, own])]]
                found[view].append(_matched(features, model, seen, likely))
    return tuple(map(joined, found))


def _largest(alike: FloatPicture) -> NDArray[np.intp]:
    """(N, L) indices of the largest values in each row, in any order."""
    n = min(_N_LIKE, alike.shape[1])
    return np.asarray(np.argpartition(-alike, n - 1, axis=1)[:, :n])


def _matched(
    features: PrintFeatures, model: PrintModel, seen: NDArray[np.intp], likely: NDArray[np.intp]
) -> Matches:
    """Of features (N,) the matches with those of (N, L) that are more alike than with any other point."""
    rows = np.arange(len(seen))
    values = np.einsum("nd,nld->nl", features.descriptors[seen], model.descriptors[likely])
    order = np.argsort(-values, axis=1, kind="stable")
    likely, values = likely[rows[:, None], order], values[rows[:, None], order]
    at = model.points[likely]
    is_elsewhere = np.linalg.norm(at - at[:, :1], axis=2) > _ELSEWHERE
    second = np.where(is_elsewhere.any(axis=1), is_elsewhere.argmax(axis=1), likely.shape[1] - 1)
    distances = np.sqrt(np.maximum(2.0 - 2.0 * values.astype(np.float64), 1e-9))
    ratio = distances[:, 0] / distances[rows, second]
    kept = ratio < _RATIO
    return Matches(seen[kept], likely[kept, 0], ratio[kept])


def joined(parts: Sequence[Matches]) -> Matches:
    """Put sets of matches together.

    Args:
        parts: The sets.

    Returns:
        All of them, in this order.
    """
    none = Matches(np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros(0))
    every = [none, *parts]
    return Matches(
        np.concatenate([each.seen for each in every]),
        np.concatenate([each.known for each in every]),
        np.concatenate([each.unlike for each in every]),
    )
