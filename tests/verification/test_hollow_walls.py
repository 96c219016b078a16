"""What the verifier holds for the body of an item around the hollow that it is taken by."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.hollow import Hollow
from pickcli.cell.item import Item
from pickcli.cell.schemas.items_file import load_items
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import transform_points
from pickcli.verification.grasp_check import _face_at, _rooms
from pickcli.verification.hollow_walls import N_STAVES, farthest_point, opened
from support.hollow_items import are_in_any, points_around, rectangular_hollows, round_hollows

ITEMS = load_items()
BOWL, BRUSH = ITEMS["platinum_pets_dog_bowl", 2016], ITEMS["dr_browns_bottle_brush", 2016]


def item_of(of: tuple[Shape, Hollow]) -> Item:
    return replace(BOWL, shape=of[0], hollows=(of[1],))


@given(of=st.one_of(round_hollows(), rectangular_hollows()), seed=st.integers(0, 99))
def test_it_contains_every_point_outside_of_the_hollow(of: tuple[Shape, Hollow], seed: int) -> None:
    shape, hollow = of
    body = opened(item_of(of), hollow.bottom)
    assert body is not None
    points = points_around(shape, 1500, seed)
    is_body = shape.contains(points) & ~hollow.contains(shape, points)
    assert are_in_any(points[is_body], [(each.shape, each.T_parent_shape) for each in body.all]).all()


@given(of=st.one_of(round_hollows(), rectangular_hollows()), seed=st.integers(0, 99))
def test_the_hollow_is_open_up_to_the_chords_of_its_staves(of: tuple[Shape, Hollow], seed: int) -> None:
    shape, hollow = of
    body = opened(item_of(of), hollow.bottom)
    assert body is not None
    share = float(np.cos(np.pi / N_STAVES))
    inner = hollow if hollow.radius is None else replace(hollow, radius=hollow.radius * share - 1e-9)
    points, (low, high) = points_around(shape, 1500, seed), hollow.bounds(shape)
    inside = inner.contains(shape, points) & ((points > low + 1e-9) & (points < high - 1e-9)).all(axis=1)
    solids = [(each.shape, each.T_parent_shape) for each in body.all]
    assert not are_in_any(points[inside], solids).any()


@given(of=st.one_of(round_hollows(), rectangular_hollows()))
def test_no_point_of_a_piece_is_farther_than_stated(of: tuple[Shape, Hollow]) -> None:
    body = opened(item_of(of), of[1].bottom)
    assert body is not None
    for piece in body.all:
        inside = points_around(piece.shape, 50) / 1.1
        points = transform_points(piece.T_parent_shape, inside)
        assert np.linalg.norm(points, axis=1).max() <= farthest_point(piece) + 1e-12


def test_other_faces_open_nothing() -> None:
    assert opened(BOWL, "+z") is None
    assert opened(BOWL, "-z/bowl") is None
    assert opened(BOWL, "+z/mug") is None


@pytest.mark.parametrize(
    ("item", "point", "face", "height", "room"),
    [
        (BOWL, (0.0, 0.01, -0.0145), "+z/bowl", 0.0, 0.02),
        (BOWL, (0.0, 0.0, -0.0130), "+z/bowl", 0.0015, 0.03),
        (BOWL, (0.0, 0.0, -0.0149), "+z/bowl", -0.0004, 0.03),
        (BOWL, (0.0, 0.0, 0.0155), "+z", 0.0, 0.0595),
        (BOWL, (0.0, 0.0, -0.0155), "-z", 0.0, 0.03),
        (BOWL, (0.0, 0.045, -0.0155), "-z", 0.0, -0.015),
        (BRUSH, (-0.05, 0.03, 0.0005), "+z/left", 0.0, 0.0175),
        (BRUSH, (-0.05, -0.03, 0.0005), "+z/right", 0.0, 0.0175),
        (BRUSH, (-0.05, -0.03, -0.0005), "-z/back_right", 0.0, 0.0175),
        (BRUSH, (0.05, 0.03, 0.029), "+z", 0.0, 0.0225),
    ],
)
def test_a_tip_at_the_bottom_is_on_the_bottom(
    item: Item, point: tuple[float, float, float], face: str, height: float, room: float
) -> None:
    name, off, normal, to_edge = _face_at(item, np.array(point))
    assert name == face
    assert off == pytest.approx(height, abs=1e-9)
    assert normal[2] == (1.0 if face[0] == "+" else -1.0)
    assert to_edge == pytest.approx(room)


@pytest.mark.parametrize("is_first", [True, False])
def test_of_hollows_of_two_faces_a_tip_is_on_the_bottom_that_it_is_nearest_to(is_first: bool) -> None:
    front = Hollow("a", "-x", 0.02, None, ((-0.045, 0.045), (-0.03, 0.03)))
    side = Hollow("b", "-y", 0.02, None, ((-0.025, 0.025), (-0.03, 0.03)))
    hollows = (front, side) if is_first else (side, front)
    shape = Shape(ShapeKind.BOX, (0.12, 0.12, 0.12))
    item = replace(BRUSH, shape=shape, hollows=hollows, seals={"-x/a": 0.9, "-y/b": 0.9}, areas={})
    assert _face_at(item, np.array([0.0, -0.04, 0.0]))[0] == "-y/b"
    assert _face_at(item, np.array([-0.04, 0.0, 0.0]))[0] == "-x/a"


def test_edges_of_the_bottom_of_a_rectangular_hollow_are_its_sides() -> None:
    rooms = _rooms(BRUSH, "+z/left", np.array([-0.05, 0.03, 0.0005]))
    np.testing.assert_allclose(rooms, [[0.089, 0.05], [0.0175, 0.0225]])
