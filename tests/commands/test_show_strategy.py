"""``apc show-strategy`` and ``--strategy``: what they print, write and refuse."""

from __future__ import annotations

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from support.command_line import apc, refused


def test_without_a_name_the_strategies_are_listed() -> None:
    answer = apc("show-strategy")
    assert answer.code == 0
    assert [line.split()[0] for line in answer.out.splitlines()[1:]] == ["delft", "kth", "points", "apple"]
    assert set(json.loads(apc("show-strategy", "--json").out)["strategies"]) == {
        "delft", "kth", "points", "apple"
    }  # fmt: skip


def test_a_strategy_is_printed_as_a_tree_or_counted() -> None:
    answer = apc("show-strategy", "delft")
    assert answer.code == 0 and "! choose_target (by fewest_attempts, fewest_items, order)" in answer.out
    tree = json.loads(apc("show-strategy", "delft", "--json").out)["tree"]
    assert tree["node"] == "sequence"
    assert tree["children"][1]["arguments"] == {"by": ["fewest_attempts", "fewest_items", "order"]}


@pytest.mark.parametrize("suffix", ["svg", "xml"])
def test_a_strategy_is_written_and_nothing_replaced_unasked(suffix: str, tmp_path: Path) -> None:
    path = tmp_path / f"kth.{suffix}"
    assert apc("show-strategy", "kth", "-o", path).code == 0
    first = path.read_bytes()
    ElementTree.fromstring(first.decode())
    refused(apc("show-strategy", "points", "-o", path), 3, str(path), "--overwrite")
    assert path.read_bytes() == first
    assert apc("show-strategy", "kth", "-o", path, "--overwrite").code == 0 and path.read_bytes() == first


def test_impossible_requests_are_refused(tmp_path: Path) -> None:
    refused(apc("show-strategy", "dellft"), 3, "unknown strategy 'dellft'", "did you mean 'delft'?")
    refused(apc("show-strategy", "kth", "-o", tmp_path / "kth.png"), 3, "kth.png", ".svg", ".xml")
    answer = apc("show-strategy", "-o", tmp_path / "all.svg")
    assert answer.code == 2 and "-o writes one strategy" in answer.err
    own = tmp_path / "own.yaml"
    own.write_text("format: apc strategy\nversion: 1\nname: own\ndescription: mine\ntree: pik\n")
    refused(apc("show-strategy", own), 3, f"{own}:5:1: tree: unknown node 'pik'; did you mean 'pick'")
    refused(apc("show-strategy", own, "-o", own, "--overwrite"), 3, "own.yaml", ".svg")


def test_a_bad_strategy_is_refused_before_a_trial_begins(tmp_path: Path) -> None:
    out = tmp_path / "trial"
    refused(apc("run-trial", "delft_pick_2", "--strategy", "best", "-o", out), 3, "unknown strategy 'best'")
    many = ("run-trials", "delft_pick_2", "--seeds", "0:2", "-o", out, "--strategy", "best")
    refused(apc(*many), 3, "unknown strategy 'best'")
    assert not out.exists()
