"""What is shown fits the terminal: tables, and what `inspect` says of a stored file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.commands.output.report import DIGEST, key_lines
from pickcli.commands.output.table import known_width, stdout_width, table_lines
from pickcli.precompute.artifact_files import make_roadmap
from pickcli.precompute.roadmap_settings import RoadmapSettings
from support.command_line import apc
from support.small_cell import small_cell

HEAD = ("", "planning ms", "whole ms", "best x bound")
ROWS = (["RRTConnect", "1.0", "20.5", "1.000"], ["AORRTC", "100.0", "2.5", "1.123"])


def test_a_table_is_a_line_per_row_where_there_is_room() -> None:
    lines = table_lines(HEAD, ROWS, 60)
    assert len(lines) == 3 and max(map(len, lines)) <= 60
    assert lines[1].split() == ROWS[0] and lines[2].split() == ROWS[1]


@pytest.mark.parametrize("width", [24, 30, 40])
def test_a_table_loses_nothing_where_there_is_little_room(width: int) -> None:
    lines = table_lines(HEAD, ROWS, width)
    assert max(map(len, lines)) <= width and not any("…" in line for line in lines)
    told = "".join(text for row in (HEAD, *ROWS) for text in row)
    assert sorted("".join("".join(lines).split())) == sorted("".join(told.split()))


@pytest.mark.parametrize("width", [50, 80, 200])
def test_values_go_on_below_their_key(width: int) -> None:
    summary = {
        "key": "some words " * 30,
        "list": ["a phrase that is long " * 4, "b"],
        "figures": {"a": 1.5, "b": None},
    }
    lines = key_lines(summary, width)
    assert max(map(len, lines)) <= width
    assert " ".join(" ".join(lines).split()).count("some words") == 30
    assert any(line.endswith("a: 1.5") for line in lines) and any(line.endswith("b: none") for line in lines)


@pytest.fixture(scope="module")
def stored(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A roadmap of a small cell."""
    folder = tmp_path_factory.mktemp("stored")
    make_roadmap(small_cell("home", "bin_A", "tote"), folder / "roadmap.h5", RoadmapSettings())
    return folder / "roadmap.h5"


def test_inspect_shows_a_stored_file_on_one_screen(stored: Path) -> None:
    brief, whole = apc("inspect", stored), apc("inspect", stored, "--all")
    told = json.loads(apc("inspect", stored, "--json").out)
    assert brief.code == whole.code == 0
    assert len(brief.out.splitlines()) <= 24 < len(whole.out.splitlines())
    solids = told["made"]["parts"]["solids"]
    assert solids and all(name in whole.out and name not in brief.out for name in solids)
    shown = "".join(brief.out.split())
    assert f"nodes:{told['nodes']}" in shown and told["cell_fingerprint"] in shown


FINGERPRINT = "0123456789abcdef" * 4
LONG = {"cell_fingerprint": FINGERPRINT, "pairs": {"a link - another link": "why they may touch " * 3}}


@pytest.mark.parametrize("width", [27, 60, 80])
def test_what_is_longer_than_a_terminal_is_wide_is_folded_and_whole_but_for_hashes(width: int) -> None:
    """A hash is on one line, to be copied, and on a terminal of 80 columns that fits."""
    lines = key_lines(LONG, width)
    assert [line.strip() for line in lines if FINGERPRINT in line] == [FINGERPRINT]
    assert max(map(len, lines if width >= 80 else without_hashes(lines))) <= width
    assert "".join("".join(lines).split()).count("whytheymaytouch") == 3


def without_hashes(lines: list[str]) -> list[str]:
    left = [line for line in lines if DIGEST.search(line) is None]
    assert len(left) == len(lines) - 1
    return left


def test_without_a_terminal_words_stay_whole() -> None:
    lines = key_lines({"path": "/a" * 100})
    assert lines[-1].endswith("/a" * 100)


@pytest.mark.parametrize("width", [60, 80])
def test_inspect_of_a_cell_fits_a_narrow_terminal(width: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    lines = apc("inspect", "apc2016_delft").out.splitlines()
    assert len(lines) > 50 and max(map(len, lines if width >= 80 else without_hashes(lines))) <= width


def test_a_pipe_has_the_width_that_columns_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("COLUMNS", raising=False)
    assert (stdout_width(), known_width()) == (100, None)
    assert max(map(len, apc("inspect", "apc2016_delft").out.splitlines())) <= 100
    monkeypatch.setenv("COLUMNS", "60")
    assert stdout_width() == known_width() == 60
    rows = [["a" * 70, "b" * 70]]
    assert table_lines(("x", "y"), rows)[1].split() == rows[0]  # a row is a line, however long
