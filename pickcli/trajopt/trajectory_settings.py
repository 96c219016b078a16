"""How trajectories are searched. Imports stay light: `--help` reads the defaults from here."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.path_planning.planner_names import PlannerName


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
