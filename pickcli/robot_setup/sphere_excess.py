"""Measures how far the spheres of a robot's links extend beyond their shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Link
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.robot_model import CollisionModel
from pickcli.collision.sphere_cover import Cover
from pickcli.geometry import Array, pose
from pickcli.verification.fcl_solids import Solid

N_SPHERE_POINTS = 16  # sample points on each sphere
POINT = Shape(ShapeKind.SPHERE, (1e-6,))


@dataclass(frozen=True)
class SphereExcess:
    """Excess of the spheres of one link.

    Attributes:
        link: Name of the link.
        n_spheres: Number of spheres.
        mean_excess: m beyond the link's shapes, mean over the outer surface of the spheres.
        max_excess: m beyond the link's shapes, at most.
    """

    link: str
    n_spheres: int
    mean_excess: float
    max_excess: float


def sphere_excess(cell: Cell, model: CollisionModel) -> list[SphereExcess]:
    """Measure the spheres of every moving link.

    Args:
        cell: The cell.
        model: Its collision model.

    Returns:
        Results by link, from the base outwards; links without shapes are left out.
    """
    return [
        SphereExcess(name, len(cover.radii), mean_excess(cell.robot.link(name), cover), cover.excess)
        for name, cover in model.covers.items()
        if len(cover.radii)
    ]


def mean_of(figures: list[SphereExcess]) -> float:
    """Compute the mean excess over all spheres.

    Args:
        figures: Results of the links.

    Returns:
        m.
    """
    n = sum(each.n_spheres for each in figures)
    return sum(each.n_spheres * each.mean_excess for each in figures) / n if n else 0.0


def mean_excess(link: Link, cover: Cover) -> float:
    """Compute the mean distance from a link's shapes to the outer surface of its spheres.

    Args:
        link: The link.
        cover: Its spheres.

    Returns:
        m.
    """
    points = _outer_points(cover)
    solids = [Solid(body.shape) for body in link.bodies]
    for solid, body in zip(solids, link.bodies, strict=True):
        solid.place(body.T_parent_shape)
    probe, distances = Solid(POINT), []
    for point in points:
        probe.place(pose(point))
        distances.append(min(probe.distance(solid) for solid in solids))
    return float(np.mean(distances)) if distances else 0.0


def _outer_points(cover: Cover) -> Array:
    """Points (N, 3) spread over all spheres, without those inside other spheres."""
    k = np.arange(N_SPHERE_POINTS) + 0.5
    z, angle = 1.0 - 2.0 * k / N_SPHERE_POINTS, np.pi * (1.0 + np.sqrt(5.0)) * k  # Fibonacci's lattice
    flat = np.sqrt(1.0 - z**2)
    directions = np.column_stack([flat * np.cos(angle), flat * np.sin(angle), z])
    points = (cover.centers[:, None] + cover.radii[:, None, None] * directions).reshape(-1, 3)
    inside = np.linalg.norm(points[:, None] - cover.centers[None], axis=2) < cover.radii[None] - 1e-9
    return np.asarray(points[~inside.any(axis=1)])
