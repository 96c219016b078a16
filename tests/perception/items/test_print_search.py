"""With their prints, items are found with the right face; without OpenCV nothing else is different."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import inverse, rotation_angle
from pickcli.perception.items.item_observation import FoundBy
from pickcli.perception.items.item_perception import PlaceLook, concluded, perceive_items
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.perceived_file import Perceived, perceived_values
from pickcli.perception.items.place_view import view_of_place
from pickcli.perception.items.print_search import picture_features, prints_in
from pickcli.perception.items.routing import NO_PRINTS, PrintSearch
from pickcli.perception.items.symmetry import error_of
from pickcli.perception.textures.sift_views import SiftRule, SiftViews
from pickcli.random_scenes.make_scene import make_scene
from support.filled_bins import Filled, looked_at, looked_at_aslant

PRINTS = PrintSearch(SiftRule.ALL, 21)
CONTENTS = ("dove_beauty_bar", "crayola_24_ct", "rawlings_baseball", "womens_knit_gloves")


@pytest.fixture(scope="module")
def printed(cell: Cell) -> Filled:
    return looked_at(make_scene({"bin_E": CONTENTS}, cell, seed=6), texture_seed=21)


def look(seen: Filled, listed: list[ListedItem], prints: PrintSearch = PRINTS) -> PlaceLook:
    return PlaceLook.of(seen.rgbd, seen.place, seen.T_world_place, listed, seen.known, prints)


def test_prints_tell_the_faces_and_shapes_do_not(printed: Filled) -> None:
    observed = concluded([look(printed, printed.listed)])
    n_by_print = 0
    for answer in observed.items:
        if answer.found_by is not FoundBy.PRINT:
            continue
        n_by_print += 1
        assert answer.is_answer and answer.item.is_printed and answer.T_world_item is not None
        true = printed.scene.find(answer.id).T_world_item
        assert rotation_angle(answer.T_world_item[:3, :3].T @ true[:3, :3]) < np.radians(10.0), answer.id
        assert np.linalg.norm(answer.T_world_item[:3, 3] - true[:3, 3]) < 0.004, answer.id
    assert n_by_print >= 2
    alone = printed.perceived()
    assert all(answer.found_by is FoundBy.SHAPE for answer in alone.items)


def test_what_is_not_printed_or_not_there_is_not_claimed_by_print(printed: Filled) -> None:
    absent = [printed.scene.cell.item(name, 2016) for name in ("laugh_out_loud_joke_book", "command_hooks")]
    listed = [*printed.listed, *(ListedItem(item.name, item) for item in absent)]
    view = view_of_place(printed.rgbd, printed.place, printed.T_world_place, printed.known)
    assert view is not None
    items = [each.item for each in listed]
    views = {item: SiftViews.ALL for item in items if item.is_printed}
    found = prints_in(printed.rgbd, view, items, views, PRINTS.texture_seed)
    assert {item.name for item in found} <= {name for name in CONTENTS if name != "womens_knit_gloves"}
    assert prints_in(printed.rgbd, view, items, {}, PRINTS.texture_seed) == {}


def test_prints_of_another_set_find_the_same_without_bounds(printed: Filled) -> None:
    """What shows no print that is looked for may be another item."""
    other = concluded([look(printed, printed.listed, PrintSearch(SiftRule.ALL, 22))])
    assert all(answer.found_by is FoundBy.SHAPE for answer in other.items)
    alone = printed.perceived()
    assert [answer.id for answer in other.items] == [answer.id for answer in alone.items]
    for ours, theirs in zip(other.items, alone.items, strict=True):
        assert (ours.refusal, ours.confidence) == (theirs.refusal, theirs.confidence)
        np.testing.assert_array_equal(ours.T_world_item, theirs.T_world_item)
        assert ours.bound == (None if ours.item.is_printed else theirs.bound)


def test_same_picture_same_bytes(printed: Filled) -> None:
    texts = []
    for _ in range(2):
        observed = perceive_items(
            printed.rgbd, printed.place, printed.T_world_place, printed.listed, printed.known, PRINTS
        )
        texts.append(
            str(perceived_values(Perceived("c", "hand", "s", printed.rgbd.T_world_camera, (observed,))))
        )
    assert texts[0] == texts[1]


def test_a_face_that_one_of_two_looks_knows_is_known(printed: Filled) -> None:
    aslant = looked_at_aslant(printed.scene, texture_seed=21)
    looks = [look(printed, printed.listed), look(aslant, printed.listed, NO_PRINTS)]
    for answer in concluded(looks).items:
        if answer.found_by is FoundBy.PRINT and answer.T_world_item is not None:
            true = printed.scene.find(answer.id).T_world_item
            assert rotation_angle(answer.T_world_item[:3, :3].T @ true[:3, :3]) < np.radians(10.0)
    by = {answer.id: answer.found_by for answer in concluded(looks).items}
    alone = {answer.id: answer.found_by for answer in concluded(looks[:1]).items}
    assert {name for name, how in by.items() if how is FoundBy.PRINT} == {
        name for name, how in alone.items() if how is FoundBy.PRINT
    }


def test_features_are_where_items_are(printed: Filled) -> None:
    view = view_of_place(printed.rgbd, printed.place, printed.T_world_place, printed.known)
    assert view is not None
    seen = picture_features(printed.rgbd, view)
    assert len(seen.features) > 100
    is_measured = np.isfinite(seen.points).all(axis=1)
    np.testing.assert_allclose(
        seen.camera.project(seen.points[is_measured]), seen.features.pixels[is_measured], atol=1e-6
    )
    T_place_camera = inverse(view.T_camera_place)
    at = seen.points[is_measured] @ T_place_camera[:3, :3].T + T_place_camera[:3, 3]
    room = printed.place.room
    assert ((at > room.low - 0.03) & (at < room.high + 0.03)).all(axis=1).mean() > 0.98


def test_an_empty_place_has_no_prints(printed: Filled) -> None:
    empty = looked_at(replace(printed.scene, items=()), texture_seed=21)
    assert not any(answer.is_answer for answer in concluded([look(empty, printed.listed)]).items)


@pytest.fixture(scope="module")
def clear(cell: Cell) -> tuple[Filled, Filled]:
    contents = ("dasani_water_bottle", "command_hooks", "dove_beauty_bar")
    scene = make_scene({"bin_E": contents}, cell, seed=6)
    return looked_at(scene, texture_seed=21), looked_at_aslant(scene, texture_seed=21)


def test_clear_items_have_narrow_bounds_by_the_print_in_two_looks(clear: tuple[Filled, Filled]) -> None:
    listed = clear[0].listed
    for answer in concluded([look(each, listed) for each in clear]).items:
        assert answer.found_by is FoundBy.PRINT and answer.T_world_item is not None, answer.id
        assert answer.is_answer and answer.bound is not None, answer.id
        true = clear[0].scene.find(answer.id).T_world_item
        assert answer.bound.holds(error_of(answer.item.shape, answer.T_world_item, true)), answer.id
        assert answer.bound.position < 0.005 and answer.bound.angle < np.radians(3.0), answer.id


def test_the_print_of_two_looks_is_believed_where_no_shape_was_found(clear: tuple[Filled, Filled]) -> None:
    listed = clear[0].listed
    looks = [replace(look(each, listed), found={}) for each in clear]
    assert [answer.is_answer for answer in concluded(looks).items] == [True] * len(listed)
    assert not any(answer.is_answer for answer in concluded(looks[:1]).items)
    unknown = [replace(each, prints={}) for each in looks]
    assert not any(answer.is_answer for answer in concluded(unknown).items)


def test_what_may_be_deformed_is_not_placed_by_its_print(clear: tuple[Filled, Filled]) -> None:
    listed = [replace(each, deformation=0.004) for each in clear[0].listed]
    looks = [replace(look(each, clear[0].listed), found={}, listed=tuple(listed)) for each in clear]
    assert not any(answer.is_answer for answer in concluded(looks).items)
