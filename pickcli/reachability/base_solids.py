"""Solids that are fixed to a robot's base, and their collisions."""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.robot_model import CollisionModel
from pickcli.scene.solid_overlap import PosedSolid, overlap_depth


def base_solids(model: CollisionModel) -> list[PosedSolid]:
    """Return the solids that are fixed to a robot's base: its shapes, and the spheres around its hulls.

    Args:
        model: The robot's collision model in its cell.

    Returns:
        The solids, in the world.
    """
    bodies = [PosedSolid(body.shape, T @ body.T_parent_shape) for _, T, body in model.static_bodies()]
    return bodies + [PosedSolid(Shape(ShapeKind.SPHERE, (r,)), T) for _, T, r in model.static_spheres()]


def overlaps(a: PosedSolid, b: PosedSolid) -> bool:
    """Whether two solids overlap; fast if their bounding spheres are apart.

    Args:
        a: One solid.
        b: The other.

    Returns:
        True if they do.
    """
    balls = sum(each.shape.bounding_radius for each in (a, b))
    return bool(np.linalg.norm(a.center - b.center) < balls) and overlap_depth(a, b) > 0.0
