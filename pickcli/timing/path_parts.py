"""Parts of a path that is blended as a whole: where one segment ends and the next begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment
from pickcli.timing.corner_blending import DEPTH, BlendedPath, Indices
from pickcli.timing.polyline_simplification import NOWHERE, POINT_TOLERANCE


@dataclass(frozen=True, eq=False)
class PathParts:
    """Parts of a polyline, with the tolerances of their blends.

    The corner between two parts is blended as widely as either allows, and that blend belongs to the part
    that allows more: a straight line ends where the path leaves it for a coarse motion, not in the middle of
    the blend. The blend takes half of the line at most. Between parts that allow the same, the boundary is in
    the middle.

    Attributes:
        waypoints: (N, n) polyline of all parts.
        edges: (P + 1,) indices of the waypoints at which the parts begin, and of the last.
        blends: (P,) bounds on the distance between path and polyline, in joint units; 0 stops at each corner
            of a part, the ones at its ends included.
    """

    waypoints: Array
    edges: Indices
    blends: Array

    @classmethod
    def of(cls, segments: Sequence[PathSegment]) -> PathParts:
        """Join the paths of segments to one polyline.

        Args:
            segments: At least one, each starting at the end of the one before.

        Returns:
            Their parts.

        Raises:
            ValueError: If there is none, or two do not join.
        """
        if not segments:
            raise ValueError("a run needs at least one segment")
        rows, edges = [segments[0].waypoints[:1]], [0]
        for index, segment in enumerate(segments):
            gap = float(np.abs(segment.waypoints[0] - rows[-1][-1]).max())
            if gap > NOWHERE:
                where = f"segment {index} ({segment.kind})"
                raise ValueError(f"{where} starts {gap:.3g} from where the one before it ends")
            rows.append(segment.waypoints[1:])
            edges.append(edges[-1] + len(segment.waypoints) - 1)
        blends = np.array([segment.limits.blend_tolerance for segment in segments])
        return cls(np.concatenate(rows), np.array(edges), blends)

    @property
    def tolerances(self) -> Array:
        """(N,) bounds on the distance to the polyline near each waypoint, in joint units."""
        tolerances = np.empty(len(self.waypoints))
        tolerances[0] = self.blends[0]
        for start, end, blend in zip(self.edges[:-1], self.edges[1:], self.blends, strict=True):
            tolerances[start + 1 : end + 1] = blend
        before, after = self.blends[:-1], self.blends[1:]
        narrow, wide = np.minimum(before, after), np.maximum(before, after)
        allowed = np.maximum(narrow, np.minimum(wide, DEPTH * self._turns * self._most_given))
        tolerances[self.edges[1:-1]] = np.where(narrow == 0.0, 0.0, allowed)
        return tolerances

    def boundaries(self, curve: BlendedPath) -> Array:
        """Return where the parts begin and end on a blended path.

        Args:
            curve: The polyline, blended.

        Returns:
            (P + 1,) path parameters s, not decreasing.
        """
        s = curve.waypoint_s[self.edges]
        given = np.minimum(self._reaches(curve, s[1:-1]), self._most_given)
        s[1:-1] += np.sign(self.blends[:-1] - self.blends[1:]) * given
        return np.maximum.accumulate(np.clip(s, 0.0, curve.length))

    def _reaches(self, curve: BlendedPath, s: Array) -> Array:
        """(P - 1,) how far the blends of the wider part, and of its edge, reach over the inner edges at s."""
        beyond = (curve.corner_s - s[:, None]) * np.sign(self.blends[1:] - self.blends[:-1])[:, None]
        reach = np.where(beyond >= -2 * POINT_TOLERANCE, curve.half_lengths - beyond, 0.0)
        return np.asarray(np.maximum(reach.max(axis=1), 0.0))

    @cached_property
    def _most_given(self) -> Array:
        """(P - 1,) joint units of the narrower part that the blend with its neighbour may take: half."""
        steps = np.linalg.norm(np.diff(self.waypoints, axis=0), axis=1)
        lengths = np.array([steps[a:b].sum() for a, b in pairwise(self.edges.tolist())])
        return np.where(self.blends[:-1] < self.blends[1:], lengths[:-1], lengths[1:]) / 2

    @cached_property
    def _turns(self) -> Array:
        """(P - 1,) change of the unit direction at the inner edges."""
        steps = np.diff(self.waypoints, axis=0)
        unit = np.zeros((len(steps) + 2, self.waypoints.shape[1]))  # none before the first waypoint, or after
        unit[1:-1] = steps / np.maximum(np.linalg.norm(steps, axis=1), POINT_TOLERANCE)[:, None]
        inner = self.edges[1:-1]
        return np.asarray(np.linalg.norm(unit[inner + 1] - unit[inner], axis=1))
