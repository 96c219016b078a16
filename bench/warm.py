"""What several benchmarks begin with: the orders that come with the product, and a planner with its files."""

from __future__ import annotations

from pathlib import Path

from pickcli.cell.load import load_cell
from pickcli.planning.context import Planner
from pickcli.precompute.artifacts import ensure_artifacts
from pickcli.roadmap.store import read_database, read_roadmap

TASKS = Path(__file__).parent.parent / "data" / "tasks"


def planner() -> Planner:
    """A planner with the default cell's own roadmap and trajectory database, built if they are missing."""
    cell = load_cell("apc2016_delft")
    paths = ensure_artifacts(cell)
    return Planner(cell, read_roadmap(paths.roadmap, cell), read_database(paths.trajectories, cell))
