"""Heaps in the tote, made by hand: a book that bridges two boxes, one of which is the target."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene

BOX, OTHER, BOOK = "command_hooks", "command_hooks#2", "laugh_out_loud_joke_book"
BRIDGE = 0.07  # m along the tote from its middle to that of a book that lies on the edge of the box
APART = 0.0002  # m between what lies on each other


def in_tote(cell: Cell, item_id: str, x: float, y: float, up: float, place: str = TOTE) -> PlacedItem:
    """An item that lies level with its lowest point so high over the floor, m."""
    item = cell.item(item_id.partition("#")[0])
    T = cell.T_world_place(cell.places[place]) @ pose([x, y, up + float(item.shape.extents[2]) / 2])
    return PlacedItem(item_id, item, place, T)


def bridge(cell: Cell, book: float = BRIDGE, place: str = TOTE) -> Scene:
    """Two boxes 14 mm apart, and a book across the gap with its middle there, m along the tote."""
    height = float(cell.item(BOX).shape.extents[2]) + APART
    items = (
        in_tote(cell, BOX, -0.09, 0.0, APART, place),
        in_tote(cell, OTHER, 0.09, 0.0, APART, place),
        in_tote(cell, BOOK, book, 0.0, height + APART, place),
    )
    return Scene(cell, cell.T_world_pod, items, PoseNoise(0.002, float(np.radians(1.0))))
