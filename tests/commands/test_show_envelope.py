"""``apc show-envelope``: envelopes by themselves and in a scene, and what is told of mistakes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from support.command_line import apc, misused, refused


@pytest.fixture(scope="module")
def soap_in_bin(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scene = tmp_path_factory.mktemp("soap") / "scene.json"
    assert apc("make-scene", "--in", "bin_C=dove_beauty_bar", "--seed", 5, "-o", scene).code == 0
    return scene


def test_an_item_by_itself_is_shown_with_all_its_envelopes(tmp_path: Path) -> None:
    page = tmp_path / "soap.html"
    told = json.loads(
        apc("show-envelope", "dove_beauty_bar", "--cell", "panda_table", "-o", page, "--json").out
    )
    assert told["bytes"] == page.stat().st_size
    assert {each["about"] for each in told["envelopes"]} == {"plane"}
    assert all("kept" not in each for each in told["envelopes"])


def test_in_a_scene_what_is_left_is_smaller_and_reached_and_what_is_in_the_way_is_named(
    soap_in_bin: Path, tmp_path: Path
) -> None:
    page = tmp_path / "soap.html"
    argv = ("show-envelope", "dove_beauty_bar", "--scene", soap_in_bin, "-o", page)
    told = {each["name"]: each for each in json.loads(apc(*argv, "--json").out)["envelopes"]}
    top, below = told["+z"], told["-z"]
    assert top["kept"] > 0.1 and top["tool_state"] == "down" and top["reached"] > 0.5
    assert (np.array(top["kept_low"]) >= np.array(top["low"]) - 1e-12).all()
    assert (np.array(top["kept_high"]) <= np.array(top["high"]) + 1e-12).all()
    assert below["kept"] == 0.0 and below["kept_low"] is None and "pod" in below["against"]
    text = apc(*argv, "--overwrite").out
    assert "-z: nothing is proven free; in the way: " in text and "+z, tool down: " in text


def test_the_same_page_comes_again(soap_in_bin: Path, tmp_path: Path) -> None:
    pages = [tmp_path / f"{k}.html" for k in range(2)]
    for page in pages:
        assert apc("show-envelope", "dove_beauty_bar", "--scene", soap_in_bin, "-o", page).code == 0
    assert pages[0].read_bytes() == pages[1].read_bytes()


def test_mistakes_are_told_and_nothing_is_written(soap_in_bin: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    output = ("-o", page)
    misused(
        apc("show-envelope", "dove_beauty_bar", *output), "name a scene with --scene, or a cell with --cell"
    )
    refused(apc("show-envelope", "soap", "--cell", "panda_table", *output), 3, "unknown item 'soap'")
    refused(apc("show-envelope", "soap", "--scene", soap_in_bin, *output), 3, "unknown item 'soap'")
    in_scene = ("--scene", soap_in_bin, "--year", 2016)
    misused(apc("show-envelope", "dove_beauty_bar", *in_scene, *output), "leave it out with --scene")
    png = ("-o", tmp_path / "p.png")
    refused(apc("show-envelope", "dove_beauty_bar", "--cell", "panda_table", *png), 3, "written as .html")
    heavy = ("fitness_gear_3lb_dumbbell", "--cell", "apc2016_delft")
    refused(apc("show-envelope", *heavy, *output), 5, "nothing to grasp: needs pinching")
    assert not page.exists()
