"""Builder of the roadmap of the named configurations, after KTH.

KTH chose configurations by hand and joined them by RRT* (section IV-A.1). Here edges lead from each node to
its k nearest, not as a star around home, so that A* finds a route between two bins that does not pass home;
more are added until components are joined and critical pairs have a second route.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pickcli.cell.cell import NamedConfiguration
from pickcli.cell.tool import MOVING, Tool
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.jobs.job_run import Build, BuildProgress
from pickcli.precompute.critical_pairs import critical_pairs
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob, validity_of
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.precompute.route_redundancy import (
    NodePair,
    RouteRedundancy,
    detour,
    edge_to_try,
    for_any_pod,
    missing_redundancy,
)
from pickcli.roadmap.edge_disjoint import EdgeDisjoint, edge_disjoint
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps


@dataclass(frozen=True)
class RoadmapReport:
    """Gaps of a build, and edges added besides the k nearest.

    Attributes:
        settings: How the roadmap was built.
        gaps: Named configurations that are not free, and pairs without an edge, with their reasons.
        bridges: Additional pairs, joined to connect components of the k nearest.
        n_components: 1 if every node can be reached from every other.
        routes: Second routes of the critical pairs.
        progress: Final progress of the build: numbers of tasks kept from before, and done.
    """

    settings: RoadmapSettings
    gaps: RoadmapGaps
    bridges: tuple[tuple[str, str], ...]
    n_components: int
    routes: RouteRedundancy
    progress: BuildProgress

    def summary(self) -> dict[str, Any]:
        """Summarise the report.

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


def build_roadmap(job: RoadmapEdgeJob, build: Build | None = None) -> tuple[Roadmap, RoadmapReport]:
    """Build the roadmap of a cell's named configurations, every edge proven with the cell's clearance.

    Edges are proven for the tool in motion (MOVING), so that they hold in each tool state. Each edge depends
    only on its ends and the settings.

    Args:
        job: The job that makes edges.
        build: Build of that job, with a journal or workers; None for this process.

    Returns:
        The roadmap, and a report with its gaps.

    Raises:
        InputError: No configuration is free.
    """
    builder = _Builder(job, build or Build(job))
    builder.join_nearest()
    builder.join_components()
    builder.add_second_routes()
    return builder.roadmap, builder.report()


def _states(tool: Tool) -> str:
    """Describe the tool states for which an edge holds; "" for a tool with one state."""
    states = sorted(tool.states, key=tool.position)
    return f"tool anywhere from {states[0]} to {states[-1]}" if len(states) > 1 else ""


def nearest_pairs(configurations: Array, k: int) -> list[NodePair]:
    """Pair each node with its k nearest (Euclidean, ties by index).

    Args:
        configurations: (N, n) of the nodes.
        k: Most neighbours.

    Returns:
        Pairs of indices (i < j), sorted, every pair once.
    """
    distances = np.linalg.norm(configurations[:, None] - configurations[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    order = np.argsort(distances, axis=1, kind="stable")[:, : min(k, len(configurations) - 1)]
    return sorted({(min(i, int(j)), max(i, int(j))) for i, row in enumerate(order) for j in row})


@dataclass
class _Builder:
    """A growing roadmap."""

    job: RoadmapEdgeJob
    build: Build
    roadmap: Roadmap = field(init=False)
    refused: list[tuple[tuple[str], Reason]] = field(default_factory=list)
    failed: dict[NodePair, Reason] = field(default_factory=dict)
    bridges: list[NodePair] = field(default_factory=list)
    routes: RouteRedundancy = field(default_factory=RouteRedundancy)

    def __post_init__(self) -> None:
        cell = self.job.cell
        self.roadmap = Roadmap.empty(cell.robot.joint_names, MOVING)
        for named in cell.configurations.values():
            self._add_node(named)
        if self.roadmap.n_nodes == 0:
            raise InputError(
                f"{cell.path}: no named configuration is free; see apc inspect, and correct them"
            )

    def join_nearest(self) -> None:
        """Add edges from each node to its k nearest."""
        self._join(nearest_pairs(self.roadmap.configurations, self.job.settings.n_neighbours))

    def join_components(self) -> None:
        """Add edges between separate components, nearest pairs first, until there are none."""
        while apart := self._pairs_apart():
            self.bridges += self._join(apart[:1])

    def add_second_routes(self) -> None:
        """Add edges until every critical pair has two edge-disjoint routes, or no edge is left to try."""
        detours, alone, added = [], [], list[NodePair]()
        for names in critical_pairs(self.job.cell):
            refused = next((reason for (name,), reason in self.refused if name in names), None)
            if refused is not None:
                alone.append((names, refused))
                continue
            found = self._two_routes(names, added)
            if len(found.routes) == 2:
                detours.append((names, detour(found)))
            else:
                alone.append((names, missing_redundancy(self.roadmap, found, self.failed)))
        joined = tuple(self._names(pair) for pair in added)
        n_for_any = self._n_double([names for names, _ in detours])
        self.routes = RouteRedundancy(tuple(detours), tuple(alone), joined, n_for_any)

    def report(self) -> RoadmapReport:
        """Report gaps of the build, and edges added besides the k nearest."""
        missing = tuple((self._names(pair), reason) for pair, reason in self.failed.items())
        return RoadmapReport(
            self.job.settings,
            RoadmapGaps(tuple(self.refused), missing, self.routes.without_second_route),
            tuple(self._names(pair) for pair in self.bridges),
            len(set(self.roadmap.components().tolist())),
            self.routes,
            self.build.progress,
        )

    def _add_node(self, named: NamedConfiguration) -> None:
        checker = self.job.checker
        if checker.is_valid(named.q):
            self.roadmap, _ = self.roadmap.with_node(named.q, named.name, named.tool_state)
        else:
            # It may be free in a single state, and a move to it possible, but edges must hold for all states.
            reason = checker.explain(named.q).within(_states(self.job.cell.robot.tool))
            self.refused.append(((named.name,), reason))

    def _two_routes(self, names: tuple[str, str], added: list[NodePair]) -> EdgeDisjoint:
        """Return the routes of a pair after trying edges; new edges are also appended to ``added``."""
        start, goal = (self.roadmap.names.index(name) for name in names)
        while True:
            found = edge_disjoint(self.roadmap, start, goal)
            pair = edge_to_try(self.roadmap, found.side, self.failed) if len(found.routes) < 2 else None
            if pair is None:
                return found
            added += self._join([pair])

    def _n_double(self, pairs: Sequence[tuple[str, str]]) -> int:
        """Count the pairs that have two routes for all pod poses."""
        part = for_any_pod(self.roadmap)
        ends = [[part.names.index(name) for name in pair] for pair in pairs]
        return sum(len(edge_disjoint(part, start, goal).routes) == 2 for start, goal in ends)

    def _join(self, pairs: Sequence[NodePair]) -> list[NodePair]:
        """Add the edges of pairs, planned in the order of their names; return the pairs that have one."""
        ordered = [min(pair, pair[::-1], key=self._names) for pair in pairs]
        records = self.build.records([self._names(pair) for pair in ordered])
        found = []
        for pair, ends, record in zip(pairs, ordered, records, strict=True):
            if record.reason is None:
                self.roadmap = self.roadmap.with_edge(*ends, record.arrays["waypoints"], validity_of(record))
                found.append(pair)
            else:
                self.failed[pair] = record.reason
        return found

    def _pairs_apart(self) -> list[NodePair]:
        """Return pairs of nodes in different components that have not failed yet, nearest first."""
        label, q = self.roadmap.components(), self.roadmap.configurations
        pairs: Sequence[NodePair] = [
            (i, j) for i in range(len(q)) for j in range(i + 1, len(q)) if label[i] != label[j]
        ]
        return sorted(
            (pair for pair in pairs if pair not in self.failed),
            key=lambda pair: (float(np.linalg.norm(q[pair[0]] - q[pair[1]])), pair),
        )

    def _names(self, pair: NodePair) -> tuple[str, str]:
        return self.roadmap.names[pair[0]], self.roadmap.names[pair[1]]
