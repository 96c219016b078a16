"""Limits of the speed along a path: joints, the scale of each part, the tool's speed, a path constraint."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.geometry import Array
from pickcli.timing.corner_blending import BlendedPath, distinct
from pickcli.timing.path_constraint import PathConstraint
from pickcli.timing.toppra_closed_form import PathGrid

ToolSpeed: TypeAlias = Callable[[Array, Array], Array]
"""(Q (M, n), dQ/ds (M, n)) -> (M,) m of tool travel per unit of s."""

_TABLE_STEP = 0.03  # joint units between the points at which the tool's speed is tabulated
_FASTEST = 1e3  # ds/dt of a path without any other limit
# Joint units from a boundary to gridpoints on either side. An arm brakes just before a part that limits the
# tool's speed, and is smoothed into it: that is where the speed may have to be lower.
_BESIDE = np.array([0.002, 0.004, 0.008, 0.016, 0.032, 0.064])
PLANE_STEP = 0.03  # joint units between gridpoints, at most, if half-planes limit the speed


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Limits along one blended path that is divided into parts at given s.

    Attributes:
        limits: Limits of the joints.
        edges: (P + 1,) s of the part boundaries, not decreasing.
        scales: (P,) factor on velocity, acceleration and jerk limits of each part.
        tool_caps: (P,) m/s, inf for a part without a limit.
        table_s: s at which the tool's speed is tabulated.
        table_speed: m of tool travel per unit of s, at ``table_s``.
        constraint: Constraint on the whole path besides the joint limits; None if there is none.
    """

    limits: Limits
    edges: Array
    scales: Array
    tool_caps: Array
    table_s: Array
    table_speed: Array
    constraint: PathConstraint | None = None

    def lowest(self, values: Array, start: Array, end: Array) -> Array:
        """Return the smallest value of the parts that each interval touches, or of the nearest part.

        Args:
            values: (P,) one value for each part.
            start: (M,) s of the interval starts.
            end: (M,) s of the interval ends.

        Returns:
            (M,).
        """
        if (values == values[0]).all():
            return np.full(len(start), values[0])
        start, end = np.minimum(start, self.edges[-1]), np.maximum(end, self.edges[0])
        touched = (self.edges[:-1, None] <= end) & (self.edges[1:, None] >= start)
        return np.asarray(np.where(touched, values[:, None], np.inf).min(axis=0))

    def tool_speed(self, s: Array) -> Array:
        """Return the tool travel per unit of s.

        Args:
            s: (M,) path parameters.

        Returns:
            (M,) m; 0 where no part limits the tool's speed.
        """
        if len(self.table_s) == 0:
            return np.zeros(len(s))
        return np.interp(s, self.table_s, self.table_speed, left=0.0, right=0.0)

    def shifted(self, by: float) -> PathBounds:
        """Return the bounds for the part of the path after a given s.

        Args:
            by: Path parameter s at which the other path starts.

        Returns:
            The shifted bounds.
        """
        return replace(self, edges=self.edges - by, table_s=self.table_s - by)

    def grid(
        self, curve: BlendedPath, acceleration_share: float, jerk_share: float, cruise: float
    ) -> PathGrid:
        """Build the grid on the path's knots, part boundaries and the tool's table, with all speed limits.

        Args:
            curve: The blended path.
            acceleration_share: Share of the acceleration limits that may be used.
            jerk_share: Share of the jerk limits that the path's own third derivative may use up: (ds/dt)^3
                |q'''| <= jerk_share * jerk.
            cruise: s, least duration of the cruise on a straight line (see ``PathGrid``).

        Returns:
            The grid.
        """
        even = np.arange(0.0, curve.length, PLANE_STEP) if self.constraint else np.empty(0)
        inner = self.edges[1:-1, None] if len(self.table_s) else np.empty((0, 1))
        beside = np.concatenate([inner - _BESIDE, inner + _BESIDE])
        nodes = np.concatenate([self.edges, beside.ravel(), self.table_s, even])
        s = distinct(np.concatenate([curve.knots, nodes[(nodes > 0.0) & (nodes < curve.length)]]))
        q, dq, ddq, dddq = curve.evaluate_all(s)
        here, between = self.lowest(self.scales, s, s), self.lowest(self.scales, s[:-1], s[1:])
        speed = self._speed(s, dq, here)
        line_speed = np.minimum(speed[1:], speed[:-1])
        third = np.maximum(np.abs(dddq), 1e-9)
        by_jerk = np.cbrt((jerk_share * here[:, None] * self.limits.jerk / third).min(axis=1))
        acceleration = acceleration_share * between[:, None] * self.limits.acceleration
        is_line = curve.is_line(s[:-1], s[1:])
        planes = self.constraint.half_planes(q, dq, ddq) if self.constraint else None
        speed = np.minimum(speed, by_jerk)
        return PathGrid(s, dq, ddq, acceleration, speed, line_speed, is_line, cruise, planes)

    def _speed(self, s: Array, dq: Array, scale: Array) -> Array:
        """Return (M,) ds/dt allowed by joint velocities and the tool's speed."""
        by_joints = (scale[:, None] * self.limits.velocity / np.maximum(np.abs(dq), 1e-9)).min(axis=1)
        by_tool = self.lowest(self.tool_caps, s, s) / np.maximum(self.tool_speed(s), 1e-9)
        return np.asarray(np.minimum(np.minimum(by_joints, by_tool), _FASTEST))


def path_bounds(
    curve: BlendedPath,
    limits: Limits,
    edges: Array,
    scales: Array,
    tool_caps: Array,
    tool_speed: ToolSpeed | None,
    constraint: PathConstraint | None = None,
) -> PathBounds:
    """Build the bounds along a path, with the tool's speed tabulated along the parts that limit it.

    Args:
        curve: The blended path.
        limits: Limits of the joints.
        edges: (P + 1,) s of the part boundaries, not decreasing.
        scales: (P,) factor on velocity, acceleration and jerk limits of each part.
        tool_caps: (P,) m/s, inf for a part without a limit.
        tool_speed: Configurations and dq/ds to m of tool travel per unit of s.
        constraint: Constraint on the whole path besides the joint limits.

    Returns:
        The bounds.

    Raises:
        ValueError: If a part limits the tool's speed and ``tool_speed`` is None.
    """
    capped = [(edges[i], edges[i + 1]) for i in np.flatnonzero(np.isfinite(tool_caps))]
    if capped and tool_speed is None:
        raise ValueError("a part limits the tool's speed: time_run needs jacobian_speed")
    pieces = [np.linspace(a, b, int(np.ceil((b - a) / _TABLE_STEP)) + 2) for a, b in capped if b > a]
    if not pieces or tool_speed is None:
        return PathBounds(limits, edges, scales, tool_caps, np.empty(0), np.empty(0), constraint)
    inner = [curve.knots[(curve.knots > a) & (curve.knots < b)] for a, b in capped]
    s = distinct(np.concatenate(pieces + inner))
    q, dq = curve.evaluate_all(s, 1)
    speed = np.asarray(tool_speed(q, dq), dtype=float)
    return PathBounds(limits, edges, scales, tool_caps, s, speed, constraint)
