"""Scenes and picks in a cell of crates and shelves, by the commands."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

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
        (("--in", "crate_left"), "expected PLACE=ITEM"),
        (("--in", f"crate_left={BAR},"), "expected PLACE=ITEM"),
        (("--in", "shelf_1_2=" + ",".join(["kleenex_paper_towels"] * 8)), "put fewer items"),
    ],
)  # fmt: skip
def test_mistakes_in_what_lies_where_are_told(words: tuple[str, ...], told: str, tmp_path: Path) -> None:
    refused(apc(*CRATES, *words, "-o", tmp_path / "scene.json"), 3, told)
    assert not list(tmp_path.iterdir())


def test_nothing_to_place_is_a_question(tmp_path: Path) -> None:
    misused(apc(*CRATES, "-o", tmp_path / "scene.json"), "--in PLACE=ITEM")


@pytest.mark.slow
@pytest.mark.parametrize("into", ["crate_right", "shelf_2_2"])
def test_a_pick_goes_from_place_to_place(scene: Path, into: str, tmp_path: Path) -> None:
    plan = tmp_path / "plan.json"
    planned = apc("plan-pick", "--scene", scene, "--pick", f"crate_left:{BAR}", "--to", into, "-o", plan)
    assert planned.code == 0 and f"into {into}" in planned.out and "certified" in planned.out
    played = apc("execute", plan, "--scene", scene, "--json")
    told = json.loads(played.out)
    assert played.code == 0 and (told["item_is_in"], told["collisions"]) == (into, 0)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--pick", f"crate_lft:{BAR}", "--to", "crate_right"), "did you mean 'crate_left'"),
        (("--pick", f"crate_right:{BAR}", "--to", "crate_left"), "it is in crate_left"),
        (("--pick", f"crate_left:{BAR}"), "name one of its places with --to: crate_left, crate_right"),
        (("--pick", f"crate_left:{BAR}", "--to", "crate_left"), "name another place"),
        (("--pick", f"crate_left:{BAR}", "--to", "tote"), "unknown place 'tote'"),
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
    misused(apc("plan-pick", "--scene", scene, *words, "-o", tmp_path / "plan.json"), "--pick")
