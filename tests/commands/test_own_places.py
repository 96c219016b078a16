"""Scenes and picks in a cell of crates and shelves, by the commands."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
import yaml

from pickcli.cell.data_path import data_path
from support.command_line import apc, misused, refused

BAR, BALL = "dove_beauty_bar", "rawlings_baseball"
CRATES = ("make-scene", "--cell", "ur5e_crates")


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("crates") / "scene.json"
    made = apc(*CRATES, "--in", f"crate_left={BAR}", "--in", f"shelf_1_2={BALL}", "-o", path)
    assert made.code == 0 and "2 items at rest in 2 places" in made.out
    return path


def test_the_scene_is_sound_and_says_what_lies_where(scene: Path) -> None:
    told = json.loads(apc("inspect", scene, "--json").out)
    assert told["items"] == {"crate_left": [BAR], "shelf_1_2": [BALL]}
    assert "without mistakes; 2 items" in apc("check", scene).out


def test_more_may_lie_where_an_order_puts_things(tmp_path: Path) -> None:
    order = tmp_path / "order.json"
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    bins["bin_C"] = [BAR]
    order.write_text(json.dumps({"bin_contents": bins, "work_order": [{"bin": "bin_C", "item": BAR}]}))
    more = ("--in", f"bin_C={BALL}", "--in", f"tote={BAR}")
    made = apc("make-scene", order, *more, "-o", tmp_path / "scene.json", "--json")
    assert json.loads(made.out)["bins"] == bins | {"bin_C": [BAR, BALL], "tote": [f"{BAR}#2"]}


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--in", f"crate_lft={BAR}"), "did you mean 'crate_left'"),
        (("--in", "crate_left=dove_beauty_bra"), "did you mean 'dove_beauty_bar'"),
        (("--in", "shelf_1_2=" + ",".join(["kleenex_paper_towels"] * 8)), "put fewer items"),
    ],
)  # fmt: skip
def test_mistakes_in_what_lies_where_are_told(words: tuple[str, ...], told: str, tmp_path: Path) -> None:
    refused(apc(*CRATES, *words, "-o", tmp_path / "scene.json"), 3, told)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("value", ["crate_left", f"crate_left={BAR},"])
def test_a_value_that_tells_no_place_and_items_is_wrong_usage(value: str, tmp_path: Path) -> None:
    misused(apc(*CRATES, "--in", value, "-o", tmp_path / "scene.json"), "expected PLACE=ITEM")
    assert not list(tmp_path.iterdir())


def test_nothing_to_place_is_a_question(tmp_path: Path) -> None:
    misused(apc(*CRATES, "-o", tmp_path / "scene.json"), "--in PLACE=ITEM")


@pytest.mark.slow
@pytest.mark.parametrize("into", ["crate_right", "shelf_2_2"])
def test_a_pick_goes_from_place_to_place(scene: Path, into: str, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    planned = apc("plan-pick", "--scene", scene, "--pick", f"crate_left:{BAR}", "--into", into, "-o", plan)
    assert planned.code == 0 and f"into {into}" in planned.out and "certified" in planned.out
    played = apc("execute", plan, "--scene", scene, "--json")
    told = json.loads(played.out)
    assert played.code == 0 and (told["item_is_in"], told["collisions"]) == (into, 0)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--pick", f"crate_lft:{BAR}", "--into", "crate_right"), "did you mean 'crate_left'"),
        (("--pick", f"crate_right:{BAR}", "--into", "crate_left"), "but in crate_left; name that place"),
        (("--pick", f"crate_left:{BAR}"), "name one of its places with --into: crate_right, shelf_1_1"),
        (
            ("--pick", f"crate_left:{BAR}", "--into", "crate_left"),
            "name another place: crate_right, shelf_1_1",
        ),
        (("--pick", f"crate_left:{BAR}", "--into", "tote"), "unknown place 'tote'"),
    ],
)
def test_mistakes_in_what_is_picked_are_told(
    scene: Path, words: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    refused(apc("plan-pick", "--scene", scene, *words, "-o", tmp_path / "plan.json"), 3, told)


@pytest.mark.parametrize(
    "words", [(), ("--bin", "crate_left"), ("--pick", BAR), ("--pick", f"crate_left:{BAR}", "--item", BAR)]
)
def test_what_is_picked_is_said_once(scene: Path, words: tuple[str, ...], tmp_path: Path) -> None:
    misused(apc("plan-pick", "--scene", scene, *words, "-o", tmp_path / "plan.json"), "--bin")


def test_a_place_is_named_by_one_of_two_options(scene: Path, tmp_path: Path) -> None:
    words = ("--pick", f"crate_left:{BAR}", "--to", "crate_right", "--into", "shelf_1_1")
    told = "--into and --to mean the same; keep one"
    misused(apc("plan-pick", "--scene", scene, *words, "-o", tmp_path / "plan.json"), told)


def test_a_cell_of_one_place_is_told_to_need_another(cell_of_crates: Path, tmp_path: Path) -> None:
    """Both without --to, and where that names the place that the item is in."""
    made, plan = tmp_path / "scene.json", tmp_path / "plan.json"
    content = yaml.safe_load((cell_of_crates / "cell.yaml").read_text())
    content["places"] = {name: content["places"][name] for name in list(content["places"])[:1]}
    (place,) = content["places"]
    content["configurations"] = [c for c in content["configurations"] if c["kind"] != "bin"]
    (cell_of_crates / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    assert apc("make-scene", "--cell", cell_of_crates, "--in", f"{place}={BAR}", "-o", made).code == 0
    asked = ("plan-pick", "--scene", made, "--cell", cell_of_crates, "--pick", f"{place}:{BAR}", "-o", plan)
    refused(apc(*asked), 3, "has no tote; it has only one place: add another one under places")
    refused(apc(*asked, "--into", place), 3, f"in {place} already; it has only one place: add another one")


@pytest.fixture
def cell_of_crates(tmp_path: Path) -> Path:
    shutil.copytree(data_path() / "cells/ur5e_crates", tmp_path / "crates")
    return tmp_path / "crates"


def test_orders_of_a_cell_go_by_their_names(cell_of_crates: Path, tmp_path: Path) -> None:
    out, words = tmp_path / "scene.json", ("--cell", cell_of_crates)
    assert apc("make-scene", "moves_24", *words, "-o", out).code == 0
    refused(apc("make-scene", "moves_42", *words, "-o", out, "--overwrite"), 3, "did you mean 'moves_24'?")
    refused(apc("run-trial", "nothing_such", *words), 3, "moves_24")


@pytest.mark.parametrize("command", ["make-scene", "run-trial", "run-trials"])
def test_an_order_of_another_cell_says_of_which(command: str, tmp_path: Path) -> None:
    told = "unknown order 'moves_24'; it is one of the cell ur5e_crates; add --cell ur5e_crates"
    refused(apc(command, "moves_24", "-o", tmp_path / "out"), 3, told)


def test_an_official_order_says_what_would_do_in_a_cell_of_crates(tmp_path: Path) -> None:
    played = apc("run-trial", "jsk_pick_sample", "--cell", "ur5e_crates", "-o", tmp_path / "t")
    told = "cell ur5e_crates has no pod and no tote; name an order of moves, e.g. moves_24, or place items"
    refused(played, 3, told)


@pytest.mark.parametrize("wrong", ["move", "Moves"])
def test_a_misspelt_key_of_moves_is_one_of_the_order(wrong: str, tmp_path: Path) -> None:
    order = tmp_path / "order.json"
    move = {"from": "crate_left", "item": BAR, "to": "crate_right"}
    order.write_text(json.dumps({"contents": {"crate_left": [BAR]}, wrong: [move]}))
    told = f"{wrong}: unknown key; did you mean 'moves'?"
    refused(apc("run-trial", order, "--cell", "ur5e_crates", "-o", tmp_path / "t"), 3, told)
