"""TOPP-RA for constraints in general position, by the authors' own library.

Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
IEEE T-RO 34(3), 2018; github.com/hungpham2511/toppra. Each step of both passes is a linear program in (u, x),
solved by Seidel's algorithm. Importing the library takes 0.3 s, so it is imported at first use.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from types import ModuleType
from typing import Any

import numpy as np

from pickcli.errors import LimitError
from pickcli.geometry import Array
from pickcli.timing.path_constraint import HalfPlanes

BLOCK_SIZE = 16  # half-planes per constraint of the library


def squared_speeds(s: Array, planes: HalfPlanes, fastest: Array) -> Array:
    """Compute the largest x = (ds/dt)^2 from rest to rest, with u = d2s/dt2 constant between gridpoints.

    Args:
        s: (M,) gridpoints, increasing.
        planes: Half-planes of u and x at each interval's start; (M, R), the last row is ignored.
        fastest: (M,) limits of ds/dt.

    Returns:
        (M,) x, 0 at both ends.

    Raises:
        LimitError: If the library finds no motion, which is a bug, because rest is inside all half-planes.
    """
    algorithm, _ = _library()
    constraints = [_constraint(block, fastest) for block in _blocks(planes)]
    solver = algorithm.TOPPRA(constraints, _Path(s), gridpoints=s, solver_wrapper="seidel")
    speeds = solver.compute_parameterization(0.0, 0.0)[1]
    if speeds is None or not np.isfinite(speeds).all():
        raise LimitError("toppra finds no motion along a path on which it may rest anywhere")
    return np.asarray(np.square(speeds))


@cache
def _library() -> tuple[Any, Any]:
    """Import the library's ``algorithm`` and ``constraint``, without the imports for its plots."""
    with _without_matplotlib():
        from toppra import algorithm, constraint
    return algorithm, constraint


@contextmanager
def _without_matplotlib() -> Iterator[None]:
    """Substitute empty modules for matplotlib unless loaded: it is half of the library's import time."""
    names = () if "matplotlib" in sys.modules else ("matplotlib", "matplotlib.pyplot")
    sys.modules.update({name: ModuleType(name) for name in names})
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]


def _blocks(planes: HalfPlanes) -> Iterator[HalfPlanes]:
    """Split the half-planes into blocks, because the library multiplies each by a square matrix F."""
    for first in range(0, planes.a.shape[1], BLOCK_SIZE):
        some = slice(first, first + BLOCK_SIZE)
        yield HalfPlanes(planes.a[:, some], planes.b[:, some], planes.c[:, some])


class _Path:
    """The attributes that the library needs of a path whose constraints are given at the gridpoints."""

    def __init__(self, s: Array) -> None:
        self.path_interval = s[[0, -1]]
        self.dof = 1


def _constraint(planes: HalfPlanes, fastest: Array) -> Any:
    """Convert half-planes to the library's linear constraint F (a u + b x + c) <= g, with F = 1, g = 0."""
    n_rows = planes.a.shape[1]
    x_bound = np.column_stack([np.zeros(len(fastest)), np.square(fastest)])
    given = (planes.a, planes.b, -planes.c, np.eye(n_rows), np.zeros(n_rows), None, x_bound)
    constraint = _library()[1].LinearConstraint()
    constraint.identical = True  # same F and g at all gridpoints
    constraint.compute_constraint_params = lambda path, gridpoints: given
    return constraint
