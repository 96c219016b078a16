"""How likely a found pose is right: a logistic model of what the picture says for it.

Fitted by ``python -m bench.perceived --seeds 10-18 --calibrate`` to poses of which some were within 10 mm and
10 degrees of the truth, and tested on scenes of other seeds.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.perception.items.item_observation import Support

LEAST_CONFIDENCE = 0.8  # below it a pose is refused
LEAST_OWN_COLOUR = 0.7  # below it an answer by shape is refused; nearly all right ones have over 0.8
_WEIGHTS = np.array(
    [
        1.883, 2.276, 1.382, -0.109, -6.234, -0.251, -3.467, 0.196, -0.646, -1.286, -0.538, -1.897, -1.865,
        1.223, 1.94, -2.26, 0.164, 0.891, -0.196,
    ]
)  # fmt: skip
_LEAST_SPREAD = 1e-5  # m
_LITTLE_MARGIN = 0.05  # nats of a pixel
_LITTLE = 0.6  # of the share of what should come back that is supported


def support_features(support: Support, no_return: float, n_listed: int) -> Array:
    """Compute what the confidence follows from, each of the order of 1.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        n_listed: Number of items that are listed to be in the place.

    Returns:
        (19,), the first is 1.
    """
    shown = max(support.shown, 1)
    supported = min(support.supported / (shown * max(1.0 - no_return, 0.05)), 1.3)
    return np.array(
        [
            1.0,
            np.log(max(support.gain, 1.0)) / 5.0,
            min(support.gain / shown, 8.0) / 4.0,
            supported,
            5.0 * support.through / shown,
            5.0 * support.before / shown,
            2.0 * support.colour,
            min(shown / max(support.expected, 1), 1.0),
            np.log(max(support.margin, 0.0) + 20.0) / 5.0,
            np.log(shown) / 5.0,
            6.0 * max(support.colour, 0.0),
            n_listed / 5.0,
            3.0 * max(_LITTLE - supported, 0.0),
            no_return,
            np.log(1e3 * support.surface_spread),
            np.log(1e3 * max(support.position_spread, _LEAST_SPREAD)),
            np.log(max(support.margin, 1.0) / shown + _LITTLE_MARGIN),
            min(support.margin / max(support.gain, 1.0), 1.5),
            (shown - support.supported) / shown,
        ]
    )


def confidence_of(support: Support, no_return: float, n_listed: int) -> float:
    """Compute the probability that a pose is right.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        n_listed: Number of items that are listed to be in the place.

    Returns:
        In (0, 1).
    """
    return float(1.0 / (1.0 + np.exp(-support_features(support, no_return, n_listed) @ _WEIGHTS)))


def truncated(confidence: float) -> str:
    """Format a confidence so that it never looks higher than it is.

    Args:
        confidence: In [0, 1].

    Returns:
        Three decimals, cut off: 0.4996 is below 0.5 as 0.499.
    """
    return f"{np.floor(1e3 * confidence) / 1e3:.3f}"
