"""How far a pose may be off while the picture is explained nearly as well.

Laplace's approximation (MacKay 2003, Information Theory, Inference, and Learning Algorithms, ch. 27): the
cost of the picture, a negative logarithm of a likelihood, is taken as a quadratic form of small motions of
the item, whose inverse is the covariance of the pose. Its second derivatives are differences over steps as
wide as a pixel. Pixels err alike, so the result is a measure and no error: bounds are fitted to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, rotation_from_vector

STEP = 0.002  # m that the surface moves
LARGEST = 0.05  # m: nothing is known of a motion that changes the picture by less than 1 nat over that
_AXES_THAT_SHOW = {ShapeKind.SPHERE: 0, ShapeKind.CYLINDER: 2}  # of turns, by kind of shape; of others all


@dataclass(frozen=True)
class PoseSpread:
    """Standard deviations of a pose in the directions in which they are largest.

    Attributes:
        position: m.
        angle: rad; 0 if no turn shows.
        surface: m, of the point of the item that is off most.
    """

    position: float
    angle: float
    surface: float


def pose_spread(shape: Shape, T: Array, costs: Callable[[Array], Array]) -> PoseSpread:
    """Compute how far a pose may be off.

    Args:
        shape: The item's shape.
        T: (4, 4) the pose.
        costs: Returns what a picture costs (N,) with the item at poses (N, 4, 4), in nats, up to a constant.

    Returns:
        The spread.
    """
    radius = shape.bounding_radius
    n = 3 + _AXES_THAT_SHOW.get(shape.kind, 3)
    steps = STEP * np.eye(n)
    one_way = [sign * step for step in steps for sign in (1, -1)]
    pairs = [(a, b) for a in range(n) for b in range(a)]
    mixed = [i * steps[a] + k * steps[b] for a, b in pairs for i in (1, -1) for k in (1, -1)]
    found = costs(np.array([T, *(_moved(T, step, radius) for step in (*one_way, *mixed))]))
    of_one, of_mixed = found[1 : 2 * n + 1].reshape(n, 2), found[2 * n + 1 :].reshape(len(pairs), 4)
    second = np.diag(of_one.sum(axis=1) - 2.0 * found[0]) / STEP**2
    for (a, b), four in zip(pairs, of_mixed @ [1.0, -1.0, -1.0, 1.0], strict=True):
        second[a, b] = second[b, a] = four / (4.0 * STEP**2)
    values, vectors = np.linalg.eigh(second)
    covariance = (vectors / np.maximum(values, LARGEST**-2)) @ vectors.T
    scales = np.append(np.ones(3), np.full(n - 3, 1.0 / radius))
    return spread_of(shape, covariance * scales * scales[:, None])


def spread_of(shape: Shape, covariance: Array) -> PoseSpread:
    """Compute how far a pose with a covariance may be off.

    Args:
        shape: The item's shape.
        covariance: (6, 6) of small motions about the item's own axes: a shift in m, then a turn in rad; or
            less of it, without turns that the shape does not show.

    Returns:
        The spread.
    """
    n = 3 + min(_AXES_THAT_SHOW.get(shape.kind, 3), len(covariance) - 3)
    shown = covariance[:n, :n]
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * shape.extents
    of_points = [J @ shown @ J.T for J in _jacobians(corners, n)]
    return PoseSpread(_largest(shown[:3, :3]), _largest(shown[3:, 3:]), max(map(_largest, of_points)))


def _jacobians(points: Array, n: int) -> Array:
    """(N, 3, n) how points (N, 3) in m move by shifts and turns in n directions."""
    turned = np.cross(np.eye(3)[: n - 3], points[:, None, :]).swapaxes(1, 2)
    return np.concatenate([np.broadcast_to(np.eye(3), (len(points), 3, 3)), turned], axis=2)


def _largest(covariance: Array) -> float:
    """The standard deviation in the direction in which it is largest."""
    return float(np.sqrt(np.linalg.eigvalsh(covariance).max(initial=0.0)))


def _moved(T: Array, step: Array, radius: float) -> Array:
    """The pose (4, 4), moved along and turned about the item's own axes by a step (3 to 6,) in m."""
    moved = T.copy()
    moved[:3, 3] += T[:3, :3] @ step[:3]
    turn = np.zeros(3)
    turn[: len(step) - 3] = step[3:] / radius
    moved[:3, :3] = T[:3, :3] @ rotation_from_vector(turn)
    return moved
