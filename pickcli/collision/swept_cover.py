"""Spheres that contain everything a turning body passes through: the pivoting cup and what hangs on it."""

from __future__ import annotations

import numpy as np

from pickcli.collision.sphere_cover import Cover, outermost
from pickcli.geometry import Array, rotation_axis_angle

MAX_GROWTH = 0.002  # m, how much a sphere may grow to bridge the gap between two samples
MAX_SAMPLES = 13  # per sphere; large ones grow more instead


def sweep(cover: Cover, axis: Array, angle: float) -> Cover:
    """Spheres containing ``cover`` at every angle in [0, angle] about a unit axis through the origin.

    Proof: at any angle a sphere is within half a sampling step of a sampled one; between the two its centre,
    rho from the axis, moves by a chord of at most 2 rho sin(step / 4), by which the sampled sphere is grown.
    """
    pairs = list(zip(cover.centers, cover.radii, strict=True))
    parts = [_arc(center, radius, axis, angle) for center, radius in pairs]
    spheres = np.concatenate(parts) if parts else np.zeros((0, 4))
    kept = outermost(spheres[:, :3], spheres[:, 3])
    growth = max((float(part[0, 3] - r) for part, r in zip(parts, cover.radii, strict=True)), default=0.0)
    return Cover(spheres[kept, :3], spheres[kept, 3], cover.excess + growth)


def _arc(center: Array, radius: float, axis: Array, angle: float) -> Array:
    """(K, 4) samples of one sphere's way, grown."""
    rho = float(np.linalg.norm(np.cross(axis, center)))
    n = 1 + int(np.ceil(angle * rho / (2 * MAX_GROWTH)))  # 2 rho sin(step / 4) <= rho step / 2
    n = min(n, MAX_SAMPLES)
    angles = np.linspace(0.0, angle, n) if n > 1 else np.array([angle / 2])
    step = angle / (n - 1) if n > 1 else angle
    grown = radius + 2 * rho * np.sin(step / 4)
    return np.array([[*(rotation_axis_angle(axis, a) @ center), grown] for a in angles])
