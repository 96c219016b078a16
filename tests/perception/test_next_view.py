"""The next look goes where most is in sight of what is not known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import inverse, pose, transform_points
from pickcli.perception.next_view import hiding_items, next_views, unknown_points
from pickcli.perception.viewpoints import Viewpoint, further_viewpoints, viewpoints_of
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene, empty_scene
from pickcli.scene.unknown_space import UnknownSpace

NAME = "bin_E"


@pytest.fixture(scope="module")
def further(cell: Cell) -> tuple[Viewpoint, ...]:
    return further_viewpoints(cell.places[NAME], empty_scene(cell))


def behind_a_box(cell: Cell, side: float) -> Scene:
    """A tissue box stands at the front of the bin; behind it, to one side, is what nobody has seen."""
    scene, place = empty_scene(cell), cell.places[NAME]
    T, item = scene.T_world_place(place), cell.item("kleenex_tissue_box", 2016)
    box = PlacedItem(item.name, item, NAME, T @ pose((0.12, side * 0.04, 0.05)), PoseNoise())
    middle = np.array([0.3, side * 0.06, 0.05])
    unknown = UnknownSpace(NAME, T, np.stack([middle - 0.03, middle + 0.03])[None])
    return replace(scene, items=(box,), unknown=(unknown,))


def test_points_fill_what_is_unknown_and_unrecognised() -> None:
    T = pose((1.0, 2.0, 3.0))
    boxes = np.array([[[0.0, 0.0, 0.0], [0.1, 0.02, 0.01]]])
    points = unknown_points([UnknownSpace("p", T, boxes, boxes + 1.0), UnknownSpace("q", T, boxes[:0])])
    own = transform_points(inverse(T), points)
    assert len(points) == 40
    for part, low in ((own[:20], 0.0), (own[20:], 1.0)):
        np.testing.assert_allclose(part.min(axis=0), np.array([0.005, 0.005, 0.005]) + low)
        np.testing.assert_allclose(part.max(axis=0), np.array([0.095, 0.015, 0.005]) + low)
    assert unknown_points([]).shape == (0, 3)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_what_a_box_hides_is_looked_at_from_beside_it(
    cell: Cell, further: tuple[Viewpoint, ...], side: float
) -> None:
    scene = behind_a_box(cell, side)
    (best,) = next_views(further, scene, NAME, 1)
    mouth = scene.T_world_place(cell.places[NAME])
    straight = inverse(mouth) @ viewpoints_of(cell.places[NAME], cell)[0].T_world_camera
    aside = (inverse(mouth) @ best.T_world_camera)[1, 3] - straight[1, 3]
    assert aside * side > 0.1  # past the outer side of the box
    left = replace(scene, unknown=(replace(scene.unknown[0], place="bin_F"),))
    assert next_views(further, left, NAME, 1) == further[:1]  # nothing to be seen there: the first of equals


def test_views_do_not_repeat_and_add_to_each_other(cell: Cell, further: tuple[Viewpoint, ...]) -> None:
    scene = behind_a_box(cell, 1.0)
    three = next_views(further, scene, NAME, 3)
    assert len({each.at.name for each in three}) == 3
    assert three[:1] == next_views(further, scene, NAME, 1)
    assert len(next_views(further, scene, NAME, 99)) == len(further)
    assert next_views((), scene, NAME, 3) == ()


def test_what_hides_most_of_what_is_not_known_is_named_first(
    cell: Cell, further: tuple[Viewpoint, ...]
) -> None:
    scene, first = behind_a_box(cell, 1.0), viewpoints_of(cell.places[NAME], cell)
    (box,), T = scene.items, scene.T_world_place(cell.places[NAME])
    item = cell.item("dove_beauty_bar", 2016)
    low = PlacedItem(item.name, item, NAME, T @ pose((0.05, 0.04, -0.01)), PoseNoise())
    beside = PlacedItem(f"{item.name}#2", item, NAME, T @ pose((0.1, -0.11, 0.0)), PoseNoise())
    elsewhere = PlacedItem(f"{item.name}#3", item, "bin_F", low.T_world_item, PoseNoise())
    crowded = replace(scene, items=(beside, low, elsewhere, box))
    names = hiding_items(first, crowded, NAME)
    assert names[0] == box.id and beside.id not in names and elsewhere.id not in names
    assert hiding_items(first, replace(crowded, unknown=()), NAME) == ()
