"""Files of perceived items come back as they were written, and mistakes in them are told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.perception.items.item_observation import FoundBy
from pickcli.perception.items.perceived_file import (
    Perceived,
    perceived_values,
    read_perceived,
    write_perceived,
)
from support.filled_bins import Filled

Where: TypeAlias = tuple[str | int, ...]


@pytest.fixture(scope="module")
def perceived(filled: Filled) -> Perceived:
    return Perceived(
        filled.scene.cell.name, "hand", "ensenso", filled.rgbd.T_world_camera, (filled.perceived(),)
    )


def test_a_file_is_read_as_it_was_written(perceived: Perceived, cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "perceived.json"
    write_perceived(perceived, path)
    again = read_perceived(path, cell)
    ours, theirs = perceived_values(perceived), perceived_values(again)
    for place in (*ours["places"], *theirs["places"]):  # quaternions of matrices are rounded
        for item in place["items"]:
            item["pose"] = {key: np.round(value, 12).tolist() for key, value in item["pose"].items()}
    assert ours["places"] == theirs["places"]
    assert again.versions == {}, "files from before state none"
    write_perceived(replace(perceived, versions={"numpy": "2.0", "opencv": "4.1"}), path)
    assert read_perceived(path, cell).versions == {"numpy": "2.0", "opencv": "4.1"}
    np.testing.assert_allclose(again.T_world_camera, perceived.T_world_camera, atol=1e-12)


@pytest.mark.parametrize(
    ("where", "value", "told"),
    [
        (("format",), "apc scene", "is a scene, but a file of perceived items is expected"),
        (("version",), 2, "version"),
        (("places", 0, "place"), "bin_Z", "bin_Z"),
        (("camera",), "waist", "has no camera waist, it has hand, boom"),
        (("sensor",), "carmine", "camera hand of cell apc2016_delft is ensenso by now"),
        (("places", 0, "items", 0, "confidence"), 1.5, "confidence"),
        (("places", 0, "items", 0, "found_by"), "smell", '"shape" or "print"'),
        (("places", 0, "items", 0, "pose", "quaternion"), [0.0, 0.0, 0.0, 0.5], "expected a length of 1"),
        (("places", 0, "items", 0, "pose", "position"), [0.0, 0.0], "position"),
        (("places", 0, "items", 0, "name"), "no_such_item", "no_such_item"),
        (("places", 0, "items", 0, "colour"), "red", "colour"),
        (("made_from",), {"versions": {"opencv": 4}}, r"made_from\.versions\.opencv"),
        (
            ("places", 0, "unknown"),
            [[[0.1, 0.0, 0.0], [0.0, 0.1, 0.1]]],
            r"places\[0\].unknown\[0\]: is no box",
        ),
    ],
)
def test_mistakes_are_told(
    perceived: Perceived, cell: Cell, tmp_path: Path, where: Where, value: Any, told: str
) -> None:
    path = _changed(perceived, tmp_path, {where: value})
    with pytest.raises(InputError, match=told):
        read_perceived(path, cell)


_ITEM: Where = ("places", 0, "items", 0)  # a printed one, whose print was left out
_NO_POSE: dict[Where, object] = {(*_ITEM, "pose"): None, (*_ITEM, "confidence"): 0.0}
_PLAIN = {"name": "platinum_pets_dog_bowl", "year": 2016}
_BY_PRINT = {"views": "all-views", "why": "", "twins": []}
_NINE = [9.0, 9.0, 9.0]


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({("places", 0, "seen"): 0.3}, r"places\[0\].seen: expected a share of its room: .*0.5, got 0.3"),
        ({(*_ITEM, "refusal"): "no"}, r"items\[0\].bound: a refused pose has none"),
        ({(*_ITEM, "confidence"): 0.9}, r"items\[0\].bound: the confidence is 0.9, and below 0.99 nothing"),
        ({(*_ITEM, "confidence"): 0.7, (*_ITEM, "bound"): None}, r"items\[0\].confidence: 0.7 is below 0.8"),
        (
            {(*_ITEM, "support", "own_colour"): 0.4, (*_ITEM, "bound"): None, (*_ITEM, "found_by"): "shape"},
            r"items\[0\].support.own_colour: 0.4 is below 0.7",
        ),
        (
            {(*_ITEM, "support"): None, (*_ITEM, "bound"): None, (*_ITEM, "found_by"): "shape"},
            r"items\[0\].support: is null, and the item was found by shape",
        ),
        ({(*_ITEM, "support", "shown"): 10**6}, r"items\[0\].support.shown: is over expected"),
        ({(*_ITEM, "support", "through"): 10**6}, r"supported: is with through and before \d+, over shown"),
        (
            {("places", 0, "pose", "position"): [0.0, 0.5, 1.2]},
            r"pose: with it the pod of bin_.* (leans|is beyond)",
        ),
        (
            {
                (*_ITEM, "pose"): None,
                (*_ITEM, "refusal"): "no",
                (*_ITEM, "bound"): None,
                (*_ITEM, "support"): None,
            },
            r"items\[0\].confidence: is that of a pose, and there is none",
        ),
        ({(*_ITEM, "bound", "angle"): 0.2}, r"items\[0\].bound: is wider than 0.015 m or 0.1396 rad"),
        (
            {**_NO_POSE, (*_ITEM, "bound"): None, (*_ITEM, "support"): None},
            r"items\[0\].pose: is null without a refusal",
        ),
        (
            {**_NO_POSE, (*_ITEM, "refusal"): "no", (*_ITEM, "bound"): None},
            r"items\[0\].support: is that of a pose, and there is none",
        ),
        (
            {(*_ITEM, "route", "views"): "all-views", (*_ITEM, "bound"): None},
            r"items\[0\].route.why: 'prints are left out' says why no print was looked for",
        ),
        ({(*_ITEM, "route", "why"): ""}, r"items\[0\].route.why: is empty, and views null"),
        (
            {(*_ITEM, "route", "why"): "it is plain"},
            r"route.why: 'it is plain', but kleenex_tissue_box is printed",
        ),
        (
            {**{(*_ITEM, key): value for key, value in _PLAIN.items()}, (*_ITEM, "route"): _BY_PRINT},
            r"items\[0\].route.views: a print of platinum_pets_dog_bowl was looked for, but it is plain",
        ),
        ({(*_ITEM, "found_by"): "print"}, r"items\[0\].found_by: is \"print\", but by its route no print"),
        (
            {(*_ITEM, "route"): _BY_PRINT},
            r"items\[0\].bound: its print was looked for and not recognised",
        ),
        ({(*_ITEM, "route", "twins"): ["ghost"]}, r"route.twins\[0\]: 'ghost' is not among the other items"),
        ({(*_ITEM, "route", "twins"): ["kleenex_tissue_box"]}, r"twins\[0\]: .*not among the other items"),
        (
            {(*_ITEM, "route", "twins"): ["rawlings_baseball"] * 2},
            r"twins\[1\]: 'rawlings_baseball' stands twice",
        ),
        ({("places", 0, "items", 1, "id"): "kleenex_tissue_box"}, r"items\[1\].id: .* stands twice"),
        ({("camera_pose", "position"): _NINE}, r"camera_pose.position: is 16.7 m from the base of"),
        ({("also_from",): [{"position": _NINE, "quaternion": [0, 0, 0, 1]}]}, r"also_from\[0\].position: is"),
        (
            {("places", 0, "pose", "position"): _NINE},
            r"places\[0\].pose: with it the pod of bin_E leans, or is not on the floor",
        ),
        ({(*_ITEM, "pose", "position"): _NINE}, r"items\[0\].pose.position: kleenex_tissue_box is 15"),
        (
            {(*_ITEM, "pose", "position"): _NINE, (*_ITEM, "bound"): None, (*_ITEM, "refusal"): "no"},
            r"kleenex_tissue_box is 15 m from the camera, which measures up to 1.307 m",
        ),
        (
            {(*_ITEM, "pose", "position"): [0.3, 0.07, 1.1]},
            r"items\[0\].pose.position: the middle of kleenex_tissue_box is outside of bin_E",
        ),
    ],
)
def test_what_no_look_can_say_is_refused_with_its_line(
    perceived: Perceived, cell: Cell, tmp_path: Path, changes: dict[Where, Any], told: str
) -> None:
    path = _changed(perceived, tmp_path, changes)
    with pytest.raises(InputError, match=rf"^{path}:\d+:\d+: .*{told}") as error:
        read_perceived(path, cell)
    assert str(error.value).count("\n") == 0, "one message each"


def test_a_place_has_one_answer(perceived: Perceived, cell: Cell, tmp_path: Path) -> None:
    other = perceived_values(perceived)["places"][0] | {"items": []}
    path = _changed(perceived, tmp_path, {("places", 1): other})
    with pytest.raises(InputError, match=rf"{path}:\d+:\d+: places\[1\].place: bin_E stands twice"):
        read_perceived(path, cell)


@pytest.mark.parametrize("where", [("places", 0, "place"), (*_ITEM, "name")])
def test_unknown_names_are_told_with_their_line(
    perceived: Perceived, cell: Cell, tmp_path: Path, where: Where
) -> None:
    path = _changed(perceived, tmp_path, {where: "no_such"})
    lines = path.read_text().splitlines()
    line = next(i for i, text in enumerate(lines, 1) if "no_such" in text)
    with pytest.raises(InputError, match=rf"^{path}:{line}:\d+: .*unknown (place|item) 'no_such'"):
        read_perceived(path, cell)


def test_a_fixed_camera_is_where_the_cell_has_it(perceived: Perceived, cell: Cell, tmp_path: Path) -> None:
    hand = replace(cell.cameras["hand"], link=None, T_parent_camera=perceived.T_world_camera)
    fixed = replace(cell, cameras={**cell.cameras, "hand": hand})
    path = tmp_path / "perceived.json"
    write_perceived(perceived, path)
    read_perceived(path, fixed)
    path = _changed(
        perceived, tmp_path, {("camera_pose", "position", 2): perceived.T_world_camera[2, 3] + 0.1}
    )
    with pytest.raises(InputError, match=r"is 0\.1 m from where cell apc2016_delft has camera hand"):
        read_perceived(path, fixed)


def _changed(perceived: Perceived, folder: Path, changes: dict[Where, Any]) -> Path:
    """A file with other values at some keys; one at the end of a list is appended."""
    content = json.loads(json.dumps(perceived_values(perceived)))
    for where, value in changes.items():
        part = content
        for key in where[:-1]:
            part = part[key]
        if isinstance(part, list) and where[-1] == len(part):
            part.append(value)
        else:
            part[where[-1]] = value
    path = folder / "perceived.json"
    path.write_text(json.dumps(content, indent=1))
    return path


@pytest.mark.parametrize("key", ["unknown", "error", "seen"])
def test_what_is_not_known_has_to_be_stated(
    perceived: Perceived, cell: Cell, tmp_path: Path, key: str
) -> None:
    """Space of which nothing is said would count as free."""
    content = json.loads(json.dumps(perceived_values(perceived)))
    del content["places"][0][key]
    path = tmp_path / "perceived.json"
    path.write_text(json.dumps(content))
    with pytest.raises(InputError, match=key):
        read_perceived(path, cell)


def test_by_what_items_were_found_is_kept_and_older_files_do_not_say(
    perceived: Perceived, cell: Cell, tmp_path: Path
) -> None:
    path = tmp_path / "perceived.json"
    (place,) = perceived.places
    items = tuple(replace(each, found_by=FoundBy.PRINT, route=None) for each in place.items)
    write_perceived(replace(perceived, places=(replace(place, items=items),)), path)
    assert {each.found_by for each in read_perceived(path, cell).places[0].items} == {FoundBy.PRINT}
    content = json.loads(path.read_text())
    for item in content["places"][0]["items"]:
        del item["found_by"]
    path.write_text(json.dumps(content))
    assert {each.found_by for each in read_perceived(path, cell).places[0].items} == {FoundBy.SHAPE}


@pytest.mark.parametrize(("found_by", "own"), [("shape", 0.7), ("print", 0.1), ("shape", None)])
def test_colours_count_for_what_was_found_by_shape_alone(
    perceived: Perceived, cell: Cell, tmp_path: Path, found_by: str, own: float | None
) -> None:
    """And files that say nothing of them are read, as those of earlier versions."""
    content = json.loads(json.dumps(perceived_values(perceived)))
    item = content["places"][0]["items"][0]
    item.update(found_by=found_by, bound=None, route=None)
    if own is None:
        del item["support"]["own_colour"]
    else:
        item["support"]["own_colour"] = own
    path = tmp_path / "perceived.json"
    path.write_text(json.dumps(content))
    answer = read_perceived(path, cell).places[0].items[0]
    assert answer.is_answer and answer.support is not None
    assert answer.support.own_colour == (1.0 if own is None else own)
