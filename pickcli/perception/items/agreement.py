"""How sure a pose is that two looks found, each by itself.

What hides an item, what noise makes of a picture and where a search gets stuck differ from look to look. So a
pose that two of them found is right, and two poses that differ are a warning that no single look gives. The
confidence is a logistic model of what the picture says for the pose, as by one look, how sure the other look
is, and how far both poses are apart: ``python -m bench.perceived --seeds 24-39 --sensors ensenso --looks 3
--calibrate``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import linear_sum_assignment

from pickcli.cell.item import Item
from pickcli.geometry import Array
from pickcli.perception.items.confidence import support_features
from pickcli.perception.items.item_observation import Agreement, Support
from pickcli.perception.items.symmetry import displacement_between, error_of

_WEIGHTS = np.array(
    [
        1.792, 0.825, -4.163, 3.597, -6.655, -1.356, 0.059, 1.032, 1.805, 0.953, -3.450, -1.850, -1.532,
        -2.910, 2.023, -2.041, 0.166, 0.130, 1.516, -0.116, -1.376, 0.802,
    ]
)  # fmt: skip
_SURE = 1e-3  # of the confidence of the other look: it is not surer than that for this one
_ALIKE = 0.3  # mm and degrees, below which poses are alike


def agreement_features(support: Support, no_return: float, n_listed: int, agreement: Agreement) -> Array:
    """Compute what the confidence follows from.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        n_listed: Number of items that are listed to be in the place.
        agreement: How another look agrees.

    Returns:
        (22,), the first is 1.
    """
    other, off = float(np.clip(agreement.confidence, _SURE, 1.0 - _SURE)), agreement.off
    assert off.displacement is not None
    of_other = [
        np.log(other / (1.0 - other)),
        np.log(1e3 * off.displacement + _ALIKE),
        np.log(np.degrees(off.angle) + _ALIKE),
    ]
    return np.append(support_features(support, no_return, n_listed), of_other)


def agreed_confidence(support: Support, no_return: float, n_listed: int, agreement: Agreement) -> float:
    """Compute the probability that a pose is right on which two looks agree so far.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        n_listed: Number of items that are listed to be in the place.
        agreement: How another look agrees.

    Returns:
        In (0, 1).
    """
    features = agreement_features(support, no_return, n_listed, agreement)
    return float(1.0 / (1.0 + np.exp(-features @ _WEIGHTS)))


def agreement_with(item: Item, T: Array, T_other: Array, confidence: float) -> Agreement:
    """Compare the poses that two looks found.

    Args:
        item: The item.
        T: (4, 4) its pose by one look.
        T_other: (4, 4) that by the other one.
        confidence: Of the other look, by itself.

    Returns:
        How the other look agrees.
    """
    return Agreement(confidence, error_of(item.shape, T, T_other))


def matched(
    items: Sequence[Item], one: Mapping[int, Array], other: Mapping[int, Array]
) -> dict[int, tuple[int, int]]:
    """Pair the poses of two looks: copies of an item may have been taken for each other.

    Args:
        items: The listed items.
        one: Poses (4, 4) that one look found, by index of the item.
        other: Those of the other look.

    Returns:
        By index of the item those in both looks, so that copies are as little apart as possible in the sum.
    """
    pairs: dict[int, tuple[int, int]] = {}
    for item in dict.fromkeys(items):
        copies = [i for i, each in enumerate(items) if each == item]
        here, there = ([i for i in copies if i in found] for found in (one, other))
        apart = np.array(
            [[displacement_between(item.shape, one[i], other[k]) for k in there] for i in here]
        ).reshape(len(here), len(there))
        for a, b in zip(*linear_sum_assignment(apart), strict=True):
            pairs[here[a]] = here[a], there[b]
    return pairs
