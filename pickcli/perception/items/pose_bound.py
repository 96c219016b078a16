"""Bounds of the error of poses that are found surely: within them are 99 of 100, or should be.

Of the position, the angle, and what both do to the surface, which is less than each of them could: a box
that turns about the edge that is seen best has both. Each bound is the exponential of a linear function, by
quantile regression (Koenker and Bassett 1978) of logarithms of errors, with one factor for all by which
99.5 % of poses had all their errors within bounds that were fitted to other scenes (conformal prediction,
Vovk et al. 2005): ``python -m bench.perceived --seeds 10-39 --calibrate``.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.perception.items.item_observation import Support
from pickcli.scene.scene import PoseNoise

ROUNDING = 0.05  # mm, or degrees, below which errors are alike
_SURE = 1e-4  # of a confidence: nothing is surer
_PIXELS = 1000.0  # that an item shows about
_WEIGHTS = np.array(  # of logarithms of mm, degrees and mm
    [
        [3.204, 0.739, 0.148, 2.09, 0.176],
        [2.698, 0.314, 0.206, 3.31, -0.104],
        [4.182, 0.785, 0.198, 2.133, 0.287],
    ]
)
LEAST_CONFIDENCE_OF_BOUND = 0.985  # below it nothing is said of the error
LARGEST = PoseNoise(0.015, float(np.radians(8.0)))  # with wider bounds a pose is of no use to a planner


def bound_features(support: Support, confidence: float) -> Array:
    """Compute what bounds follow from.

    Args:
        support: How much of the picture speaks for the pose.
        confidence: That of the pose.

    Returns:
        (5,), the first is 1.
    """
    shown = max(support.shown, 1)
    return np.array(
        [
            1.0,
            np.log(1e3 * support.surface_spread),
            np.log(1.0 - confidence + _SURE),
            5.0 * support.through / shown,
            np.log(shown / _PIXELS),
        ]
    )


def bound_of(shape: Shape, support: Support, confidence: float) -> PoseNoise | None:
    """Compute the bounds of the error of a pose, symmetries of the shape aside.

    Args:
        shape: The item's shape: turns of a ball do not show.
        support: How much of the picture speaks for the pose.
        confidence: That of the pose.

    Returns:
        The bounds; None for a pose that is not sure enough, or whose bounds would be wider than ``LARGEST``.
    """
    if confidence < LEAST_CONFIDENCE_OF_BOUND:
        return None
    position, angle, displacement = np.exp(_WEIGHTS @ bound_features(support, confidence)).tolist()
    if shape.kind is ShapeKind.SPHERE:
        angle = 0.0
    bound = PoseNoise(1e-3 * position, float(np.radians(angle)), 1e-3 * max(position, displacement))
    return None if bound.position > LARGEST.position or bound.angle > LARGEST.angle else bound
