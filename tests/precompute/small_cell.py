"""The default cell with a few of its named configurations."""

from __future__ import annotations

from dataclasses import replace

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell

FEW = ("home", "bin_A", "bin_E", "bin_L", "cam_E", "tote", "drop_00", "tote_10h")


def small_cell(*names: str) -> Cell:
    """The default cell with these configurations, in the cell's order (``FEW`` if none is given)."""
    cell = load_cell("apc2016_delft")
    wanted = names or FEW
    return replace(cell, configurations={k: v for k, v in cell.configurations.items() if k in wanted})
