"""``apc inspect --plot``: drawn, told, or refused before any work."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.drawing.cell_picture import cell_picture
from pickcli.drawing.picture import Colour
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import write_roadmap
from pickcli.scene.scene import empty_scene
from pickcli.scene.scene_file import write_scene
from support.cell_copies import CellCopy
from support.command_line import apc
from support.page_files import document_of
from support.place_cells import BENCH, CRATES, with_places


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    cell = load_cell("apc2016_delft")
    roadmap = Roadmap.empty(cell.robot.joint_names)
    for name in ("home", "bin_A"):
        roadmap, _ = roadmap.with_node(cell.configurations[name].q, name)
    path = tmp_path / "roadmap.h5"
    write_roadmap(path, roadmap.with_edge(0, 1, roadmap.configurations), cell.fingerprint, {})
    return path


def test_the_picture_is_written_and_told(stored: Path) -> None:
    output = stored.with_name("roadmap.html")
    answer = apc("inspect", stored, "--picture", output, "--json")
    assert answer.code == 0 and json.loads(answer.out)["plot"] == str(output)
    shown = document_of(output.read_bytes())
    assert [line["name"] for line in shown["lines"]] == ["home to bin_A"]
    assert {node["name"] for node in shown["nodes"]} == {"home", "bin_A"}
    again = apc("inspect", stored, "--picture", output)
    assert again.code == 3 and "exists already" in again.err


def test_other_pictures_and_other_files_are_refused(stored: Path) -> None:
    answer = apc("inspect", stored, "--picture", stored.with_suffix(".svg"))
    assert answer.code == 3 and "a picture is written as .png or .html" in answer.err
    scene = stored.with_name("scene.json")
    write_scene(empty_scene(load_cell("apc2016_delft")), scene)
    answer = apc("inspect", scene, "--picture", stored.with_suffix(".png"))
    assert answer.code == 3 and "this is: apc scene" in answer.err


def test_a_cell_is_drawn_with_its_own_places(stored: Path, cell_copy: CellCopy) -> None:
    cell = with_places(cell_copy, CRATES, BENCH).load()
    answer = apc("inspect", cell_copy.folder, "--picture", stored.with_name("cell.html"))
    assert answer.code == 0 and "crate_left: 300 x 240 x 140 mm, from above" in answer.out
    shown = document_of(stored.with_name("cell.html").read_bytes())
    assert {"crate_left", "home"} <= {node["name"] for node in shown["nodes"]}
    picture = cell_picture(cell)
    assert {node.name for node in picture.nodes} == {*cell.configurations, *cell.places}
    assert sum(solid.ink is Colour.PLACE for solid in picture.solids) == 11  # two crates of five, one top


def test_a_file_of_another_cell_than_the_one_named_is_refused(stored: Path, cell_copy: CellCopy) -> None:
    folder = cell_copy.folder
    assert apc("inspect", stored, "--cell", folder).code == 0
    cell_copy.yaml.replace("clearance: 0.003", "clearance: 0.004")
    other = apc("inspect", stored, "--cell", folder)
    assert other.code == 4 and other.out == ""
    assert "is of a cell with fingerprint" in other.err and "apc refresh" in other.err
