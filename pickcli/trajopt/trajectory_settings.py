"""Settings of the trajectory search. Keep imports light: `--help` reads the defaults from here."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.path_planning.planner_names import PlannerName


@dataclass(frozen=True)
class TrajectorySettings:
    """Effort of the search for each motion of a database, stored with the result.

    Attributes:
        planner: Sampling-based planner that is used if collision descent finds nothing near the bound.
        n_tries: Number of its runs.
        max_iterations: Iterations of the planner in each run.
        n_shortcuts: Shortcuts tried in each path.
        n_descents: Number of collision descents tried for a duration.
        n_perturbations: Perturbations in each of them.
        n_final_shortcuts: Moves of time shortcutting.
        n_repeats: Number of times that the best motion, if it is not near its bound, is shortcut again.
        seed: Seed of all random choices.
    """

    planner: PlannerName = PlannerName.RRT_CONNECT
    n_tries: int = 4
    max_iterations: int = 5000
    n_shortcuts: int = 150
    n_descents: int = 6
    n_perturbations: int = 400
    n_final_shortcuts: int = 600
    n_repeats: int = 4
    seed: int = 0
