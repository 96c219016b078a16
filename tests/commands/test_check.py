"""``apc check`` of what people write; of stored files the tests of these have more."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.data_path import data_path
from support.cell_copies import CellCopy
from support.command_line import Made, apc, misused, refused

ITEMS = data_path() / "items" / "apc2016.yaml"


def test_a_right_cell_is_a_table_of_what_it_reaches(tmp_path: Path) -> None:
    picture = tmp_path / "reach.png"
    answer = apc("check", "apc2016_delft", "--poses", 4, "--strict", "--picture", picture)
    assert answer.code == 0, answer.err
    head, *rows, end = answer.out.splitlines()
    assert head.split("  ")[0] == "place" and len(rows) == 13 and rows[0].split()[0] == "bin_A"
    assert end == "apc2016_delft: without mistakes; all 39 configurations are free"
    assert "warning" not in answer.err
    assert picture.read_bytes().startswith(b"\x89PNG")
    refused(apc("check", "apc2016_delft", "--picture", picture), 3, picture, "--overwrite")


def test_json_has_shares_and_warnings(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("lead: 2.0", "lead: 20")
    plain = apc("check", cell_copy.folder, "--poses", 2, "--json")
    told = json.loads(plain.out)
    assert plain.code == 0 and plain.err.count("apc: warning: ") == 1
    assert told["configurations"] == 39 and len(told["reach"]) == 13
    assert {"arm", "place", "tool_poses", "share", "configuration", "share_in_line"} == set(told["reach"][0])
    (warning,) = told["warnings"]
    assert warning in plain.err
    strict = apc("check", cell_copy.folder, "--poses", 2, "--strict", "--json")
    assert strict.code == 3 and json.loads(strict.out)["warnings"] == [warning]
    assert strict.err.endswith(
        f"apc: error: {cell_copy.folder}: 1 warning, and --strict treats warnings as mistakes\n"
    )


def test_a_warning_is_told_by_what_reads_the_file(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("lead: 2.0", "lead: 20")
    answer = apc("inspect", cell_copy.folder)
    assert answer.code == 0 and answer.err.count("\n") == 1
    assert "apc: warning: " in answer.err and "cell.yaml:109:22: devices.pump.lead: 20 s" in answer.err
    verbose = apc("inspect", cell_copy.folder, "-v").err
    assert verbose.count("devices.pump.lead: 20 s") == 1 and " INFO " in verbose


def test_scenes_orders_and_items_are_checked(made: Made) -> None:
    for path, end in (
        (made.scene, "2 items, none of which floats, overlaps or stands in anything"),
        (made.order, "an order of 1 target"),
        (ITEMS, "39 items"),
    ):
        answer = apc("check", path, "--strict")
        assert (answer.code, answer.out) == (0, f"{path}: without mistakes; {end}\n"), answer.err


def test_what_is_accepted_is_silent(made: Made, tmp_path: Path) -> None:
    def change(data: dict[str, object]) -> None:
        data["noise"] = {"position": 0.03, "angle": 0.0175}

    loose = made.changed("scene", tmp_path, change)
    answer = apc("check", loose, "--strict")
    assert (
        answer.code == 3 and "(if it is meant, add large_noise:position to accepted_warnings)" in answer.err
    )

    def accept(data: dict[str, object]) -> None:
        change(data)
        data["accepted_warnings"] = ["large_noise:position"]

    assert apc("check", made.changed("scene", tmp_path, accept), "--strict").code == 0


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (("scene", "--repair"), "--repair is for roadmaps and trajectory databases"),
        (("scene", "--picture", "reach.png"), "--picture applies only to a cell"),
        (("items", "--cell", "apc2016_delft"), "--cell does not apply to a file of items"),
    ],
)
def test_options_that_mean_nothing_are_refused(argv: tuple[str, ...], told: str, made: Made) -> None:
    path = {"scene": made.scene, "items": ITEMS}[argv[0]]
    misused(apc("check", path, *argv[1:]), told)


def test_a_text_of_no_kind_is_told_what_is_wanted(tmp_path: Path) -> None:
    path = tmp_path / "o.json"
    path.write_text("[]")
    texts = "a cell, a scene, an order, a file of items, a file of perceived items, a stream of items, "
    texts += "an order of a pallet, a commission, a driving area"
    wanted = f"{texts}, or a roadmap or trajectory database is expected here"
    refused(apc("check", path), 3, f"{path}: is a text file of another kind, but {wanted}")


def test_neither_a_file_nor_a_cell_is_told_with_what_is_meant(made: Made) -> None:
    refused(apc("check", "ur5e_crate"), 3, "no cell or task of that name; did you mean 'ur5e_crates'?")
    refused(apc("check", made.plan), 3, made.plan, "is a plan, but", "apc verify checks plans")
