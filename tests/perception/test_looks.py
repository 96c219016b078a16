"""Colour pictures of scenes: prints of items by name and seed, and what is drawn from them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import pose
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.looks import HALL, colour_picture
from pickcli.perception.procedural_texture import face_textures
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import PlacedItem, Scene, empty_scene


def test_all_items_of_2016_have_a_colour_and_a_texture_on_every_face(cell: Cell) -> None:
    for (_, year), item in cell.items.items():
        if year != 2016:
            continue
        assert item.colour is not None
        faces = face_textures(item, 0)
        assert len(faces) == (3 if item.shape.kind is ShapeKind.CYLINDER else 6)
        for face in faces:
            assert face.dtype == np.uint8
            assert face.shape[2] == 3
            assert min(face.shape[:2]) >= 4


def test_textures_have_the_proportions_of_their_faces(cell: Cell) -> None:
    item = cell.item("crayola_24_ct")
    x, y, z = item.shape.extents
    sides = [(y, z), (y, z), (x, z), (x, z), (x, y), (x, y)]
    for face, (width, height) in zip(face_textures(item, 0), sides, strict=True):
        assert face.shape[1] / face.shape[0] == pytest.approx(width / height, rel=0.05)


def test_prints_follow_from_name_and_seed(cell: Cell) -> None:
    item, other = cell.item("crayola_24_ct"), cell.item("dove_beauty_bar")
    first = [face.tobytes() for face in face_textures(item, 0)]
    assert [face.tobytes() for face in face_textures(item, 0)] == first
    assert len(set(first)) == 6  # no two faces alike
    assert not set(first) & {face.tobytes() for face in face_textures(item, 1)}
    assert not set(first) & {face.tobytes() for face in face_textures(other, 0)}


def test_prints_are_rich_and_plain_items_are_not(cell: Cell) -> None:
    """The largest face of what is printed has strong edges; cloth has its colour everywhere."""

    def contrast(name: str) -> float:
        return float(face_textures(cell.item(name), 0)[4].astype(float).std(axis=(0, 1)).mean())

    assert contrast("laugh_out_loud_joke_book") > 40.0
    assert contrast("womens_knit_gloves") < 15.0
    mean = face_textures(cell.item("womens_knit_gloves"), 0)[4].mean(axis=(0, 1))
    np.testing.assert_allclose(mean, cell.item("womens_knit_gloves").colour or (), atol=6.0)


def scene_of(cell: Cell, *names: str) -> Scene:
    frame = cell.T_world_place(cell.places["bin_E"])
    items = [
        PlacedItem(f"{name}#{i}", cell.item(name), "bin_E", frame @ pose((0.12, 0.08 - 0.16 * i, 0.1)))
        for i, name in enumerate(names)
    ]
    return replace(empty_scene(cell), items=tuple(items))


def test_a_colour_picture_shows_items_before_the_shelf_and_is_reproducible(cell: Cell) -> None:
    looking, hand = cell.configurations["cam_E"], cell.cameras["hand"]
    T = camera_pose(cell.robot, hand, looking.q, looking.tool_state)
    rendered = RenderedScene.of(
        scene_of(cell, "dove_beauty_bar", "crayola_24_ct"), looking.q, looking.tool_state
    )
    picture = colour_picture(rendered, hand.model.camera, T)
    assert picture.shape == (1024, 1280, 3)
    assert picture.dtype == np.uint8
    assert picture.tobytes() == colour_picture(rendered, hand.model.camera, T).tobytes()
    index = rendered.seen_by(hand.model.camera, T).index
    on_items = np.isin(index, [i for i, solid in enumerate(rendered.solids) if solid.item is not None])
    assert on_items.sum() > 20_000
    for changed in (
        colour_picture(rendered, hand.model.camera, T, texture_seed=1),
        colour_picture(rendered, hand.model.camera, T, lighting=replace(HALL, lamp=0.1)),
    ):
        assert (changed != picture).any(axis=-1)[on_items].mean() > 0.5
    other_prints = colour_picture(rendered, hand.model.camera, T, texture_seed=1)
    assert (other_prints == picture)[~on_items].all()


def test_copies_of_an_item_look_alike_and_items_without_a_stated_colour_have_one(cell: Cell) -> None:
    """Two copies side by side, seen from straight ahead, have about the same mean colour."""
    looking, hand = cell.configurations["cam_E"], cell.cameras["hand"]
    T = camera_pose(cell.robot, hand, looking.q, looking.tool_state)
    scene = scene_of(cell, "dove_beauty_bar", "dove_beauty_bar")
    nameless = [replace(each, item=replace(each.item, colour=None)) for each in scene.items]
    rendered = RenderedScene.of(replace(scene, items=tuple(nameless)), looking.q, looking.tool_state)
    lighting = replace(HALL, lamp=0.0, ambient=1.0, headlight=0.0)
    picture = colour_picture(rendered, hand.model.camera, T, lighting=lighting)
    index = rendered.seen_by(hand.model.camera, T).index
    means = [picture[index == i].mean(axis=0) for i in (0, 1)]
    np.testing.assert_allclose(means[0], means[1], atol=25.0)
    assert np.ptp(means[0]) > 5.0
