"""The default cell with a few of its named configurations, and little effort for its motions."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.workcell import Workcell
from pickcli.trajopt.trajectory_settings import TrajectorySettings

FEW = ("home", "bin_A", "bin_E", "bin_L", "cam_E", "tote", "drop_00", "tote_10h")

# One of everything that is counted: motions that are free, not fast.
COUNTS: dict[str, Any] = {f.name: 1 for f in fields(TrajectorySettings) if f.name.startswith("n_")}
LEAST_EFFORT = TrajectorySettings(**COUNTS)


def small_cell(*names: str) -> Cell:
    """The default cell with these configurations, in the cell's order (``FEW`` if none is given)."""
    cell = load_cell("apc2016_delft")
    wanted = names or FEW
    return replace(cell, configurations={k: v for k, v in cell.configurations.items() if k in wanted})


def alone(cell: Cell) -> Workcell:
    """A cell with one arm, as commands load it."""
    return replace(load_workcell("apc2016_delft"), arms={"": cell})
