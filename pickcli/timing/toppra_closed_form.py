"""Time-optimal path parametrisation by reachability analysis (TOPP-RA) in closed form.

Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability Analysis",
IEEE T-RO 34(3), 2018. With x = (ds/dt)^2 and u = d2s/dt2, constant between gridpoints, every acceleration
limit is a strip |u - m x| <= c. All strips contain the origin, so the controllable sets are intervals
[0, X] and both passes need no linear programs: each step is a minimum over the strips. Both are chains of
a few thousand numbers, and the kernel runs them.

With half-planes in general position, like a load's, each step is a linear program, which toppra solves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.kernel import fastest_pace
from pickcli.timing.path_constraint import HalfPlanes
from pickcli.timing.toppra_solver import squared_speeds

_STANDING = 1e-12  # ds/dt: guards a division


@dataclass(frozen=True, eq=False)
class PathGrid:
    """A path and its limits: states at M gridpoints, M - 1 intervals between them.

    On an interval that is a straight line the profile is exact (accelerate, cruise, brake) without gridpoints
    in between, and its cruise lasts at least ``cruise``. If ``planes`` also limit the speed, a line is
    treated like any other interval.

    Attributes:
        s: (M,) path parameters, increasing.
        dq: (M, n) dq/ds.
        ddq: (M, n) d2q/ds2.
        acceleration: (M - 1, n) limits on each interval.
        speed: (M,) limit of ds/dt, finite.
        line_speed: (M - 1,) limit of ds/dt inside each interval, used on lines only.
        is_line: (M - 1,) whether the interval is a line.
        cruise: s, least duration of a cruise.
        planes: Half-planes at the M gridpoints, or None.
    """

    s: Array
    dq: Array
    ddq: Array
    acceleration: Array
    speed: Array
    line_speed: Array
    is_line: NDArray[np.bool_]
    cruise: float = 0.0
    planes: HalfPlanes | None = None


@dataclass(frozen=True, eq=False)
class VelocityProfile:
    """A time-optimal motion along a path: ds/dt is linear in t between the points.

    Attributes:
        t: (P,) s, strictly increasing from 0.
        s: (P,) path parameters.
        v: (P,) ds/dt, 0 at both ends.
    """

    t: Array
    s: Array
    v: Array

    @property
    def duration(self) -> float:
        """Duration from rest to rest, s."""
        return float(self.t[-1])


def parametrize(grid: PathGrid) -> VelocityProfile:
    """Compute the fastest motion along a path from rest to rest; limits hold at both ends of each interval.

    Args:
        grid: The path and its limits.

    Returns:
        The velocity profile.
    """
    if grid.planes is not None:
        v = np.sqrt(squared_speeds(grid.s, _at_both_ends(grid, grid.planes), grid.speed))
        dt = 2.0 * np.diff(grid.s) / np.maximum(v[1:] + v[:-1], _STANDING)
        return VelocityProfile(np.concatenate([[0.0], np.cumsum(dt)]), grid.s, v)
    is_line = grid.is_line.astype(np.int32)
    return VelocityProfile(
        *fastest_pace(
            grid.s, grid.dq, grid.ddq, grid.acceleration, grid.speed, grid.line_speed, is_line, grid.cruise
        )
    )


def _at_both_ends(grid: PathGrid, planes: HalfPlanes) -> HalfPlanes:
    """Return all limits on u and x at the start of every interval, including those at its end.

    At the end, x is x + 2 ds u ("interpolation scheme" of Pham and Pham). Joints: |dq u + ddq x| <= limit.
    """
    limit = np.concatenate([grid.acceleration, grid.acceleration[-1:]])
    before = np.concatenate([grid.acceleration[:1], grid.acceleration])
    a = np.concatenate([grid.dq, -grid.dq, planes.a], axis=1)
    b = np.concatenate([grid.ddq, -grid.ddq, planes.b], axis=1)
    c_start = np.concatenate([limit, limit, planes.c], axis=1)
    c_end = np.concatenate([before, before, planes.c], axis=1)
    step = 2.0 * np.diff(grid.s)[:, None]
    ends = a[1:] + step * b[1:], b[1:], c_end[1:]
    # No interval starts at the last gridpoint.
    return HalfPlanes(
        *(
            np.concatenate([start, np.concatenate([end, start[-1:]])], axis=1)
            for start, end in zip((a, b, c_start), ends, strict=True)
        )
    )
