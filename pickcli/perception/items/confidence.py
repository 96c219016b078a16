"""How likely a found pose is right: a logistic model of what the picture says for it.

Fitted by ``python -m bench.perceived --seeds 1-3 --calibrate`` to poses that were within 10 mm and 10 degrees
of the truth, and tested on scenes of other seeds.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.perception.items.item_observation import Support

LEAST_CONFIDENCE = 0.5  # below it a pose is refused
_WEIGHTS = np.array([-7.1, 0.38, 2.41, 3.97, -1.88, -2.24, -1.82, 1.14, 4.73, -1.42])


def support_features(support: Support, no_return: float) -> Array:
    """Compute what the confidence follows from, each of the order of 1.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.

    Returns:
        (10,), the first is 1.
    """
    shown = max(support.shown, 1)
    return np.array(
        [
            1.0,
            np.log(max(support.gain, 1.0)) / 5.0,
            min(support.gain / shown, 8.0) / 4.0,
            min(support.supported / (shown * max(1.0 - no_return, 0.05)), 1.3),
            5.0 * support.through / shown,
            5.0 * support.before / shown,
            2.0 * support.colour,
            min(shown / max(support.expected, 1), 1.0),
            np.log(max(support.margin, 0.0) + 20.0) / 5.0,
            np.log(shown) / 5.0,
        ]
    )


def confidence_of(support: Support, no_return: float) -> float:
    """Compute the probability that a pose is right.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.

    Returns:
        In (0, 1).
    """
    return float(1.0 / (1.0 + np.exp(-support_features(support, no_return) @ _WEIGHTS)))
