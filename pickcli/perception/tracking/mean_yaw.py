"""Mean of angles of which some are wrong, such as those of an item that was seen back to front.

M. Fischler, R. Bolles, Random sample consensus, 1981, as in Cowley et al. (2013, III-E); a history is short
enough to try every one of its angles instead of random ones.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array

REACH = 3.0  # standard deviations within which an angle agrees with another one


def mean_yaw(angles: Array, deviation: float) -> tuple[float, int]:
    """Average the angles that agree with most others.

    Args:
        angles: (N,) rad, the newest last, N > 0.
        deviation: rad, standard deviation of one that is not wrong.

    Returns:
        rad in [-pi, pi], and the number of angles averaged.
    """
    off = _wrapped(angles[None] - angles[:, None])
    agrees = np.abs(off) <= REACH * deviation
    counts = agrees.sum(axis=1)
    k = len(angles) - 1 - int(np.argmax(counts[::-1]))  # of several such, the newest
    return float(_wrapped(angles[k] + off[k][agrees[k]].mean())), int(counts[k])


def _wrapped(angle: Array) -> Array:
    return np.asarray((angle + np.pi) % (2.0 * np.pi) - np.pi)
