"""The table of a trial can be read on any terminal."""

from __future__ import annotations

import io
import re
from dataclasses import replace

import pytest
from rich.console import Console

from pickcli.commands.output.trial_table import WIDE, print_rows
from pickcli.trial.trial_summary import Row

REASON = "145 times collision, e.g. [side] grasp on face +z: lance against pod row_DEF_divider_right"
ROWS = (
    Row("bin_A", "elmers_washable_no_run_school_glue", "tote", "in tote", 10, 82.0, 6.2, ""),
    Row("bin_E", "creativity_chenille_stems", "tote", "no plan", 0, None, 0.0, REASON),
)


@pytest.mark.parametrize("width", [60, 80, 100, WIDE, 160])
def test_nothing_is_cut_off(width: int) -> None:
    console = Console(file=io.StringIO(), width=width, force_terminal=True, no_color=True)
    print_rows(console, ROWS)
    assert isinstance(console.file, io.StringIO)
    lines = re.sub("\x1b\\[\\d*m", "", console.file.getvalue()).splitlines()
    assert max(map(len, lines)) <= width
    words = " ".join(lines).split()
    assert {word for word in REASON.split() if word not in words} == set()
    assert not any("…" in line for line in lines)


@pytest.mark.parametrize("width", [80, 160])
def test_a_row_stays_on_one_line_where_nothing_went_wrong(width: int) -> None:
    console = Console(file=io.StringIO(), width=width)
    print_rows(console, ROWS)
    assert isinstance(console.file, io.StringIO)
    line = next(line for line in console.file.getvalue().splitlines() if line.startswith("bin_A"))
    assert line.split() == ["bin_A", "elmers_washable_no_run_school_glue", "in", "tote", "10", "82", "6.2"]


def test_a_reason_is_one_line_where_nobody_looks() -> None:
    console = Console(file=io.StringIO(), width=80)
    print_rows(console, ROWS)
    assert isinstance(console.file, io.StringIO)
    assert f"bin_E creativity_chenille_stems: {REASON}" in console.file.getvalue().splitlines()


def test_moves_say_where_to() -> None:
    console = Console(file=io.StringIO(), width=WIDE)
    print_rows(console, [replace(row, into="crate") for row in ROWS])
    assert isinstance(console.file, io.StringIO)
    lines = console.file.getvalue().splitlines()
    assert any(line.split()[:4] == ["from", "item", "to", "outcome"] for line in lines)
    assert sum(" crate " in line for line in lines) == len(ROWS)
