"""Checks obstacles that a script adds to a cell: the kernel and the verifier rely on sound solids."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from pickcli.cell.shapes import Body, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import is_pose

MAX_SIZE = 100.0  # m, beyond which a size is taken for another unit
_SIZES = {
    ShapeKind.BOX: "x, y and z",
    ShapeKind.CYLINDER: "a radius and a length",
    ShapeKind.SPHERE: "a radius",
}
_N_SIZES = {ShapeKind.BOX: 3, ShapeKind.CYLINDER: 2, ShapeKind.SPHERE: 1}


def check_obstacles(obstacles: Sequence[Body], taken: Iterable[str]) -> None:
    """Check that obstacles have names of their own, sizes over or at 0, and rigid poses.

    Args:
        obstacles: Static solids, in the world frame.
        taken: Names of the links and solids of the cell.

    Raises:
        InputError: The first mistake.
    """
    known = set(taken)
    for body in obstacles:
        if not isinstance(body, Body):
            raise InputError(f"obstacle {body!r}: expected a Body, got {type(body).__name__}; use box(...)")
        if body.name in known:
            raise InputError(f"obstacle {body.name!r}: the cell has something of that name; choose another")
        known.add(body.name)
        kind, size = body.shape.kind, np.asarray(body.shape.size, dtype=float)
        if kind is ShapeKind.HULL:
            raise InputError(f"obstacle {body.name!r}: is a hull; make it of boxes, cylinders and spheres")
        if len(size) != _N_SIZES[kind] or not ((size >= 0.0) & (size <= MAX_SIZE)).all():
            raise InputError(
                f"obstacle {body.name!r}: expected the sizes of a {kind}, {_SIZES[kind]}, from 0 to "
                f"{MAX_SIZE:g} m, got {size.tolist()}; of a box, is a lower corner over the upper one?"
            )
        if not is_pose(body.T_parent_shape):
            raise InputError(f"obstacle {body.name!r}: its pose is not a rigid one, (4, 4); use pose(...)")
