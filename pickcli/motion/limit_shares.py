"""How much of its limits a trajectory uses: velocity, acceleration and jerk of every joint over time."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory

PER_BIN = 4  # samples between two times, of which the largest is returned


def limits_of(cell: Cell) -> tuple[Array, Array, Array]:
    """Return a cell's limits of velocity, acceleration and jerk, scaled by its speed.

    Args:
        cell: The cell.

    Returns:
        (n,) each.
    """
    limits, scale = cell.robot.limits, cell.speed_scale
    return limits.velocity * scale, limits.acceleration * scale, limits.jerk


def limit_shares(trajectory: Trajectory, cell: Cell, times: Array, derivative: int) -> Array:
    """Return one derivative of a trajectory over its limits, at each time the largest until the next.

    Args:
        trajectory: The trajectory.
        cell: The cell whose limits apply.
        times: (N,) s, in ascending order.
        derivative: 1 for velocity, 2 for acceleration, 3 for jerk.

    Returns:
        (N, n).
    """
    steps = np.arange(PER_BIN) / PER_BIN
    fine = (times[:, None] + np.append(np.diff(times), 0.0)[:, None] * steps).ravel()
    values = trajectory.sample(fine, derivative).reshape(len(times), PER_BIN, -1)
    largest = np.abs(values).argmax(axis=1)
    found = np.take_along_axis(values, largest[:, None], axis=1)[:, 0]
    return np.asarray(found / limits_of(cell)[derivative - 1])
