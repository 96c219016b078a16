"""What the tool may not enter of an item that it takes by a hollow: all of the item but that hollow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.hollow import Hollow
from pickcli.cell.shapes import Shape
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.collision_world import build_world
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.hollow_cover import LONGEST, N_WALLS, cover_around
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose, rotation_rpy, transform_points
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from support.hollow_items import are_in_any, points_around, rectangular_hollows, round_hollows
from support.tool_states import STRAIGHT

BOWL = "platinum_pets_dog_bowl"
IN_BOWL = (BOWL, "+z/bowl")


@given(of=st.one_of(round_hollows(), rectangular_hollows()), seed=st.integers(0, 99))
def test_every_point_of_the_item_outside_of_the_hollow_is_covered(
    of: tuple[Shape, Hollow], seed: int
) -> None:
    shape, hollow = of
    points = points_around(shape, 3000, seed)
    is_body = shape.contains(points) & ~hollow.contains(shape, points)
    pieces = cover_around(shape, hollow)
    assert are_in_any(points[is_body], [(piece.shape, piece.T_item_shape) for piece in pieces]).all()


@given(of=st.one_of(round_hollows(), rectangular_hollows()), seed=st.integers(0, 99))
def test_the_hollow_stays_open_up_to_the_chords_of_its_walls(of: tuple[Shape, Hollow], seed: int) -> None:
    shape, hollow = of
    points = points_around(shape, 3000, seed)
    inner = hollow
    if hollow.radius is not None:
        inner = replace(hollow, radius=hollow.radius * float(np.cos(np.pi / N_WALLS)) - 1e-9)
    low, high = hollow.bounds(shape)
    inside = inner.contains(shape, points) & ((points > low + 1e-9) & (points < high - 1e-9)).all(axis=1)
    pieces = cover_around(shape, hollow)
    assert not are_in_any(points[inside], [(piece.shape, piece.T_item_shape) for piece in pieces]).any()


@given(of=st.one_of(round_hollows(), rectangular_hollows()))
def test_no_point_of_a_piece_is_farther_than_stated_and_walls_are_short(of: tuple[Shape, Hollow]) -> None:
    shape, hollow = of
    pieces = cover_around(shape, hollow)
    assert [piece.is_wall for piece in pieces] == [False, *[True] * (len(pieces) - 1)]
    for piece in pieces:
        inside = points_around(piece.shape, 50)
        points = transform_points(piece.T_item_shape, inside[piece.shape.contains(inside)])
        assert np.linalg.norm(points, axis=1).max() <= piece.farthest + 1e-12
        if hollow.radius is None and piece.is_wall:
            assert np.delete(piece.shape.extents, hollow.axis).max() <= LONGEST + 1e-12


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    """A bowl on its base, open above, in the air before the robot, seen with an error."""
    T = pose([-1.2, -0.6, 0.7])
    noise = PoseNoise(0.002, float(np.radians(1.0)))
    return Scene(cell, cell.T_world_pod, (PlacedItem(BOWL, cell.item(BOWL), "tote", T),), noise)


def cup_at(scene: Scene, x: float, over: float) -> np.ndarray:
    """The straight lance from above, its tip m over the bottom of the bowl, x m beside the axis."""
    down = np.asarray(rotation_rpy(np.pi, 0.0, 0.0))
    z = scene.items[0].item.height("+z/bowl") + over
    return np.asarray(scene.items[0].T_world_item @ pose([x, 0.0, z], R=down))[None]


def test_only_a_tool_that_takes_the_item_by_its_hollow_may_enter_it(
    model: CollisionModel, scene: Scene
) -> None:
    entering = AllowedContacts(entered=IN_BOWL)
    inside, other = (
        FreeToolChecker(model, scene, STRAIGHT, np.eye(3), contacts)
        for contacts in (entering, AllowedContacts())
    )
    assert inside.are_valid_at(cup_at(scene, 0.0, 0.01))[0]
    assert not other.are_valid_at(cup_at(scene, 0.0, 0.01))[0]
    assert other.are_valid_at(cup_at(scene, 0.0, 0.05))[0]


def test_cup_and_lance_keep_clear_of_the_walls_whatever_they_may_touch(
    model: CollisionModel, scene: Scene
) -> None:
    """The bottom may be touched at any depth, the walls not even within clearance and error of the pose."""
    touching = AllowedContacts(tool=((BOWL, None),), entered=IN_BOWL)
    tool = FreeToolChecker(model, scene, STRAIGHT, np.eye(3), touching)
    assert tool.are_valid_at(cup_at(scene, 0.0, -0.003))[0]
    beside = [x for x in np.arange(0.0, 0.03, 0.0005) if tool.are_valid_at(cup_at(scene, x, -0.003))[0]]
    room = (
        0.038 - 0.015 - model.cell.clearance - 0.002
    )  # by radius, cup, clearance, and error of its position
    assert 0.008 < max(beside) < room


def test_one_form_of_an_item_with_hollows_is_entered(model: CollisionModel, scene: Scene) -> None:
    world = build_world(model, scene)
    is_of_bowl = np.array([name == BOWL for name in world.names])
    assert is_of_bowl.sum() == 2 + N_WALLS
    assert (world.is_kept(frozenset()) & is_of_bowl).sum() == 1
    assert (world.is_kept(frozenset(), IN_BOWL) & is_of_bowl).sum() == 1 + N_WALLS
    assert not (world.is_kept(frozenset({BOWL}), IN_BOWL) & is_of_bowl).any()
    assert not (world.is_kept(frozenset({BOWL})) & is_of_bowl).any()
