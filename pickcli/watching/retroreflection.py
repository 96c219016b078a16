"""How brightly vests and reflectors throw the flash back, as a coefficient of retroreflection in cd/lx/m^2.

The coefficients are those that EN ISO 20471 asks of a new stripe at least, rounded: by the angle of
observation, between lamp and lens as the stripe sees them, and by the entrance angle to its normal. A white
matte surface has 1 / pi.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array

OBSERVATION = np.radians([0.2, 1 / 3, 1.0, 1.5, 4.0])
COEFFICIENT = np.array([330.0, 250.0, 25.0, 10.0, 1.0])  # near the normal; the last one is ours
ENTRANCE = np.radians([5.0, 20.0, 30.0, 40.0, 60.0, 75.0])
SHARE = np.array([1.0, 0.88, 0.55, 0.2, 0.02, 0.0])  # of it; beyond 40 degrees ours
STRIPE = 0.05  # m, width of a stripe
BAND_HEIGHTS = (0.945, 1.225)  # m of the middles of both bands around the body of a person of 1.75 m
SHOULDERS = np.radians([-150.0, -30.0, 30.0, 150.0])  # of the stripes upwards, around the body
TORSO = 0.17  # m, radius of the body
TORSO_ENDS = (0.85, 1.45)  # m above the floor


def retroreflection(observation: Array, entrance: Array) -> Array:
    """Return the coefficient of a stripe.

    Args:
        observation: (...) rad between lamp and lens, as the stripe sees them.
        entrance: (...) rad between the ray and the normal of the stripe.

    Returns:
        (...) cd/lx/m^2, log-linear between the angles of the table.
    """
    straight = np.exp(np.interp(observation, OBSERVATION, np.log(COEFFICIENT)))
    return np.asarray(straight * np.interp(entrance, ENTRANCE, SHARE))


def stripe_cover(around: Array, above: Array, across: Array, upright: Array) -> Array:
    """Return how much of a vest's pixels is stripes: two bands around, four stripes over the shoulders.

    Args:
        around: (N,) rad around the body from the front.
        above: (N,) m above the floor, of a person of 1.75 m.
        across: (N,) m that a pixel covers along the surface, sideways.
        upright: (N,) m that it covers upwards.

    Returns:
        (N,) from 0 to 1.
    """
    bare = np.ones_like(above)
    for middle in BAND_HEIGHTS:
        bare = bare * (1 - _overlap(above - middle, upright))
    shoulders = np.zeros_like(above)
    for middle in SHOULDERS:
        off = TORSO * ((around - middle + np.pi) % (2 * np.pi) - np.pi)
        shoulders = np.maximum(shoulders, _overlap(off, across))
    return np.asarray(1 - bare * (1 - np.where(above > BAND_HEIGHTS[0], shoulders, 0.0)))


def _overlap(off: Array, size: Array) -> Array:
    """(N,) share of a pixel of a size in m, off the middle of a stripe by m, that the stripe covers."""
    inside = np.minimum(off + size / 2, STRIPE / 2) - np.maximum(off - size / 2, -STRIPE / 2)
    return np.asarray(np.clip(inside / size, 0.0, 1.0))
