"""Build settings of a roadmap. Keep imports light: `--help` reads the defaults from here."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.path_planning.planner_names import PlannerName


@dataclass(frozen=True)
class RoadmapSettings:
    """Build settings of a roadmap, stored with the result.

    Attributes:
        planner: Planner of the edges; if it fails, RRT-Connect is tried.
        n_neighbours: k, edges are tried from each node to its k nearest.
        max_iterations: Iterations of a planner for one edge; RRT* uses them all unless the straight edge is
            free.
        n_shortcuts: Shortcuts tried on the path of an edge.
        seed: Seed from which those of the edges are derived.
    """

    planner: PlannerName = PlannerName.RRT_STAR
    n_neighbours: int = 6
    max_iterations: int = 3000
    n_shortcuts: int = 200
    seed: int = 0
