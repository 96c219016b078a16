"""Files of perceived items come back as they were written, and mistakes in them are told."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError, UnknownNameError
from pickcli.perception.items.item_observation import FoundBy
from pickcli.perception.items.perceived_file import (
    Perceived,
    perceived_values,
    read_perceived,
    write_perceived,
)
from support.filled_bins import Filled


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
        (
            ("places", 0, "unknown"),
            [[[0.1, 0.0, 0.0], [0.0, 0.1, 0.1]]],
            r"places\[0\].unknown\[0\]: is no box",
        ),
    ],
)
def test_mistakes_are_told(
    perceived: Perceived, cell: Cell, tmp_path: Path, where: tuple[str | int, ...], value: Any, told: str
) -> None:
    content = json.loads(json.dumps(perceived_values(perceived)))
    part = content
    for key in where[:-1]:
        part = part[key]
    part[where[-1]] = value
    path = tmp_path / "perceived.json"
    path.write_text(json.dumps(content))
    with pytest.raises((InputError, UnknownNameError), match=told):
        read_perceived(path, cell)


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
    items = tuple(replace(each, found_by=FoundBy.PRINT) for each in place.items)
    write_perceived(replace(perceived, places=(replace(place, items=items),)), path)
    assert {each.found_by for each in read_perceived(path, cell).places[0].items} == {FoundBy.PRINT}
    content = json.loads(path.read_text())
    for item in content["places"][0]["items"]:
        del item["found_by"]
    path.write_text(json.dumps(content))
    assert {each.found_by for each in read_perceived(path, cell).places[0].items} == {FoundBy.SHAPE}
