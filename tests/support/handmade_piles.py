"""One item across the back of a bin, and perhaps another on it."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

BACK = 0.01  # m between the lower one and the wall behind it
APART = 0.0002  # m between what lies on each other: physics lets things rest so


def lying_on(cell: Cell, bin_name: str, below: str, above: str | None, noise: PoseNoise) -> Scene:
    """Items flat, their longer sides across the bin, middle over middle."""
    cell_bin, items = cell.pod.bins[bin_name], []
    R = pose(rpy=[0.0, 0.0, np.pi / 2])[:3, :3]
    reach = cell.item(below).shape.reach(R)
    x = cell_bin.room.depth - BACK - float(reach[0])
    floor, _ = cell_bin.room.rest(np.array(x - float(reach[0])), np.array(0.0))
    z = float(floor) + APART
    for name in filter(None, (below, above)):
        height = float(cell.item(name).shape.extents[2])
        T = cell.T_world_place(cell_bin) @ pose([x, 0.0, z + height / 2], R=R)
        items.append(PlacedItem(name, cell.item(name), bin_name, T))
        z += height + APART
    return Scene(cell, cell.T_world_pod, tuple(items), noise)
