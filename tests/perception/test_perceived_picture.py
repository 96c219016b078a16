"""Answers over a picture: outlines where items are seen, in the colour of how sure they are; text below."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.items.item_observation import ItemObservation, PlaceObservation
from pickcli.perception.items.perceived_file import Perceived
from pickcli.perception.items.rgbd_picture import RgbdPicture
from pickcli.perception.looks import colour_picture
from pickcli.perception.perceived_picture import ANSWERED, BOUNDED, REFUSED, Ink, ink_of, perceived_picture
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import PlacedItem, PoseNoise, empty_scene

ITEM, BIN = "kleenex_tissue_box", "bin_E"
BOUND = PoseNoise(0.004, 0.05, 0.008)
Look = tuple[RgbdPicture, RenderedScene]


@pytest.fixture(scope="module")
def look(cell: Cell) -> Look:
    """An empty bin, as the camera on the hand sees it."""
    at, hand = cell.configurations["cam_E"], cell.cameras["hand"]
    T = camera_pose(cell.robot, hand, at.q, at.tool_state)
    known = RenderedScene.of(empty_scene(cell), at.q, at.tool_state)
    depth = measure_depth(known, hand.model, T, seed=0).depth
    return RgbdPicture(hand.model, T, depth, colour_picture(known, hand.model.camera, T)), known


def answer(
    cell: Cell, refusal: str = "", bound: PoseNoise | None = None, deep: float = 0.2
) -> ItemObservation:
    """A box that stands in the middle of the bin, so deep in it."""
    item, place = cell.item(ITEM), cell.places[BIN]
    up = float(place.room.floor_at(deep) + item.shape.extents[2] / 2)
    T = cell.T_world_place(place) @ pose((deep, 0.0, up))
    return ItemObservation(ITEM, item, T, 0.9, refusal, bound, None)


def drawn(look: Look, cell: Cell, *answers: ItemObservation) -> NDArray[np.uint8]:
    rgbd, known = look
    place = PlaceObservation(BIN, cell.T_world_place(cell.places[BIN]), answers)
    perceived = Perceived(cell.name, "hand", rgbd.sensor.name, rgbd.T_world_camera, (place,))
    return perceived_picture(rgbd, known, perceived)


@pytest.mark.parametrize(
    ("refusal", "bound", "ink"), [("", BOUND, BOUNDED), ("", None, ANSWERED), ("too unsure", None, REFUSED)]
)
def test_outlines_have_the_colour_of_how_sure_a_pose_is_and_are_where_the_item_is_seen(
    look: Look, cell: Cell, refusal: str, bound: PoseNoise | None, ink: Ink
) -> None:
    rgbd = look[0]
    found = answer(cell, refusal, bound)
    assert ink_of(found) == ink
    height = rgbd.colour.shape[0]
    picture = drawn(look, cell, found)[:height]
    rows, columns = np.nonzero((picture == ink).all(axis=2) & (rgbd.colour != ink).any(axis=2))
    assert found.T_world_item is not None
    at, there = cell.configurations["cam_E"], PlacedItem(ITEM, found.item, BIN, found.T_world_item)
    rendered = RenderedScene.of(replace(empty_scene(cell), items=(there,)), at.q, at.tool_state)
    view = rendered.seen_by(rgbd.sensor.camera, rgbd.T_world_camera)
    seen = view.index == rendered.indices_of(ITEM)[0]
    assert len(rows) > 300 and seen[rows, columns].all()
    for at_rows, edge in (
        (rows, np.nonzero(seen.any(axis=1))[0]),
        (columns, np.nonzero(seen.any(axis=0))[0]),
    ):
        assert abs(at_rows.min() - edge.min()) <= 1 and abs(at_rows.max() - edge.max()) <= 1


def test_every_listed_item_has_a_line_also_without_a_pose(look: Look, cell: Cell) -> None:
    nowhere = replace(
        answer(cell), id="nowhere", T_world_item=None, refusal="no pose explains the picture better"
    )
    heights = [len(drawn(look, cell, *answers)) for answers in ((), (nowhere,), (nowhere, answer(cell)))]
    assert heights[1] > heights[0] and heights[2] - heights[1] == heights[1] - heights[0]
    assert (drawn(look, cell, nowhere)[: len(look[0].colour)] == look[0].colour).all()


def test_the_picture_itself_is_left_alone_and_the_same_answers_give_the_same_picture(
    look: Look, cell: Cell
) -> None:
    before = look[0].colour.copy()
    one, two = (drawn(look, cell, answer(cell, bound=BOUND)) for _ in range(2))
    assert (one == two).all() and (look[0].colour == before).all()
