"""Bounds of the error of poses that are found surely: within them are 99 of 100, or should be.

Of the position, the angle, and what both do to the surface, which is less than each of them could: a box
that turns about the edge that is seen best has both. Which errors are usual is a linear function, by quantile
regression (Koenker and Bassett 1978) of logarithms of errors. Where usual errors are small, large ones are
rarer, too. So poses have two or three classes by the usual error of the surface, each with a factor by which
99.5 % of its poses had all their errors within bounds that were fitted to other scenes (Mondrian conformal
prediction, Vovk et al. 2005). Sensors that mix depths at edges have a model of their own:
``python -m bench.perceived --seeds 10-18 --calibrate``. For poses that two looks agree on there is one that
knows how far both are apart: ``--seeds 24-39 --sensors ensenso --looks 3 --calibrate``. It holds for other
sensors, too, by which two looks from different places err each by itself (``--seeds 24-31 --sensors carmine
kinect_v2 --looks 3 --calibrate``); but where depths are rounded coarsely both are off alike, as whole faces
are, and where depths are mixed at edges both are a little less exact. Where both recognised the print, a pose
cannot be any that merely looks alike in depth, so there bounds have a model of their own: ``--seeds
83510-83525 --sensors ensenso --looks 3 --sift all-views --calibrate``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.sensors.sensor_model import DepthModel, SensorModel
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import Array
from pickcli.perception.items.item_observation import Agreement, Support
from pickcli.perception.items.pose_spread import spread_of
from pickcli.perception.items.symmetry import unlikeness
from pickcli.scene.scene import PoseNoise

ROUNDING = 0.05  # mm, or degrees, below which errors are alike
SURE = 1e-4  # of a confidence: nothing is surer


@dataclass(frozen=True, eq=False)
class BoundModel:
    """How bounds follow from features.

    Attributes:
        weights: (3, F) of logarithms of usual errors: mm, degrees, and mm of the surface.
        classes: (C - 1,) of that of the surface, where the next class begins.
        factors: (C,) logarithms of how much wider bounds are, by class.
    """

    weights: Array
    classes: Array
    factors: Array

    def bounds(self, features: Array) -> Array:
        """Compute bounds of errors by features.

        Args:
            features: (N, F).

        Returns:
            (N, 3) mm, degrees, and mm of the surface.
        """
        usual = features @ self.weights.T
        return np.asarray(np.exp(usual + self.factors[np.searchsorted(self.classes, usual[:, 2])][:, None]))


_SHARP = BoundModel(
    np.array([[0.069, 0.208, -0.006, 0.613], [0.527, 0.508, 0.039, -0.111], [0.975, 0.38, -0.001, 0.306]]),
    np.array([0.604]),
    np.array([0.892, 1.642]),
)
_MIXED = BoundModel(
    np.array([[1.532, 0.777, 0.047, -0.276], [1.977, 1.022, 0.042, -0.218], [1.734, 0.822, -0.054, -0.357]]),
    np.array([0.522]),
    np.array([0.904, 4.166]),
)
_AGREED = BoundModel(
    np.array(
        [
            [0.781, 0.374, 0.092, 0.5, 0.242],
            [-0.153, 0.396, -0.021, 0.089, 0.415],
            [0.88, 0.339, 0.032, 0.292, 0.406],
        ]
    ),
    np.array([0.248, 0.661]),
    np.array([0.716, 1.11, 1.732]),
)
_PRINTED = BoundModel(  # its factors keep 99.9 %
    np.array(
        [
            [0.552, 0.347, 0.075, 0.618, 0.353],
            [0.175, 0.339, 0.049, 0.186, 0.292],
            [0.601, 0.274, 0.007, 0.241, 0.486],
        ]
    ),
    np.array([0.433]),
    np.array([0.871, 1.141]),
)
_FROM, _COARSE = 0.7, 0.001  # m from which bins are looked into, and a step of depth there that is coarse
# With it 249 of 251 poses by Carmine were kept, all but two wrong ones; without it 255 of 261.
_WIDER_IF_COARSE = 1.22
# Pixels that mix depths at edges leave angles, and where thin items end, a little less sure. Without it
# 338 of 343 and 293 of 296 poses by Kinect v2 were kept, with it 289 of 290 of the latter.
_WIDER_IF_MIXED = 1.2
# Where hardly any depth comes back, looks by the same print err alike: one pose of glue sticks in a trial was
# off by 1.36 times the angle that it was to be within.
_WIDER_IF_CLEAR, _CLEAR = 1.5, 0.5  # share of the surface without depth
# Bounds of position, angle and surface over standard deviations, of poses by prints in several looks: all of
# 172 such poses in five scenes were within them (the largest were 1.80, 3.92 and 2.50). Those are of an
# Ensenso; of 61 poses in two scenes by the coarser Carmine and Kinect v2 the largest are 3.54, 3.70 and 3.92.
_JOINT_FACTORS, _JOINT_FACTORS_OF_COARSE = np.array([2.0, 4.4, 2.9]), np.array([4.2, 5.0, 4.8])
_FINE = 2.0  # pixels per mm from which on a picture is not coarse
# Of the deformation: its surface is off by it, and at the ends by half of it for the turn.
SURFACE_OFF = 1.5
LEAST_CONFIDENCE_OF_BOUND = 0.99  # below it nothing is said of the error
LARGEST = PoseNoise(0.015, float(np.radians(8.0)))  # with wider bounds a pose is of no use to a planner


def bound_features(support: Support, no_return: float, confidence: float) -> Array:
    """Compute what usual errors follow from.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.

    Returns:
        (4,), the first is 1.
    """
    return np.array([1.0, np.log(1e3 * support.surface_spread), np.log(1.0 - confidence + SURE), no_return])


def bound_of(
    item: Item, support: Support, depth_model: DepthModel, confidence: float, deformation: float = 0.0
) -> PoseNoise | None:
    """Compute the bounds of the error of a pose, symmetries of the shape aside.

    Args:
        item: The item.
        support: How much of the picture speaks for the pose.
        depth_model: How depth was measured.
        confidence: That of the pose.
        deformation: m by which the item's surface may be inside of its shape.

    Returns:
        The bounds; None for a pose that is not sure enough, or whose bounds would be wider than ``LARGEST``.
    """
    if confidence < LEAST_CONFIDENCE_OF_BOUND:
        return None
    features = bound_features(support, depth_model.no_return.get(item.material, 0.0), confidence)
    bound = _bound(item, _MIXED if depth_model.mixes_edges else _SHARP, features)
    return _useful(_deformed(item, bound, deformation))


def agreed_bound_features(
    support: Support, no_return: float, confidence: float, agreement: Agreement
) -> Array:
    """Compute what usual errors of poses that two looks agree on follow from.

    Args:
        support: How much of the picture speaks for the pose.
        no_return: Share of the item's surface from which nothing comes back, by its material.
        confidence: That of the pose.
        agreement: How the other look agrees.

    Returns:
        (5,), the first is 1.
    """
    assert agreement.off.displacement is not None
    apart = np.log(1e3 * agreement.off.displacement + ROUNDING)
    return np.append(bound_features(support, no_return, confidence), apart)


def agreed_bound_of(
    item: Item,
    support: Support,
    sensor: SensorModel,
    confidence: float,
    agreement: Agreement,
    deformation: float = 0.0,
) -> PoseNoise | None:
    """Compute the bounds of the error of a pose that two looks agree on, symmetries of the shape aside.

    Args:
        item: The item.
        support: How much of the picture speaks for the pose.
        sensor: The sensor, which measures depth.
        confidence: That of the pose.
        agreement: How the other look agrees.
        deformation: m by which the item's surface may be inside of its shape.

    Returns:
        The bounds; None for a pose that is not sure enough, or whose bounds would be wider than ``LARGEST``.
    """
    if confidence < LEAST_CONFIDENCE_OF_BOUND:
        return None
    depth_model = sensor.depth
    assert depth_model is not None
    no_return = depth_model.no_return.get(item.material, 0.0)
    features = agreed_bound_features(support, no_return, confidence, agreement)
    is_coarse = depth_model.step(_FROM, sensor.camera.fx) > _COARSE
    wider = max(_WIDER_IF_COARSE if is_coarse else 1.0, _WIDER_IF_MIXED if depth_model.mixes_edges else 1.0)
    model = _PRINTED if agreement.is_by_print else _AGREED
    if agreement.is_by_print and no_return > _CLEAR:
        wider *= _WIDER_IF_CLEAR
    return _useful(_deformed(item, _bound(item, model, features, wider), deformation))


def joint_bound_of(item: Item, covariance: Array, pixels_per_mm: float) -> PoseNoise | None:
    """Compute the bounds of the error of a pose by its print in looks from several places, solved together.

    Args:
        item: The item.
        covariance: (6, 6) of its motion by what the matches leave open: a shift in m, then a turn in rad.
        pixels_per_mm: Of the coarsest of the pictures, at the mouth of the place.

    Returns:
        The bounds; None if they would be wider than ``LARGEST``.
    """
    spread = spread_of(item.shape, covariance)
    deviations = np.array([spread.position, spread.angle, spread.surface])
    factors = _JOINT_FACTORS if pixels_per_mm >= _FINE else _JOINT_FACTORS_OF_COARSE
    return _useful(PoseNoise(*(factors * deviations).tolist()))


def _bound(item: Item, model: BoundModel, features: Array, wider: float = 1.0) -> PoseNoise:
    position, angle, displacement = (wider * model.bounds(features[None])[0]).tolist()
    if item.shape.kind is ShapeKind.SPHERE:  # its turns do not show
        angle = 0.0
    # Sides that are nearly equal may be exchanged in all looks alike, whatever their poses vary by. Faces
    # that are seen stay where they are: the middle moves by half the difference, faces behind by all of it.
    off = unlikeness(item.shape)
    surface = 1e-3 * max(position, displacement) + 2.0 * off
    return PoseNoise(1e-3 * position + off, float(np.radians(angle)), surface)


def _deformed(item: Item, bound: PoseNoise, deformation: float) -> PoseNoise:
    """Bounds of an item whose surface may be inside of its shape.

    If one side of it is and the other is not, what is seen of it is off by up to all of that, whatever looks
    agree on, and turned by as much over its middle side.
    """
    assert bound.displacement is not None
    turn = float(np.arctan2(deformation, np.median(item.shape.extents)))
    surface = bound.displacement + SURFACE_OFF * deformation
    return PoseNoise(bound.position + deformation, bound.angle + turn, surface)


def _useful(bound: PoseNoise) -> PoseNoise | None:
    """A bound that is of use to a planner, or None."""
    return None if bound.position > LARGEST.position or bound.angle > LARGEST.angle else bound
