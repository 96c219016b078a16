"""Progress goes to stderr, and where no terminal is, as lines that a log can hold."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from pickcli.commands import progress as module
from pickcli.commands.progress import duration, progress, progress_line, terminal_bar


def test_lines_tell_what_is_done_and_how_long_it_takes() -> None:
    assert progress_line("picking", 3, 12, "bin_A", 30.0) == "picking: 3/12, about 90 s left: bin_A"
    assert progress_line("picking", 0, 12, "", 5.0) == "picking: 0/12"


def test_a_log_gets_a_line_per_period(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter([0.0, 4.0, 11.0, 12.0, 30.0])
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    with progress("building") as report:
        for done in (1, 2, 3, 4):
            report(done, 4, "")
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == ["building: 2/4, about 11 s left", "building: 4/4, about 0 s left"]


def test_times_to_wait_are_told_as_precisely_as_they_interest() -> None:
    assert [duration(s) for s in (0.4, 95.2, 119.9, 120.0, 700.0, 7300.0)] == [
        "0 s", "95 s", "120 s", "2 min", "12 min", "2.0 h"
    ]  # fmt: skip


@pytest.mark.parametrize("width", [80, 110, 160])
def test_a_terminal_gets_one_line_that_cuts_the_least_first(
    width: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    screen = io.StringIO()
    console = Console(file=screen, width=width, force_terminal=True)
    monkeypatch.setattr(module, "stderr_console", lambda: console)
    with terminal_bar("building the trajectories") as show:
        show(133, 332, 700.0, "2 failed, coverage 39 %, 33 kept from before: bin_B, drop_12_down, empty")
    shown = screen.getvalue()
    assert "133/332, 12 min left" in shown and "2 failed" in shown
    assert ("drop_12_down, empty" in shown) == (width == 160)
