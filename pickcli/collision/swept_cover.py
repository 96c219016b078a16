"""Spheres that contain the volume that a body sweeps while one joint moves it: the cup and a held item."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from pickcli.cell.robot import Joint, JointType, joint_motion
from pickcli.collision.sphere_cover import Cover, outermost
from pickcli.geometry import Array, rotation_axis_angle

MAX_GROWTH = 0.002  # m that a sphere may be enlarged to bridge the gap between two samples
MAX_SAMPLES = 13  # per sphere; large spheres are enlarged more instead


def sweep(cover: Cover, joint: Joint, least: float, most: float) -> Cover:
    """Return spheres that contain ``cover`` at every position of a joint between two bounds.

    Proof: at any position a sphere is within half a sampling step of a sampled one; between the two its
    centre moves by at most half the step of a prismatic joint, or by a chord of at most 2 rho sin(step / 4)
    about an axis at a distance rho. The sampled sphere is enlarged by that.

    Args:
        cover: In the frame of the joint's child, at position 0.
        joint: Revolute or prismatic, its axis through the origin of that frame.
        least: rad or m, the lower bound.
        most: rad or m, the upper bound.

    Returns:
        Spheres in that frame; their excess includes the enlargement.
    """
    start, way = (least, most - least) if abs(least) <= abs(most) else (most, least - most)
    if start != 0.0:
        T = joint_motion(joint, start)
        cover = Cover(cover.centers @ T[:3, :3].T + T[:3, 3], cover.radii, cover.excess)
    track = _line if joint.type is JointType.PRISMATIC else _arc
    axis, length = joint.axis * np.sign(way), abs(way)
    pairs = list(zip(cover.centers, cover.radii, strict=True))
    parts = [track(center, radius, axis, length) for center, radius in pairs]
    spheres = np.concatenate(parts) if parts else np.zeros((0, 4))
    kept = outermost(spheres[:, :3], spheres[:, 3])
    growth = max((float(part[0, 3] - r) for part, r in zip(parts, cover.radii, strict=True)), default=0.0)
    return Cover(spheres[kept, :3], spheres[kept, 3], cover.excess + growth)


def _line(center: Array, radius: float, axis: Array, length: float) -> Array:
    """Return (K, 4) enlarged samples of one sphere's path along an axis."""
    n = min(2 + int(length / (2 * MAX_GROWTH)), MAX_SAMPLES)
    places, step = np.linspace(0.0, length, n, retstep=True)
    return np.array([[*(center + s * axis), radius + step / 2] for s in places])


def _arc(center: Array, radius: float, axis: Array, angle: float) -> Array:
    """Return (K, 4) enlarged samples of one sphere's path about an axis."""
    rho = float(np.linalg.norm(np.cross(axis, center)))
    n = 1 + int(np.ceil(angle * rho / (2 * MAX_GROWTH)))  # 2 rho sin(step / 4) <= rho step / 2
    n = min(n, MAX_SAMPLES)
    angles = np.linspace(0.0, angle, n) if n > 1 else np.array([angle / 2])
    step = angle / (n - 1) if n > 1 else angle
    grown = radius + 2 * rho * np.sin(step / 4)
    turned = _rotations(tuple(axis.tolist()), tuple(angles.tolist())) @ center
    return np.column_stack([turned, np.full(n, grown)])


@lru_cache(maxsize=64)  # the spheres of a cover share a few sets of angles
def _rotations(axis: tuple[float, float, float], angles: tuple[float, ...]) -> Array:
    """Return (K, 3, 3) rotations by angles about one axis."""
    return np.array([rotation_axis_angle(axis, angle) for angle in angles])
