"""A box as large as a brush, on edge in a bin of ``apc2016_delft``, the face that seals against a wall."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import pose, rotation_rpy
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.pose_noise import DEFAULT_NOISE

CELL, BIN, BRUSH = load_cell("apc2016_delft"), "bin_E", "dr_browns_bottle_brush"
BALL = "rawlings_baseball"
APART = 0.0002  # m between an item and the floor, and 8 mm between it and the wall


def on_edge(x: float = 0.2, from_wall: float = 0.008, yaw: float = 0.0) -> PlacedItem:
    """It on its edge along the left wall, with its middle so many m inwards; only its back seals."""
    place, brush = CELL.places[BIN], CELL.item(BRUSH)
    item = replace(brush, hollows=(), seals={face: 0.9 * (face == "-z") for face in brush.shape.face_names})
    length, height, width = item.shape.extents
    z, pitch = place.room.rest(np.array(x), np.array(length / 2))
    R = rotation_rpy(0.0, float(pitch), yaw) @ rotation_rpy(np.pi / 2, 0.0, 0.0)
    y = place.room.y_range[1] - from_wall - width / 2
    T = pose((x, y, float(z) + height / 2 + APART), R=R)
    return PlacedItem(BRUSH, item, BIN, CELL.T_world_place(place) @ T)


def ball(x: float, from_wall: float) -> PlacedItem:
    """A ball on the floor of the bin, with its middle so many m inwards and from the left wall."""
    place, item = CELL.places[BIN], CELL.item(BALL)
    y = place.room.y_range[1] - from_wall
    T = pose((x, y, float(place.room.floor_at(x)) + float(item.shape.extents[2]) / 2 + 0.001))
    return PlacedItem(BALL, item, BIN, CELL.T_world_place(place) @ T)


def shelf(*items: PlacedItem) -> Scene:
    """A scene with some items, their poses known as in a trial."""
    return Scene(CELL, CELL.T_world_pod, items, DEFAULT_NOISE)
