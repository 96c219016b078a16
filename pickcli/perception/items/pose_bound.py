"""Bounds of the error of poses that are found surely: within them are 99 of 100, or should be.

Each is the exponential of a linear function, by quantile regression (Koenker and Bassett 1978) of logarithms
of errors, with an offset by which they held for 99.5 % of those that they were fitted to (split conformal
prediction, Vovk et al. 2005), and half as much again, because three scenes are few:
``python -m bench.perceived --seeds 1-3 --calibrate``.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.perception.items.confidence import support_features
from pickcli.perception.items.item_observation import Support
from pickcli.scene.scene import PoseNoise

ROUNDING = 0.05  # mm, or degrees, below which errors are alike
_SURE = 1e-4  # of a confidence: nothing is surer
_POSITION = np.array([7.031, -0.017, -2.417, -0.214, -1.981])  # of logarithms of mm
_ANGLE = np.array([6.162, -0.023, -3.042, -0.915, 0.236])  # of logarithms of degrees
LEAST_CONFIDENCE_OF_BOUND = 0.95  # below it nothing is said of the error
_LARGEST_MM, _LARGEST_DEG = 500.0, 180.0


def bound_features(support: Support, no_return: float, confidence: float) -> Array:
    """Compute what bounds follow from.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.

    Returns:
        (5,), the first is 1.
    """
    features = support_features(support, no_return, 1)
    doubt = float(np.log(1.0 - confidence + _SURE))
    return np.array([1.0, doubt, features[9], features[3], features[7]])


def bound_of(support: Support, no_return: float, confidence: float) -> PoseNoise | None:
    """Compute the bounds of the error of a pose, symmetries of the shape aside.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.

    Returns:
        The bounds; None for a pose that is not sure enough.
    """
    if confidence < LEAST_CONFIDENCE_OF_BOUND:
        return None
    features = bound_features(support, no_return, confidence)
    mm, deg = float(np.exp(features @ _POSITION)), float(np.exp(features @ _ANGLE))
    return PoseNoise(1e-3 * min(mm, _LARGEST_MM), float(np.radians(min(deg, _LARGEST_DEG))))
