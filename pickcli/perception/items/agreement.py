"""How sure a pose is that two looks found, each by itself.

What hides an item, what noise makes of a picture and where a search gets stuck differ from look to look. So a
pose that two of them found is right, and two poses that differ are a warning that no single look gives. The
confidence is a logistic model of what the picture says for the pose, as by one look, how sure the other look
is, and how far both poses are apart: ``python -m bench.perceived --seeds 24-39 --sensors ensenso --looks 3
--calibrate``.

Of more than three looks the best pair is no proof: the more pairs there are, the more of them agree by
chance. So then looks vote. But no look recognises a print by chance where another finds the item, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from pickcli.cell.item import Item
from pickcli.geometry import Array
from pickcli.perception.items.confidence import support_features
from pickcli.perception.items.item_observation import NEAR, Agreement, Support
from pickcli.perception.items.symmetry import displacement_between, error_of

_WEIGHTS = np.array(
    [
        1.792, 0.825, -4.163, 3.597, -6.655, -1.356, 0.059, 1.032, 1.805, 0.953, -3.450, -1.850, -1.532,
        -2.910, 2.023, -2.041, 0.166, 0.130, 1.516, -0.116, -1.376, 0.802,
    ]
)  # fmt: skip
_SURE = 1e-3  # of the confidence of the other look: it is not surer than that for this one
_ALIKE = 0.3  # mm and degrees, below which poses are alike
FEW = 3  # looks from different places, of which a pair is believed by itself
_DOUBT = 0.5  # confidence of a look in another pose, from which on it speaks against one
# Of poses by six looks into bins in which something had been refused (three sensors, scenes 70108 to 70118)
# the 205 that four or more speak for were all right; of 64 that two or three speak for 4 were wrong.
SURE_BY_VOTES = SURE_BY_PRINT = 0.995
DOUBTFUL = 0.95


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
    confidence = float(1.0 / (1.0 + np.exp(-features @ _WEIGHTS)))
    if agreement.is_doubtful:
        return min(confidence, DOUBTFUL)
    return max(confidence, SURE_BY_PRINT) if agreement.is_by_print else confidence


def agreement_with(item: Item, T: Array, T_other: Array, confidence: float, n_prints: int = 0) -> Agreement:
    """Compare the poses that two looks found.

    Args:
        item: The item.
        T: (4, 4) its pose by one look.
        T_other: (4, 4) that by the other one.
        confidence: Of the other look, by itself.
        n_prints: How many of both found it by its print.

    Returns:
        How the other look agrees.
    """
    return Agreement(confidence, error_of(item.shape, T, T_other), n_prints)


@dataclass(frozen=True)
class Votes:
    """How looks from different places vote on a pose.

    Attributes:
        n_looks: Number of places that looks were taken from.
        n_for: From how many of them it was found, each look by itself.
        n_against: From how many of them it was found elsewhere with some confidence, and nothing near it.
    """

    n_looks: int
    n_for: int
    n_against: int

    def weighed(self, confidence: float) -> float:
        """Weigh the confidence of a pose by the votes.

        Args:
            confidence: By the two looks that agree best.

        Returns:
            The same for few looks; of more, high if four are for the pose, or three and none against it,
            and too low for a bound otherwise.
        """
        if self.n_looks <= FEW:
            return confidence
        if self.n_for > FEW:
            return max(confidence, SURE_BY_VOTES)
        is_open = self.n_for == FEW and not self.n_against
        return confidence if is_open else min(confidence, DOUBTFUL)


def votes_on(
    item: Item, T: Array, places: Sequence[Sequence[tuple[Array, float]]], copies: Sequence[Array]
) -> Votes:
    """Count the votes on a pose.

    Args:
        item: The item.
        T: (4, 4) its pose.
        places: For each place that looks were taken from the poses (4, 4) that they found of the item and
            its copies, each with the confidence of the look.
        copies: Poses (4, 4) of its copies elsewhere: a look that found one of them there does not speak
            against the pose.

    Returns:
        The votes.
    """
    n_for = n_against = 0
    for found in places:
        if any(displacement_between(item.shape, T, each) < NEAR for each, _ in found):
            n_for += 1
            continue
        n_against += any(
            confidence >= _DOUBT
            and not any(displacement_between(item.shape, other, each) < NEAR for other in copies)
            for each, confidence in found
        )
    return Votes(len(places), n_for, n_against)


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
