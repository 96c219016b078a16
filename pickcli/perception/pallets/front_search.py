"""Places where the front of a pallet may be: runners and pockets of its widths alternate along a line.

Points between floor and deck are counted in cells along lines of many directions. A matched filter of the
front, runners full and pockets empty, tells how much it looks like that at each place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import correlate1d, maximum_filter1d

from pickcli.geometry import Array
from pickcli.perception.pallets.pallet_shape import PalletShape
from pickcli.perception.pod_fit import ThinnedPicture

CELL = 0.025  # m, of the cells, along and across the front
TURN = np.radians(2.0)  # between two directions
FLOOR = 0.03  # m above it, from which on points are not of the floor
BESIDE = 2  # cells beside the front that should be empty
BESIDE_SHARE = 0.3  # what these weigh beside the pockets
FULL = 0.5  # of the points that a face would have in a cell, with which it counts as full
LIKELY = 0.3  # of a filter's answer, 1 for a perfect front
N_CANDIDATES = 6
APART, TURNED = 0.08, np.radians(5.0)  # m and rad between candidates


@dataclass(frozen=True, eq=False)
class PalletZone:
    """Where a pallet is expected, in a frame on the floor.

    Attributes:
        pose: (3,) m, m, rad of its frame.
        tolerance: (3,) m, m, rad that it may be off, either way along the axes of ``pose``.
    """

    pose: Array
    tolerance: Array

    def holds(self, pose: Array) -> bool:
        """Whether a pose is within the tolerance.

        Args:
            pose: (3,) m, m, rad.

        Returns:
            True if it is.
        """
        c, s = np.cos(self.pose[2]), np.sin(self.pose[2])
        x, y, yaw = pose - self.pose
        yaw = (yaw + np.pi) % (2 * np.pi) - np.pi
        return bool((np.abs([c * x + s * y, c * y - s * x, yaw]) <= self.tolerance).all())


def pallet_candidates(picture: ThinnedPicture, shape: PalletShape, zone: PalletZone) -> list[Array]:
    """Find places where a pallet may stand.

    Args:
        picture: The picture; its world is the frame on the floor.
        shape: The pallet.
        zone: Where it is expected.

    Returns:
        (3,) poses of the pallet, m, m, rad, the likeliest first.
    """
    points = picture.points
    is_between = (points[:, 2] > FLOOR) & (points[:, 2] < shape.opening)
    camera = picture.T_world_camera[:3, 3]
    reach = float(np.hypot(*zone.tolerance[:2])) + float(np.hypot(shape.length, shape.width)) / 2 + 0.1
    is_near = np.hypot(*(points[:, :2] - zone.pose[:2]).T) < reach
    points = points[is_between & is_near]
    n_turns = int(np.ceil(zone.tolerance[2] / TURN))
    found: list[tuple[float, Array]] = []
    if len(points):
        focal = picture.camera.fx * picture.camera.fy
        for yaw in zone.pose[2] + TURN * np.arange(-n_turns, n_turns + 1):
            found += _along(points, camera, focal, shape, float(yaw))
    wide = PalletZone(zone.pose, zone.tolerance + np.array([CELL, CELL, TURN]))
    kept: list[Array] = []
    for _, pose in sorted(found, key=lambda each: -each[0]):
        is_other = all(
            np.hypot(*(pose - other)[:2]) > APART or abs(pose[2] - other[2]) > TURNED for other in kept
        )
        if is_other and wide.holds(pose) and len(kept) < N_CANDIDATES:
            kept.append(pose)
    return kept


def _along(
    points: Array, camera: Array, focal: float, shape: PalletShape, yaw: float
) -> list[tuple[float, Array]]:
    """Answers of the filter with poses, for one direction: its peaks along the front."""
    c, s = np.cos(yaw), np.sin(yaw)
    u, v = c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]
    taps = _taps(shape)
    u_low, v_low = u.min() - CELL, v.min() - CELL * len(taps)
    n_u, n_v = int((u.max() - u_low) / CELL) + 2, int((v.max() - v_low) / CELL) + len(taps)
    cells = ((u - u_low) / CELL).astype(np.intp) * n_v + ((v - v_low) / CELL).astype(np.intp)
    counts = np.bincount(cells, minlength=n_u * n_v).reshape(n_u, n_v)
    counts = counts[:-1] + counts[1:]  # a front may lie in two rows
    at_u = u_low + CELL * np.arange(1, n_u)
    squares = (at_u - (c * camera[0] + s * camera[1])) ** 2 + camera[2] ** 2
    expected = focal / np.maximum(squares, 0.1) * CELL * (shape.opening - FLOOR)
    full = np.minimum(counts / np.maximum(FULL * expected, 1.0)[:, None], 1.0)
    answers = correlate1d(full, taps, axis=1, mode="constant")
    is_peak = (answers > LIKELY) & (answers == maximum_filter1d(answers, 2 * BESIDE + 1, axis=1))
    found = []
    for row, column in np.argwhere(is_peak):
        front, aside = at_u[row], v_low + CELL * (column + 0.5)
        middle = front - shape.length / 2
        pose = np.array([c * middle - s * aside, s * middle + c * aside, yaw])
        found.append((float(answers[row, column]), pose))
    return found


def _taps(shape: PalletShape) -> Array:
    """(2 K + 1,) weights of the cells along a front: of runners the sum is 1, of all others -1."""
    n = int(np.ceil(shape.width / 2 / CELL)) + BESIDE
    at = CELL * np.arange(-n, n + 1)
    is_runner = ((at[:, None] >= shape.columns[:, 0]) & (at[:, None] <= shape.columns[:, 1])).any(axis=1)
    is_beside = np.abs(at) > shape.width / 2
    empty = np.where(is_beside, BESIDE_SHARE, 1.0) * ~is_runner
    return np.asarray(is_runner / is_runner.sum() - empty / empty.sum())
