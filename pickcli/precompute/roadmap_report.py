"""What became of a roadmap's build."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pickcli.jobs.job_run import BuildProgress
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.precompute.route_redundancy import RouteRedundancy
from pickcli.roadmap.roadmap_tables import RoadmapGaps


@dataclass(frozen=True)
class RoadmapReport:
    """What a build could not do, and what it did beyond the k nearest.

    Attributes:
        settings: How the roadmap was built.
        gaps: Named configurations that are not free, and pairs without an edge, with their reasons.
        bridges: Pairs joined on top, to connect parts that the k nearest left apart.
        n_components: 1 if every node can be reached from every other.
        routes: Second routes of the important pairs.
        progress: Of the build in the end: how many tasks were kept from before, and how many done.
    """

    settings: RoadmapSettings
    gaps: RoadmapGaps
    bridges: tuple[tuple[str, str], ...]
    n_components: int
    routes: RouteRedundancy
    progress: BuildProgress

    def summary(self) -> dict[str, Any]:
        """Sum up the report.

        Returns:
            The figures as JSON values.
        """
        return {
            "n_neighbours": self.settings.n_neighbours,
            "n_components": self.n_components,
            "n_refused": len(self.gaps.refused),
            "n_missing": len(self.gaps.missing),
            "bridges": [f"{a} to {b}" for a, b in self.bridges],
            "second_routes": self.routes.summary(),
        }
