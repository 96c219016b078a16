"""A coarse motion: a proven path outside the places, and its limits."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.path_planning.lattice_planner import LatticePlan
from pickcli.roadmap.query_experience import QueryExperience

COARSE_LIMITS = SegmentLimits(blend_tolerance=0.05)


@dataclass(frozen=True, eq=False)
class CoarsePath:
    """A proven path to one of several goals.

    Attributes:
        waypoints: (N, n) configurations.
        goal: Index into the given goals.
        duration: s, estimated.
        source: Its origin: "straight edge", "database", "roadmap", "planner" or "lattice".
        experience: New experience of the search for it; empty if there was no search.
        searched: What ARA* found on the lattice of hand poses, before its shortcuts; None of others.
    """

    waypoints: Array
    goal: int
    duration: float
    source: str
    experience: tuple[QueryExperience, ...] = ()
    searched: LatticePlan | None = None

    def segment(self, kind: SegmentKind, mode: Mode) -> MotionSegment:
        """Make a segment of the path.

        Args:
            kind: Kind of the segment.
            mode: The mode in which it is proven free.

        Returns:
            The segment.
        """
        return MotionSegment(kind, self.waypoints, COARSE_LIMITS, mode=mode)
