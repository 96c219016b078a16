"""Proof that the truck keeps a distance all along a path, not only at samples of it.

Between two poses a step of travel apart no point of the truck moves farther than the step times the truck's
``sweep``: a part of a path is free if the truck in its middle is farther from everything than half of that.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.driving.driving_area import WALLS, DrivingArea
from pickcli.driving.steering_path import SteeringPath
from pickcli.geometry import Array

FIRST_STEP = 0.4  # m of travel of the parts that are halved where they are not proven
LAST_STEP = 2e-5  # m of travel of a part that is not halved any more
RESERVE = 1e-6  # m, over all rounding: of the quadrature of poses, and of figures in files


@dataclass(frozen=True)
class Encounter:
    """Where a path is not proven to keep its distance.

    Attributes:
        travel: m from the start of the path.
        name: The nearest box, or the walls.
        clearance: m between them and the truck there, 0 if they overlap, negative if it is outside.
    """

    travel: float
    name: str
    clearance: float


def clearances(area: DrivingArea, poses: Array) -> Array:
    """Return the distance of the truck from everything.

    Args:
        area: The area.
        poses: (N, 3) m, m, rad.

    Returns:
        (N, 1 + number of boxes) m from the walls, negative outside, and from each box, 0 where they overlap.
    """
    corners = truck_corners(area, poses)
    found = [area.wall_distance(corners).min(axis=1)]
    found += [rectangle_distances(corners, box.corners) for box in area.boxes]
    return np.stack(found, axis=1)


def truck_corners(area: DrivingArea, poses: Array) -> Array:
    """Return the corners of the truck.

    Args:
        area: The area.
        poses: (N, 3) m, m, rad.

    Returns:
        (N, 4, 2) m, counterclockwise.
    """
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    R = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], -2)
    corners: Array = area.truck.corners @ R + poses[:, None, :2]
    return corners


def rectangle_distances(corners: Array, box: Array) -> Array:
    """Return the distances of rectangles from one.

    Args:
        corners: (N, 4, 2) m, of the rectangles.
        box: (4, 2) m, corners of the one.

    Returns:
        (N,) m; 0 if no axis parts them.
    """
    of_box = np.broadcast_to(box, corners.shape)
    (gap, distance), (other_gap, other_distance) = _seen(corners, of_box), _seen(of_box, corners)
    return np.where(np.maximum(gap, other_gap) > 0, np.minimum(distance, other_distance), 0.0)


def _seen(rectangles: Array, points: Array) -> tuple[Array, Array]:
    """(N,) m: largest gap along the axes of rectangles between them and (N, 4, 2) points; least distance."""
    along, across = rectangles[:, 1] - rectangles[:, 0], rectangles[:, 3] - rectangles[:, 0]
    size = np.stack([np.linalg.norm(along, axis=1), np.linalg.norm(across, axis=1)], -1)
    axes = np.stack([along, across], -1) / size[:, None, :]
    local, half = (points - rectangles.mean(axis=1, keepdims=True)) @ axes, size / 2
    gap = np.maximum(local.min(axis=1) - half, -half - local.max(axis=1)).max(axis=-1)
    beyond = np.maximum(np.abs(local) - half[:, None, :], 0.0)
    return gap, np.linalg.norm(beyond, axis=-1).min(axis=1)


def first_encounter(area: DrivingArea, path: SteeringPath, margin: float) -> Encounter | None:
    """Prove that a path keeps a distance from everything in the area.

    Args:
        area: The area.
        path: The path.
        margin: m that it is to keep.

    Returns:
        None if it is proven for every point of the path; else a part that is not.
    """
    n = max(1, int(np.ceil(path.length / FIRST_STEP)))
    step = path.length / n
    middles = (np.arange(n, dtype=float) + 0.5) * step
    while len(middles):
        found = clearances(area, path.poses_at(middles))
        is_open = found.min(axis=1) <= margin + RESERVE + step / 2 * area.truck.sweep
        # A part whose middle is too near itself is a counterexample: halving it would prove nothing.
        is_lost = found.min(axis=1) <= margin + RESERVE
        if is_lost.any() or (is_open.any() and step < LAST_STEP):
            k = int(np.flatnonzero(is_lost if is_lost.any() else is_open)[0])
            nearest = int(found[k].argmin())
            name = WALLS if nearest == 0 else area.boxes[nearest - 1].name
            return Encounter(float(middles[k]), name, float(found[k, nearest]))
        step /= 2
        middles = np.sort(np.concatenate([middles[is_open] - step / 2, middles[is_open] + step / 2]))
    return None
