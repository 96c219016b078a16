"""Parts of a path that is blended as a whole: where one segment ends and the next begins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.segment import PathSegment
from pickcli.timing.corner_blending import BlendedPath, Indices
from pickcli.timing.polyline_simplification import NOWHERE


@dataclass(frozen=True, eq=False)
class PathParts:
    """Parts of a polyline, with the tolerances of their blends.

    The corner between two parts is blended as widely as either allows, and that blend belongs to the part
    that allows more: a straight line ends where the path leaves it for a coarse motion, not in the middle of
    the blend. Between parts that allow the same, the boundary is in the middle.

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
        stops = np.minimum(before, after) == 0.0
        tolerances[self.edges[1:-1]] = np.where(stops, 0.0, np.maximum(before, after))
        return tolerances

    def boundaries(self, curve: BlendedPath) -> Array:
        """Return where the parts begin and end on a blended path.

        Args:
            curve: The polyline, blended.

        Returns:
            (P + 1,) path parameters s, not decreasing.
        """
        s = curve.waypoint_s[self.edges]
        corner = np.minimum(np.searchsorted(curve.corner_s, s), len(curve.corner_s) - 1)
        half = np.where(curve.corner_s[corner] == s, curve.half_lengths[corner], 0.0)
        s[1:-1] += np.sign(self.blends[:-1] - self.blends[1:]) * half[1:-1]
        return np.maximum.accumulate(np.clip(s, 0.0, curve.length))
