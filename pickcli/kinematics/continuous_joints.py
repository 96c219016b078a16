"""Continuous joints: positions that differ by whole turns are the same configuration.

Without continuous joints, all functions return their input.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array

_TURN = 2 * np.pi
_FAR = np.pi / 2  # rad of the short way, from which on the long way may be tried


def unwound_towards(limits: Limits, q: Array, other: Array) -> Array:
    """Return configurations with every continuous joint within half a turn of another configuration.

    Args:
        limits: Limits of the n joints.
        q: (..., n) configurations.
        other: (n,) the other configuration.

    Returns:
        (..., n) equivalent configurations.
    """
    if not limits.is_continuous.any():
        return q
    turns = np.where(limits.is_continuous, np.round((q - other) / _TURN), 0.0)
    return np.asarray(q - _TURN * turns)


def ways_round(limits: Limits, q: Array, other: Array) -> Array:
    """Return ways to reach a configuration from another: the short way, and each joint the long way round.

    Args:
        limits: Limits of the n joints.
        q: (n,) configuration.
        other: (n,) the other configuration.

    Returns:
        (G, n) equivalent configurations, the first from ``unwound_towards``.
    """
    near = unwound_towards(limits, q, other)
    way = near - other
    far = np.flatnonzero(limits.is_continuous & (np.abs(way) > _FAR))
    return np.array([near, *(near - _TURN * np.sign(way[j]) * np.eye(len(q))[j] for j in far)])
