"""Items of a user's own, beside those of the package: in every command that reads items."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.schemas.items_file import load_items
from support.command_line import apc, refused

TIN = """format: apc items
version: 1
year: 2026
items:
  {name}:
    box: [0.08, 0.08, {height}]
    mass: {mass}
    bonus: 0
    seal: 0.9
    seals: {{"-z": 0.0}}
    seal_source: tried with the 30 mm cup
    seal_inset: 0.003
    source: calipers and kitchen scale
"""


def tin(path: Path, name: str = "tea_tin", height: float = 0.12, mass: float = 0.31) -> Path:
    path.write_text(TIN.format(name=name, height=height, mass=mass))
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("own")
    tin(folder / "tin.yaml")
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"} | {
        "bin_C": ["tea_tin", "dove_beauty_bar"]
    }
    order = {"bin_contents": bins, "work_order": [{"bin": "bin_C", "item": "tea_tin"}]}
    (folder / "order.json").write_text(json.dumps(order))
    words = ("make-scene", folder / "order.json", "--items", folder / "tin.yaml", "-o", folder / "scene.json")
    assert apc(*words, "--seed", 1).code == 0
    return folder


def test_an_own_item_is_placed_planned_and_verified(folder: Path) -> None:
    scene, items = ("--scene", folder / "scene.json"), ("--items", folder / "tin.yaml")
    pick = ("plan-pick", *scene, "--bin", "bin_C", "--item", "tea_tin", "-o", folder / "plan.json")
    planned = apc(*pick, *items)
    assert planned.code == 0, planned.err
    assert apc("verify", folder / "plan.json", *scene, *items).code == 0
    assert json.loads(apc("inspect", folder / "scene.json", *items, "--json").out)["n_items"] == 2
    assert apc("check", folder / "scene.json", *items).out.endswith("stands in anything\n")
    assert apc("check", folder / "order.json", *items).out.endswith("an order of 1 target\n")
    refused(apc(*pick, "--overwrite"), 3, "scene.json:", "tea_tin")


def test_a_plan_depends_on_what_the_item_is(folder: Path, tmp_path: Path) -> None:
    plan = folder / "of_this.json"
    scene = ("--scene", folder / "scene.json")
    words = ("plan-move", *scene, "--from", "home", "--to", "bin_C", "-o", plan)
    assert apc(*words, "--items", folder / "tin.yaml").code == 0
    heavier = tin(tmp_path / "tin.yaml", mass=0.32)
    refused(apc("verify", plan, *scene, "--items", heavier), 4, "made for the scene", "tool, pump or items")


def test_files_of_a_folder_are_read_and_others_left_alone(tmp_path: Path) -> None:
    tin(tmp_path / "a.yaml")
    tin(tmp_path / "b.yml", name="tea_box")
    (tmp_path / "notes.txt").write_text("none of ours")
    own = load_items(tmp_path).keys() - load_items().keys()
    assert own == {("tea_tin", 2026), ("tea_box", 2026)}
    cell = load_cell("apc2016_delft", items=tmp_path)
    assert cell.item("tea_tin").year == 2026 and cell.item("dove_beauty_bar").year == 2016
    assert cell.fingerprint == load_cell("apc2016_delft").fingerprint


def test_names_that_clash_and_folders_without_items_are_refused(folder: Path, tmp_path: Path) -> None:
    words = ("make-scene", folder / "order.json", "-o", tmp_path / "scene.json", "--items")
    refused(apc(*words, tmp_path), 3, f"{tmp_path}: no file of items")
    tin(tmp_path / "a.yaml")
    tin(tmp_path / "b.yaml")
    told = f"b.yaml: items.tea_tin: {tmp_path / 'a.yaml'} has a tea_tin of 2026 already; choose another name"
    refused(apc(*words, tmp_path), 3, told)
    packaged = tmp_path / "c.yaml"
    packaged.write_text(TIN.format(name="dove_beauty_bar", height=0.1, mass=0.1).replace("2026", "2016"))
    refused(apc(*words, packaged), 3, "apc2016.yaml has a dove_beauty_bar of 2016 already")
    refused(apc(*words, tmp_path / "none.yaml"), 3, "none.yaml: no such file")
    assert not (tmp_path / "scene.json").exists()


@pytest.mark.parametrize(
    ("figures", "told"),
    [
        ({"mass": 310.0}, "items.tea_tin.mass: expected a mass in kg: less than or equal to 20, got 310.0"),
        ({"height": 120.0}, "items.tea_tin.box[2]: "),
        ({"mass": 0.0}, "items.tea_tin.mass: "),
    ],
)
def test_sizes_and_masses_are_checked(
    folder: Path, tmp_path: Path, figures: dict[str, float], told: str
) -> None:
    bad = tin(tmp_path / "tin.yaml", **figures)  # type: ignore[arg-type]
    refused(apc("make-scene", folder / "order.json", "-o", tmp_path / "s.json", "--items", bad), 3, told)
