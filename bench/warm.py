"""What several benchmarks begin with: a fresh order at rest in the shelf, and a planner with its files."""

from __future__ import annotations

from dataclasses import replace

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.fingerprint import fingerprint
from pickcli.planning.planning_context import PlanningContext
from pickcli.precompute.artifact_cache import ensure_artifacts
from pickcli.random_scenes.make_scene import make_scene
from pickcli.roadmap.store import read_database, read_roadmap
from pickcli.scene.scene import Scene
from pickcli.trial.make_order import make_order
from pickcli.trial.order import Order, OrderKind


def context(max_tool_speed: float | None = None) -> PlanningContext:
    """A planner with the default cell's own roadmap and trajectory database, built if they are missing.

    max_tool_speed: m/s, a limit that the cell states on top; the stored paths are free at any speed
    """
    cell = load_cell("apc2016_delft")
    paths = ensure_artifacts(cell)
    stored = read_roadmap(paths.roadmap, cell), read_database(paths.trajectories, cell)
    if max_tool_speed is not None:
        cell = replace(cell, max_tool_speed=max_tool_speed)
        cell = replace(cell, fingerprint=fingerprint(cell))
    return PlanningContext(cell, *stored)


def planners(cell_name: str) -> tuple[PlanningContext, ...]:
    """A planner for each arm of a cell, with the files that are stored for it, built if they are missing.

    The arm that acts first in a trial comes first.
    """
    return tuple(_with_files(cell) for cell in load_workcell(cell_name).arms.values())


def _with_files(cell: Cell) -> PlanningContext:
    paths = ensure_artifacts(cell)
    return PlanningContext(cell, read_roadmap(paths.roadmap, cell), read_database(paths.trajectories, cell))


def fresh_scene(cell: Cell, seed: int) -> tuple[Order, Scene]:
    """A pick order of 2016 that nothing was tuned on, and its items at rest."""
    order = make_order(OrderKind.PICK, 2016, seed)
    return order, make_scene(order.bin_contents, cell, seed, order.year)
