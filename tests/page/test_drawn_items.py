"""Items on pages: with hollows as their true body."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.item import Item
from pickcli.cell.schemas.items_file import load_items
from pickcli.files.packed_array import unpacked
from pickcli.page.shape_parts import CORNER_RESOLUTION, drawn_item, drawn_shape

ITEMS = load_items()
BOWL, BRUSH = ITEMS["platinum_pets_dog_bowl", 2016], ITEMS["dr_browns_bottle_brush", 2016]


def enclosed(item: Item) -> float:
    """Volume in m3 that the triangles of an item enclose, by the divergence theorem."""
    shape = drawn_item(item)
    assert shape.corners is not None and shape.triangles is not None
    corners, triangles = unpacked(shape.corners), unpacked(shape.triangles).astype(int)
    a, b, c = (corners[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def test_an_item_without_hollows_is_drawn_as_its_shape() -> None:
    plain = replace(BOWL, hollows=())
    assert (drawn_item(plain).kind, drawn_item(plain).size) == ("cylinder", drawn_shape(BOWL.shape).size)


def test_hollows_of_a_box_are_not_drawn() -> None:
    cut = sum(float(np.prod(np.ptp(hollow.bounds(BRUSH.shape), axis=0))) for hollow in BRUSH.hollows)
    assert enclosed(BRUSH) == pytest.approx(BRUSH.shape.volume - cut, rel=0.01)


def test_the_corners_of_a_bowl_are_in_its_shape_and_at_the_bottom_of_its_hollow() -> None:
    shape = drawn_item(BOWL)
    assert shape.corners is not None
    corners = unpacked(shape.corners)
    assert (np.abs(corners) <= BOWL.shape.extents / 2 + CORNER_RESOLUTION).all()
    assert np.isclose(corners[:, 2], BOWL.height("+z/bowl"), atol=CORNER_RESOLUTION).any()
