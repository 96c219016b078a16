"""Bounds of the error of poses that are found surely: within them are 99 of 100, or should be.

Each is the exponential of a linear function, by quantile regression (Koenker and Bassett 1978) of logarithms
of errors, with an offset by which they held for 99.5 % of those that they were fitted to (conformal
prediction, Vovk et al. 2005), and three quarters more, because ten scenes do not show all that goes wrong:
``python -m bench.perceived --seeds 10-19 --calibrate``.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.perception.items.confidence import support_features
from pickcli.perception.items.item_observation import Support
from pickcli.scene.scene import PoseNoise

ROUNDING = 0.05  # mm, or degrees, below which errors are alike
_SURE = 1e-4  # of a confidence: nothing is surer
_TURN = 0.02  # degrees, of a spread that is 0
_POSITION = np.array([2.531, 0.138, 1.187, -0.009, -0.366, 0.583, 0.133])  # of logarithms of mm
_ANGLE = np.array([3.614, 0.086, 1.757, -1.048, -0.01, 0.189, 1.37])  # of logarithms of degrees
LEAST_CONFIDENCE_OF_BOUND = 0.985  # below it nothing is said of the error
LARGEST = PoseNoise(0.015, float(np.radians(8.0)))  # with wider bounds a pose is of no use to a planner


def bound_features(support: Support, no_return: float, confidence: float) -> Array:
    """Compute what bounds follow from.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.

    Returns:
        (7,), the first is 1.
    """
    features = support_features(support, no_return, 1)
    doubt = float(np.log(1.0 - confidence + _SURE))
    spread = np.log(1e3 * support.position_spread), np.log(np.degrees(support.angle_spread) + _TURN)
    return np.array([1.0, doubt, features[9], features[3], features[7], *spread])


def bound_of(shape: Shape, support: Support, no_return: float, confidence: float) -> PoseNoise | None:
    """Compute the bounds of the error of a pose, symmetries of the shape aside.

    Args:
        shape: The item's shape: turns of a ball do not show.
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.

    Returns:
        The bounds; None for a pose that is not sure enough, or whose bounds would be wider than ``LARGEST``.
    """
    if confidence < LEAST_CONFIDENCE_OF_BOUND:
        return None
    features = bound_features(support, no_return, confidence)
    angle = 0.0 if shape.kind is ShapeKind.SPHERE else float(np.radians(np.exp(features @ _ANGLE)))
    bound = PoseNoise(1e-3 * float(np.exp(features @ _POSITION)), angle)
    return None if bound.position > LARGEST.position or bound.angle > LARGEST.angle else bound
