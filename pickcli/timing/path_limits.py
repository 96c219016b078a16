"""What limits the pace along a path: joints, the scale of each part, the tool's speed, what it carries."""

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

_TABLE_STEP = 0.03  # joint units between the points where the tool's speed is evaluated
_FASTEST = 1e3  # ds/dt of a path that nothing else limits
PLANE_STEP = 0.03  # joint units between gridpoints, at most, where half-planes limit the pace


@dataclass(frozen=True, eq=False)
class PathBounds:
    """Limits along one curve whose parts end at given s.

    edges: (P + 1,) s of the part boundaries, not decreasing; scales: (P,) of velocity, acceleration and
    jerk limits; tool_caps: (P,) m/s, inf where none; table_s, table_speed: tool travel per unit of s;
    constraint: on the whole curve, beyond the joints' own limits.
    """

    limits: Limits
    edges: Array
    scales: Array
    tool_caps: Array
    table_s: Array
    table_speed: Array
    constraint: PathConstraint | None = None

    def lowest(self, values: Array, start: Array, end: Array) -> Array:
        """Smallest of the parts' ``values`` (P,) on every interval [start, end] (M,)."""
        touched = (self.edges[:-1] <= end[:, None]) & (self.edges[1:] >= start[:, None])
        return np.asarray(np.where(touched, values, np.inf).min(axis=1))

    def tool_speed(self, s: Array) -> Array:
        """m of tool travel per unit of s, at s (M,); 0 where no part has a cap."""
        if len(self.table_s) == 0:
            return np.zeros(len(s))
        return np.interp(s, self.table_s, self.table_speed, left=0.0, right=0.0)

    def shifted(self, by: float) -> PathBounds:
        """The same bounds for a curve that starts at s = ``by`` of this one."""
        return replace(self, edges=self.edges - by, table_s=self.table_s - by)

    def grid(
        self, curve: BlendedPath, acceleration_share: float, jerk_share: float, cruise: float
    ) -> PathGrid:
        """Gridpoints on the curve's knots, part boundaries and the tool's table, with all speed limits.

        acceleration_share: of the acceleration limits; jerk_share: of the jerk limits that the path's own
            third derivative may use up, (ds/dt)^3 |q'''| <= jerk_share * jerk; cruise: see Grid
        """
        even = np.arange(0.0, curve.length, PLANE_STEP) if self.constraint else np.empty(0)
        marks = np.concatenate([self.edges, self.table_s, even])
        s = distinct(np.concatenate([curve.knots, marks[(marks > 0.0) & (marks < curve.length)]]))
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
        """(M,) ds/dt allowed by joint velocities and the tool's speed."""
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
    """Bounds with the tool's speed tabulated along the parts that have a cap.

    Raises ValueError if a part has a cap and no ``tool_speed`` is given.
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
