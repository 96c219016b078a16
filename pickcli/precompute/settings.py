"""How files are built. Importing this file imports nothing heavy: the help of the commands tells defaults."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.roadmap.planners import PlannerName


@dataclass(frozen=True)
class RoadmapSettings:
    """How a roadmap is built; all of it is stored with the result.

    n_neighbours: k, edges are tried from each node to its k nearest
    planner: of the edges; where it gives up, RRT-Connect tries
    max_iterations: of a planner for one edge; RRT* uses them all unless the straight edge is free
    """

    planner: PlannerName = PlannerName.RRT_STAR
    n_neighbours: int = 6
    max_iterations: int = 3000
    n_shortcuts: int = 200
    seed: int = 0


@dataclass(frozen=True)
class TrajectorySettings:
    """How a database is built; all of it is stored with the result.

    n_tries: times that the planner is asked for a path where bending finds nothing near the bound
    max_iterations, n_shortcuts: of the planner for a path, and shortcuts in it
    n_presses, n_press: times that bending is tried for a duration, and bends each time
    n_quicken: moves that make a motion quicker
    n_agains: times that the best motion, where it is not near its bound, is made quicker once more
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    n_tries: int = 4
    max_iterations: int = 5000
    n_shortcuts: int = 150
    n_presses: int = 6
    n_press: int = 400
    n_quicken: int = 600
    n_agains: int = 4
    seed: int = 0
