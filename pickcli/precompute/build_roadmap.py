"""The offline half after KTH: a roadmap of the named configurations.

KTH chose configurations by hand and joined them by RRT* (section IV-A.1). Edges lead from each node to its
k nearest, never as a star around home, so that A* finds a way between two bins that does not pass home.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pickcli.cell.model import Cell, NamedConfiguration
from pickcli.cell.robot import PivotState
from pickcli.collision.model import CollisionModel
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.precompute.empty_scene import RESERVE, checker
from pickcli.roadmap.database import PayloadClass
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.sampling import plan
from pickcli.roadmap.shorten import shorten
from pickcli.roadmap.space import EdgeChecker, JointSpace
from pickcli.seeds import derived_seed

Progress = Callable[[int, int, str], None]
Pair = tuple[int, int]


@dataclass(frozen=True)
class RoadmapSettings:
    """How a roadmap is built; all of it is stored with the result.

    n_neighbours: k, edges are tried from each node to its k nearest
    max_iterations: of the planner for one edge; RRT* uses them all unless the straight edge is free
    """

    planner: PlannerName = PlannerName.RRT_STAR
    n_neighbours: int = 6
    max_iterations: int = 3000
    n_shortcuts: int = 200
    seed: int = 0


@dataclass(frozen=True)
class RoadmapReport:
    """What a build could not do, and what it did beyond the k nearest.

    refused: named configurations that are not free, with the reason
    failed: pairs that the planner found no path for
    bridges: pairs joined on top, to connect parts that the k nearest left apart
    n_components: 1 if every node can be reached from every other
    """

    settings: RoadmapSettings
    refused: tuple[tuple[str, Reason], ...]
    failed: tuple[tuple[str, str], ...]
    bridges: tuple[tuple[str, str], ...]
    n_components: int

    def summary(self) -> dict[str, Any]:
        """The report as JSON values."""
        return {
            "n_neighbours": self.settings.n_neighbours,
            "n_components": self.n_components,
            "refused": [f"{name}: {reason}" for name, reason in self.refused],
            "failed": [f"{a} to {b}" for a, b in self.failed],
            "bridges": [f"{a} to {b}" for a, b in self.bridges],
        }


def build_roadmap(
    cell: Cell, settings: RoadmapSettings | None = None, progress: Progress | None = None
) -> tuple[Roadmap, RoadmapReport]:
    """The roadmap of a cell's named configurations, every edge proven with the cell's clearance.

    Edges are proven for the pivoting cup (MOVING), so that they hold in each pivot state. Each edge's seed
    follows from the names of its ends: the order of the edges does not matter. ``progress`` gets edges done,
    edges in all, and the edge in work.

    Raises InputError if not one configuration is free.
    """
    builder = _Builder(cell, settings or RoadmapSettings(), progress or _silent)
    builder.join_nearest()
    builder.join_components()
    return builder.roadmap, builder.report()


def nearest_pairs(configurations: Array, k: int) -> list[Pair]:
    """Each node with its k nearest (Euclidean, ties by index), every pair once, sorted."""
    distances = np.linalg.norm(configurations[:, None] - configurations[None], axis=2)
    np.fill_diagonal(distances, np.inf)
    order = np.argsort(distances, axis=1, kind="stable")[:, : min(k, len(configurations) - 1)]
    return sorted({(min(i, int(j)), max(i, int(j))) for i, row in enumerate(order) for j in row})


@dataclass
class _Builder:
    """One build in progress."""

    cell: Cell
    settings: RoadmapSettings
    progress: Progress
    roadmap: Roadmap = field(init=False)
    checker: EdgeChecker = field(init=False)
    space: JointSpace = field(init=False)
    refused: list[tuple[str, Reason]] = field(default_factory=list)
    failed: list[Pair] = field(default_factory=list)
    bridges: list[Pair] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.space = JointSpace.of(self.cell.robot)
        self.checker = checker(CollisionModel(self.cell), PivotState.MOVING, PayloadClass.EMPTY, RESERVE)
        self.roadmap = Roadmap.empty(self.space.joint_names, PivotState.MOVING)
        for named in self.cell.configurations.values():
            self._add_node(named)
        if self.roadmap.n_nodes == 0:
            raise InputError(
                f"{self.cell.path}: no named configuration is free; see apc inspect, and correct them"
            )

    def join_nearest(self) -> None:
        """Edges from each node to its k nearest."""
        pairs = nearest_pairs(self.roadmap.configurations, self.settings.n_neighbours)
        for done, pair in enumerate(pairs):
            self.progress(done, len(pairs), " to ".join(self._names(pair)))
            if not self._join(pair):
                self.failed.append(pair)
        self.progress(len(pairs), len(pairs), "")

    def join_components(self) -> None:
        """Edges between parts that are still apart, nearest pairs first, until there are none."""
        apart = self._pairs_apart()
        while apart:
            pair = apart.pop(0)
            if self._join(pair):
                self.bridges.append(pair)
                apart = [other for other in self._pairs_apart() if other not in self.failed]
            else:
                self.failed.append(pair)

    def report(self) -> RoadmapReport:
        """What happened."""
        return RoadmapReport(
            self.settings,
            tuple(self.refused),
            tuple(self._names(pair) for pair in self.failed),
            tuple(self._names(pair) for pair in self.bridges),
            len(set(self.roadmap.components().tolist())),
        )

    def _add_node(self, named: NamedConfiguration) -> None:
        if self.checker.is_free(named.q):
            self.roadmap, _ = self.roadmap.with_node(named.q, named.name, named.pivot)
        else:
            self.refused.append((named.name, self.checker.explain(named.q)))

    def _join(self, pair: Pair) -> bool:
        """Add the edge of a pair, planned in the order of the names; False if the planner finds none."""
        pair = min(pair, pair[::-1], key=self._names)
        seed = derived_seed(self.settings.seed, "edge", *self._names(pair))
        a, b = (self.roadmap.configurations[i] for i in pair)
        found = plan(
            self.checker,
            self.space,
            a,
            b[None],
            seed=seed,
            planner=self.settings.planner,
            max_iterations=self.settings.max_iterations,
        )
        if found is None:
            return False
        path = shorten(self.checker, self.space, found, seed=seed, iterations=self.settings.n_shortcuts)
        if self.checker.path_is_free(path.waypoints) != -1:
            return False
        self.roadmap = self.roadmap.with_edge(*pair, path.waypoints)
        return True

    def _pairs_apart(self) -> list[Pair]:
        """Pairs of nodes of different parts that have not failed yet, nearest first."""
        label, q = self.roadmap.components(), self.roadmap.configurations
        pairs: Sequence[Pair] = [
            (i, j) for i in range(len(q)) for j in range(i + 1, len(q)) if label[i] != label[j]
        ]
        return sorted(
            (pair for pair in pairs if pair not in self.failed),
            key=lambda pair: (float(np.linalg.norm(q[pair[0]] - q[pair[1]])), pair),
        )

    def _names(self, pair: Pair) -> tuple[str, str]:
        return self.roadmap.names[pair[0]], self.roadmap.names[pair[1]]


def _silent(done: int, total: int, what: str) -> None:
    """No progress wanted."""
