"""``apc make-order``: what it writes, prints and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.order_file import read_order
from support.command_line import apc, misused, refused


@pytest.mark.parametrize(("task", "year"), [("pick", 2016), ("stow", 2016), ("pick", 2015)])
def test_make_order_writes_what_it_says(task: str, year: int, tmp_path: Path) -> None:
    out = tmp_path / "order.json"
    answer = apc("make-order", "--task", task, "--year", year, "--seed", 7, "-o", out, "--json")
    assert answer.code == 0 and answer.err == ""
    order = read_order(out, load_cell("apc2016_delft"))
    assert order == make_order(OrderKind(task), year, 7)
    told = json.loads(answer.out)
    assert told["items_per_bin"] == {name: len(names) for name, names in order.bin_contents.items()}
    assert (told["in_tote"], told["targets"]) == (len(order.tote_contents), len(order.work_order))
    assert (told["task"], told["year"], told["seed"]) == (task, year, 7)


def test_make_order_says_in_one_line_what_was_drawn(tmp_path: Path) -> None:
    out = tmp_path / "order.json"
    assert apc("make-order", "-o", out).out == f"46 items in 12 bins, 12 targets, seed 0: {out}\n"
    stow = apc("make-order", "--task", "stow", "-o", out, "--overwrite")
    assert stow.out == f"34 items in 12 bins, 12 to stow, seed 0: {out}\n"


def test_make_order_gives_the_same_bytes_again(tmp_path: Path) -> None:
    first, second = tmp_path / "first.json", tmp_path / "second.json"
    for out in (first, second):
        assert apc("make-order", "--seed", 5, "-o", out).code == 0
    assert first.read_bytes() == second.read_bytes()


def test_make_order_refuses_a_stow_of_2015(tmp_path: Path) -> None:
    answer = apc("make-order", "--task", "stow", "--year", "2015", "-o", tmp_path / "order.json")
    refused(answer, 3, "no stow task in 2015", "stow 2016")
    assert list(tmp_path.iterdir()) == []


def test_make_order_does_not_replace_a_file_unasked(tmp_path: Path) -> None:
    (tmp_path / "order.json").write_text("mine")
    refused(apc("make-order", "-o", tmp_path / "order.json"), 3, "--overwrite")
    assert (tmp_path / "order.json").read_text() == "mine"


@pytest.mark.parametrize(("option", "value"), [("--year", "2017"), ("--task", "tidy"), ("--seed", "-1")])
def test_make_order_refuses_values_that_do_not_exist(option: str, value: str, tmp_path: Path) -> None:
    misused(apc("make-order", option, value, "-o", tmp_path / "order.json"), option)
