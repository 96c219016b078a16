"""Routes through the roadmap: start and goal connected, A*, every edge on the way proven again.

python -m bench.routes
"""

from __future__ import annotations

import json
import statistics
import time

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import MOVING
from pickcli.collision.motion_validator import MotionValidator
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.path_planning.state_space import JointSpace
from pickcli.precompute.artifact_cache import ensure_artifacts
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.roadmap.astar import shortest_route
from pickcli.roadmap.connection import PlanningProblem, QueryOptions
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_search import search_roadmap
from pickcli.roadmap.store import read_roadmap
from pickcli.roadmap.trajectory_database import PayloadClass

SPREAD = 0.1  # rad or m, standard deviation of a start or goal from the configuration that it is near


def measure(n_runs: int = 300) -> dict[str, float]:
    """Times in ms, warm, from near a bin to near the tote or the other way round; and the share answered."""
    cell = load_cell("apc2016_delft")
    roadmap = read_roadmap(ensure_artifacts(cell).roadmap, cell)
    validator = checker(CollisionModel(cell), MOVING, PayloadClass.EMPTY)
    rng = np.random.default_rng(0)
    connected, answered = [], 0
    for _ in range(n_runs):
        problem = _problem(cell, roadmap, validator, rng)
        began = time.perf_counter()
        answered += search_roadmap(problem) is not None
        connected.append(1e3 * (time.perf_counter() - began))
    return {
        "n_runs": n_runs,
        "answered": answered / n_runs,
        "route_ms": statistics.median(connected),
        "route_p95_ms": float(np.percentile(connected, 95)),
        "astar_alone_ms": statistics.median(_astar_ms(roadmap, rng) for _ in range(n_runs)),
    }


def _problem(
    cell: Cell, roadmap: Roadmap, validator: MotionValidator, rng: np.random.Generator
) -> PlanningProblem:
    """A query whose ends are free and no nodes."""
    space = JointSpace.of(cell.robot)
    start, goal = (_near(cell, kind, validator, space, rng) for kind in rng.permutation(["bin", "drop"]))
    return PlanningProblem(roadmap, validator, space, start, goal[None], 0, QueryOptions())


def _near(
    cell: Cell, kind: str, validator: MotionValidator, space: JointSpace, rng: np.random.Generator
) -> Array:
    named = [each.q for each in cell.configurations.values() if each.kind == kind]
    while True:
        q: Array = named[rng.integers(len(named))] + rng.normal(0.0, SPREAD, space.n)
        if space.holds(q) and validator.is_valid(q):
            return q


def _astar_ms(roadmap: Roadmap, rng: np.random.Generator) -> float:
    start, goal = rng.choice(roadmap.n_nodes, 2, replace=False).tolist()
    began = time.perf_counter()
    shortest_route(roadmap, start, [goal], lambda edge: True)
    return 1e3 * (time.perf_counter() - began)


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
