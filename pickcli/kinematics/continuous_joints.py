"""Continuous joints: positions that differ by whole turns are one configuration.

Without a continuous joint every function here gives back what it gets.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array

_TURN = 2 * np.pi
_FAR = np.pi / 2  # rad of the short way from which the long way round may be worth trying


def turned_towards(limits: Limits, q: Array, other: Array) -> Array:
    """A configuration with every continuous joint within half a turn of another configuration.

    Args:
        limits: Limits of the n joints.
        q: (..., n) configurations.
        other: (n,) the other configuration.

    Returns:
        (..., n) the same configurations.
    """
    if not limits.is_continuous.any():
        return q
    turns = np.where(limits.is_continuous, np.round((q - other) / _TURN), 0.0)
    return np.asarray(q - _TURN * turns)


def ways_round(limits: Limits, q: Array, other: Array) -> Array:
    """A configuration as it is reached from another: the short way, and one joint each the long way round.

    Args:
        limits: Limits of the n joints.
        q: (n,) configuration.
        other: (n,) the other configuration.

    Returns:
        (G, n) the same configuration, first as ``turned_towards`` has it.
    """
    near = turned_towards(limits, q, other)
    way = near - other
    far = np.flatnonzero(limits.is_continuous & (np.abs(way) > _FAR))
    return np.array([near, *(near - _TURN * np.sign(way[j]) * np.eye(len(q))[j] for j in far)])
