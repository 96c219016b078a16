"""Vacuum under a cup whose lip stands over the edges of a face that is narrower than the cup.

Beyond each edge a segment of the lip's disc stays open. Air comes in there as through a sharp-edged orifice,
with the discharge coefficient and the expansion factor of ISO 5167 (docs/formats/items.md):

    Q0 (1 - s) = Q0 s (1 - seal) / seal + c Y A sqrt(2 dp / rho),  dp = s * full vacuum

Q0 is the free air that the pump draws, s the share of full vacuum that it keeps, seal the share that it would
keep if the face reached under the whole lip, and A the open area.
"""

from __future__ import annotations

import math

import numpy as np

from pickcli.geometry import Array

DISCHARGE = 0.61  # coefficient of a sharp-edged orifice
EXPANSION = 0.41 / 1.4  # of air, per pressure drop over the pressure in front
AMBIENT = 101.3e3  # Pa
DENSITY = 1.2  # kg/m^3 of air
FULL_VACUUM = 60e3  # Pa below ambient that the pump reaches on a closed line
N_HALVINGS = 40  # of the interval that holds the share
LITRES_PER_MINUTE = 1e-3 / 60.0  # m^3/s


def open_area(radius: float, rooms: Array) -> Array:
    """Return the area of a lip's disc beyond the edges of a face.

    Args:
        radius: m, of the lip.
        rooms: (..., E) m from the middle of the lip to each edge, negative if it is beyond the edge.

    Returns:
        (...) m^2. Corners, where two edges meet, are counted twice.
    """
    d = np.clip(rooms, -radius, radius)
    segments = radius**2 * np.arccos(d / radius) - d * np.sqrt(radius**2 - d**2)
    return np.asarray(segments.sum(axis=-1))


def kept_vacuum(seal: float, area: float, flow: float) -> float:
    """Return the share of full vacuum that a pump keeps under a lip that is open in part.

    Args:
        seal: Share that it keeps under a lip that the face covers, in [0, 1].
        area: m^2 that are open.
        flow: l/min of free air that the pump draws.

    Returns:
        The share; the seal itself if nothing is open.
    """
    if area <= 0.0 or seal <= 0.0:
        return seal
    free_air = flow * LITRES_PER_MINUTE
    low, high = 0.0, seal
    for _ in range(N_HALVINGS):  # what comes in grows with the share, what the pump draws falls
        share = (low + high) / 2.0
        drop = share * FULL_VACUUM
        expansion = 1.0 - EXPANSION * drop / AMBIENT
        through = DISCHARGE * expansion * area * math.sqrt(2.0 * drop / DENSITY)
        is_too_much = through + free_air * share / seal > free_air
        low, high = (low, share) if is_too_much else (share, high)
    return low
