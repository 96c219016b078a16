"""``apc make-stream``, and ``apc inspect`` of what it wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.commands.make_stream import MOST_ITEMS
from pickcli.scene.stream_schema import MAX_RIDING
from support.command_line import apc, misused, refused


def test_a_stream_is_written_and_inspected(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    made = apc("make-stream", "--items", "5", "--gap", "0.3,0.4", "--seed", "2", "-o", path, "--json")
    assert made.code == 0 and json.loads(made.out)["speed"] == 0.33  # nominal
    told = json.loads(apc("inspect", path, "--json").out)
    assert (told["n_items"], told["conveyor"], told["speed_m_s"]) == (5, "belt", 0.33)
    first = told["within_window"][json.loads(made.out)["items"][0]]
    enters, leaves = (float(part) for part in first.removesuffix(" s").split(" to "))
    assert leaves - enters == pytest.approx((2.85 - 1.20) / 0.33, abs=0.02)


@pytest.mark.parametrize("gap", ["0.5", "0.5,0.2", "-0.1,0.2", "nan,nan", "a,b"])
def test_gaps_that_are_none_are_wrong_usage(gap: str, tmp_path: Path) -> None:
    misused(apc("make-stream", "--gap", gap, "-o", tmp_path / "s.json"), "expected LO,HI in m")


@pytest.mark.parametrize("speed", ["-0.1", "nan", "inf"])
def test_speeds_that_are_none_are_wrong_usage(speed: str, tmp_path: Path) -> None:
    misused(apc("make-stream", "--speed", speed, "-o", tmp_path / "s.json"), "--speed")


def test_a_speed_beyond_the_belts_is_refused(tmp_path: Path) -> None:
    refused(apc("make-stream", "--speed", "0.6", "-o", tmp_path / "s.json"), 3, "runs at 0.5 m/s at most")


def test_a_stream_is_no_scene(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    assert apc("make-stream", "--items", "2", "-o", path).code == 0
    planned = apc("plan-pick", "--scene", path, "--bin", "belt", "--item", "x", "-o", tmp_path / "p.json")
    refused(planned, 3, "is a stream of items, but a scene is expected here")


def test_items_one_by_one_are_for_a_belt_that_stands(tmp_path: Path) -> None:
    runs = apc("make-stream", "--one-by-one", "--speed", "0.1", "-o", tmp_path / "s.json")
    refused(runs, 3, "--one-by-one: items are set down so on a belt that stands; take --speed 0")


@pytest.mark.parametrize(
    ("options", "fault"),
    [
        (("--one-by-one", "--within", "2.0,1.0"), "take 0 <= LO <= HI up to that"),
        (("--one-by-one", "--within", "1.0,9.0"), "the belt is 3.1 m long"),
    ],
)
def test_stretches_that_are_none_are_refused(options: tuple[str, ...], fault: str, tmp_path: Path) -> None:
    refused(apc("make-stream", "--speed", "0", *options, "-o", tmp_path / "s.json"), 3, fault)


def test_a_stretch_is_of_items_one_by_one(tmp_path: Path) -> None:
    answer = apc("make-stream", "--speed", "0", "--within", "0.5,1.0", "-o", tmp_path / "s.json")
    misused(answer, "--within: states where items are set down one by one; add --one-by-one")


@pytest.mark.parametrize("text", ["1.0", "a,b", "nan,1", "0.1,inf"])
def test_a_stretch_is_two_numbers(text: str, tmp_path: Path) -> None:
    misused(apc("make-stream", "--within", text, "-o", tmp_path / "s.json"), "expected LO,HI in m")


def test_fingers_are_brought_what_they_can_pinch(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    options = ("--cell", "pr2_belt", "--speed", "0", "--one-by-one", "--within", "0.6,1.5", "--items", "40")
    assert apc("make-stream", *options, "-o", path).code == 0
    stream = json.loads(path.read_text())
    assert stream["one_by_one"] is True
    assert all(0.6 <= item["position"][0] <= 1.5 for item in stream["items"])
    names = {item["name"] for item in stream["items"]}
    assert "dove_beauty_bar" in names and not names & {"kleenex_tissue_box", "folgers_classic_roast_coffee"}
    told = json.loads(apc("inspect", path, "--json").out)  # no arm need be named
    assert told["n_items"] == 40


@pytest.mark.parametrize("cell", ["conveyor_sia20", "pr2_belt"])
def test_it_tells_the_fingerprint_that_a_stream_of_its_cell_states(cell: str, tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    assert apc("make-stream", "--cell", cell, "--items", "2", "--seed", "2", "-o", path).code == 0
    stated = json.loads(path.read_text())["cell"]["fingerprint"]
    assert json.loads(apc("inspect", path, "--json").out)["cell_fingerprint"] == stated
    told = json.loads(apc("inspect", cell, "--json").out)
    assert told.get("scene_fingerprint", told.get("fingerprint")) == stated


@pytest.mark.slow
def test_the_longest_stream_that_is_made_is_read(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    assert apc("make-stream", "--items", MOST_ITEMS, "--seed", "2", "-o", path).code == 0
    assert json.loads(apc("inspect", path, "--json").out)["n_items"] == MOST_ITEMS == MAX_RIDING
    misused(
        apc("make-stream", "--items", MOST_ITEMS + 1, "--seed", "2", "-o", tmp_path / "more.json"), "--items"
    )
