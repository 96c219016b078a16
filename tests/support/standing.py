"""Boxes that stand on edge in an open crate of ``ur5e_crates``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose, rotation_rpy
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

CRATES, CRATE, SHELF = load_cell("ur5e_crates"), "crate_right", "shelf_1_1"
BOX = "crayola_24_ct"  # 95 x 70 x 25 mm, which seals on its large faces; the others are too narrow for a cup
NOISE = PoseNoise(0.002, float(np.radians(1.0)))
APART = 0.0002  # m between an item and what it stands on


def box(length: float, height: float, width: float, mass: float = 0.1) -> Item:
    """A box whose axes x, y, z are so long, m; only the faces across z seal."""
    item = CRATES.item(BOX)
    seals = {face: 0.9 if face[1] == "z" else 0.0 for face in item.seals}
    return replace(item, shape=Shape(ShapeKind.BOX, (length, height, width)), mass=mass, seals=seals)


def standing(
    item_id: str, x: float, y: float, yaw: float = 0.0, item: Item | None = None, place: str = CRATE
) -> PlacedItem:
    """An item on its edge, with its y axis up and its thin side across x at yaw 0; x, y: m in the place."""
    item = item or CRATES.item(item_id.partition("#")[0])
    R = rotation_rpy(0.0, 0.0, yaw + np.pi / 2) @ rotation_rpy(np.pi / 2, 0.0, 0.0)
    T = pose((x, y, float(item.shape.extents[1]) / 2 + APART), R=R)
    return PlacedItem(item_id, item, place, CRATES.T_world_place(CRATES.places[place]) @ T)


def lying(
    item_id: str, x: float, y: float, up: float = 0.0, place: str = CRATE, item: Item | None = None
) -> PlacedItem:
    """An item that lies on its largest face, so many m over the floor."""
    item = item or CRATES.item(item_id.partition("#")[0])
    T = pose((x, y, float(item.shape.extents[2]) / 2 + APART + up))
    return PlacedItem(item_id, item, place, CRATES.T_world_place(CRATES.places[place]) @ T)


def crate(*items: PlacedItem, noise: PoseNoise = NOISE) -> Scene:
    """A scene with some items."""
    return Scene(CRATES, CRATES.T_world_pod, items, noise)
