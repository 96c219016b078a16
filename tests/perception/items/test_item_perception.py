"""Items of a bin are found in one noisy look, and what is not there is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import inverse, pose
from pickcli.perception.items import item_search
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.perceived_file import Perceived, perceived_values
from pickcli.perception.items.symmetry import turn_between
from pickcli.random_scenes.make_scene import make_scene
from support.filled_bins import Filled, looked_at, looked_at_as


def test_all_items_are_found_within_millimetres(filled: Filled) -> None:
    observed = filled.perceived()
    assert [each.id for each in observed.items] == [each.id for each in filled.listed]
    for answer, placed in zip(observed.items, filled.scene.in_location("bin_E"), strict=True):
        assert answer.is_answer, answer.refusal
        assert answer.T_world_item is not None
        T, T_true = answer.T_world_item, placed.T_world_item
        assert np.linalg.norm(T[:3, 3] - T_true[:3, 3]) < 0.004, answer.id
        assert turn_between(placed.item.shape, T[:3, :3], T_true[:3, :3]) < np.radians(3.0), answer.id
        if answer.bound is not None:
            assert np.linalg.norm(T[:3, 3] - T_true[:3, 3]) < answer.bound.position
            assert turn_between(placed.item.shape, T[:3, :3], T_true[:3, :3]) <= answer.bound.angle
    assert any(answer.bound is not None for answer in observed.items)
    assert observed.unexplained == ()
    assert not observed.has_unlisted


def test_same_picture_same_bytes(filled: Filled) -> None:
    texts = []
    for _ in range(2):
        observed = filled.perceived()
        texts.append(
            str(perceived_values(Perceived("c", "hand", "s", filled.rgbd.T_world_camera, (observed,))))
        )
    assert texts[0] == texts[1]


def test_the_order_of_the_list_does_not_matter_to_what_is_found(filled: Filled) -> None:
    there = {each.id: each.T_world_item for each in filled.perceived().items}
    for answer in filled.perceived(filled.listed[::-1]).items:
        T, other = answer.T_world_item, there[answer.id]
        assert T is not None
        assert other is not None
        assert np.linalg.norm(T[:3, 3] - other[:3, 3]) < 0.003


def test_what_is_listed_but_not_there_is_refused(filled: Filled) -> None:
    missing = filled.scene.cell.item("cherokee_easy_tee_shirt", 2016)
    answers = filled.perceived([*filled.listed, ListedItem(missing.name, missing)]).items
    assert not answers[-1].is_answer
    assert "confidence" in answers[-1].refusal or "no pose" in answers[-1].refusal
    assert all(answer.is_answer for answer in answers[:-1])


def test_what_is_there_but_not_listed_is_told(filled: Filled) -> None:
    for item_id in ("folgers_classic_roast_coffee", "rawlings_baseball"):
        observed = filled.perceived([each for each in filled.listed if each.id != item_id])
        assert observed.unexplained, item_id
        assert observed.has_unlisted or observed.refused, item_id
        middle = (observed.unexplained[0].low + observed.unexplained[0].high) / 2
        placed = inverse(filled.T_world_place) @ filled.scene.find(item_id).T_world_item
        assert np.linalg.norm(middle[:2] - placed[:2, 3]) < 0.15


def test_a_clear_item_that_is_not_listed_is_told_by_the_little_that_comes_back(cell: Cell) -> None:
    """Nothing comes back from 85 % of it; colours alone would not tell."""
    seen = looked_at(make_scene({"bin_E": ("command_hooks", "rawlings_baseball")}, cell, seed=5))
    listed = [each for each in seen.listed if each.id == "rawlings_baseball"]
    observed = seen.perceived(listed)
    assert observed.has_unlisted
    middle = (observed.unexplained[0].low + observed.unexplained[0].high) / 2
    placed = inverse(seen.T_world_place) @ seen.scene.find("command_hooks").T_world_item
    assert np.linalg.norm(middle[:2] - placed[:2, 3]) < 0.15
    assert seen.perceived().unexplained == ()


def test_an_empty_bin_has_nothing_to_be_found(filled: Filled) -> None:
    empty = looked_at(replace(filled.scene, items=()))
    assert not any(answer.is_answer for answer in empty.perceived(filled.listed).items)
    assert empty.perceived([]).items == ()
    assert not empty.perceived([]).has_unlisted


def test_what_is_left_is_somewhere(filled: Filled, monkeypatch: pytest.MonkeyPatch) -> None:
    """Pixels in which nothing was measured, before nothing that is known, are in no part."""
    search = filled.looked([]).search
    depth, points, is_before, is_odd = search._left({}, 0.005)
    points, odd = points.copy(), np.zeros_like(is_odd)
    odd[20:60, 20:60] = True
    points[20:60, 20:60] = (0.1, 0.0, 0.05)
    points[20:60, 40:60] = np.nan
    monkeypatch.setattr(type(search), "_left", lambda *_: (depth, points, np.zeros_like(is_before), odd))
    monkeypatch.setattr(item_search, "_sparsely_measured", lambda *_: np.zeros_like(odd))
    (part,) = search.unexplained({})
    assert part.n_pixels == 800 and np.isfinite([part.low, part.high]).all()


@pytest.mark.parametrize(("at", "name"), [("bin_E", "bin_A"), ("bin_H", "bin_D"), ("bin_L", "bin_E")])
def test_what_the_second_eye_does_not_see_is_no_item(filled: Filled, at: str, name: str) -> None:
    """Beside a post nothing comes back from the back of an empty bin."""
    aside = looked_at(replace(filled.scene, items=()), at=at)
    assert replace(aside, place=filled.scene.cell.places[name]).perceived([]).unexplained == ()


def test_an_item_may_be_hidden_by_another(filled: Filled) -> None:
    """A ball right behind a box is seen by nobody, and nobody claims to have seen it."""
    scene = filled.scene
    box, ball = scene.find("kleenex_tissue_box"), scene.find("rawlings_baseball")
    front = replace(box, T_world_item=filled.T_world_place @ pose((0.15, 0.0, 0.055)))
    behind = replace(ball, T_world_item=filled.T_world_place @ pose((0.27, 0.0, 0.012)))
    hidden = looked_at(replace(scene, items=(front, behind)))
    answers = {answer.id: answer for answer in hidden.perceived().items}
    assert answers[box.id].is_answer
    T = answers[ball.id].T_world_item
    assert not answers[ball.id].is_answer or (
        T is not None and np.linalg.norm(T[:3, 3] - behind.T_world_item[:3, 3]) < 0.03
    )


def test_an_item_does_not_end_where_the_range_of_the_sensor_begins(filled: Filled) -> None:
    """The upper half of a cup that stands in front is nearer than Kinect v2 measures."""
    scene, cup = filled.scene, filled.scene.cell.item("easter_turtle_sippy_cup", 2016)
    up = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    T = filled.T_world_place @ pose((0.06, -0.03, 0.047), R=up)
    stands = replace(scene.items[0], id=cup.name, item=cup, T_world_item=T)
    seen = looked_at_as(replace(scene, items=(stands,)), "kinect_v2")
    (answer,) = seen.perceived().items
    assert answer.is_answer, answer.refusal
    error = seen.error_of(answer)
    assert error.position < 0.004 and error.angle < np.radians(3.0), error


def test_an_item_without_a_model_is_told(filled: Filled) -> None:
    corners = ((0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.0, 0.1, 0.0), (0.0, 0.0, 0.1))
    shape = Shape(ShapeKind.HULL, (0.1, 0.1, 0.1), corners)
    item = replace(filled.listed[0].item, name="a_rock", shape=shape)
    with pytest.raises(InputError, match="a_rock: has no model: its shape is a hull"):
        filled.perceived([ListedItem(item.name, item)])


def test_a_place_beside_the_picture_is_told(filled: Filled) -> None:
    other = replace(filled, place=filled.scene.cell.places["tote"])
    with pytest.raises(InputError, match="tote: is not in the picture"):
        other.perceived(filled.listed)


def test_what_lies_before_the_mouth_is_not_in_the_bin(filled: Filled) -> None:
    """A can that would fall out is not the one in the bin, however well that fits the picture."""
    scene = filled.scene
    can = scene.find("folgers_classic_roast_coffee")
    before = replace(can, T_world_item=filled.T_world_place @ pose((-0.03, 0.0, 0.07)))
    observed = looked_at(replace(scene, items=(before,))).perceived()
    for answer in observed.items:
        assert not answer.is_answer, answer.T_world_item


@pytest.mark.parametrize("name", ["bin_D", "bin_H", "bin_G"])
def test_a_place_of_which_little_is_seen_is_told_with_the_share(filled: Filled, name: str) -> None:
    beside = replace(filled, place=filled.scene.cell.places[name])
    with pytest.raises(InputError, match=rf"{name}: \d+% of its room is seen, at least 50% must be"):
        beside.perceived([])


@pytest.mark.parametrize(
    ("listed", "there"),
    [
        ("cloud_b_plush_bear", "kyjen_squeakin_eggs_plush_puppies"),
        ("rolodex_jumbo_pencil_cup", "kleenex_tissue_box"),
    ],
)
def test_what_has_not_the_colours_of_a_listed_item_is_not_taken_for_it(
    cell: Cell, listed: str, there: str
) -> None:
    seen = looked_at(make_scene({"bin_E": (there,)}, cell, seed=5))
    observed = seen.perceived([ListedItem(listed, cell.item(listed, 2016))])
    (answer,) = observed.items
    assert answer.T_world_item is not None
    assert answer.refusal.endswith("of what is seen of it has its colours: another item may be there")
    assert answer.bound is None and answer.confidence < 0.5
    assert observed.unexplained and len(observed.unrecognised)
    right = seen.perceived([ListedItem(there, cell.item(there, 2016))])
    assert right.items[0].is_answer
