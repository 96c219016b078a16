"""Helpers of the collision tests: items, points of links, and the types of the fixtures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array, transform_points
from pickcli.scene.scene import Scene

MakeScene = Callable[..., Scene]
MakeChecker = Callable[..., SceneChecker]


def box_item(size: tuple[float, float, float], name: str = "carton") -> Item:
    shape = Shape(ShapeKind.BOX, size)
    seals = dict.fromkeys(shape.face_names, 1.0)
    return Item(name, 2016, shape, 0.2, 0, seals, "test", "", 0.0, 1.0, "", "test")


def link_points(cell: Cell, name: str, rng: np.random.Generator, n: int = 400) -> Array:
    """Random points on and in the shapes of a link, in its frame."""
    clouds = []
    for body in cell.robot.link(name).bodies:
        unit = rng.uniform(-1, 1, (n, 3))
        unit[::2] = np.where(rng.random((len(unit[::2]), 3)) < 0.5, np.sign(unit[::2]), unit[::2])
        points = unit * body.shape.extents / 2
        if body.shape.kind is ShapeKind.SPHERE:
            points *= np.minimum(1, body.shape.size[0] / np.linalg.norm(points, axis=1))[:, None]
        if body.shape.kind is ShapeKind.CYLINDER:
            across = np.linalg.norm(points[:, :2], axis=1)
            points[:, :2] *= np.minimum(1, body.shape.size[0] / across)[:, None]
        clouds.append(transform_points(body.T_parent_shape, points))
    return np.concatenate(clouds)
