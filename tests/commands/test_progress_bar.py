"""Progress goes to stderr, and where no terminal is, as lines that a log can hold."""

from __future__ import annotations

import io
import sys
import time

import pytest
from rich.console import Console

from pickcli.commands.output import progress_bar as module
from pickcli.commands.output.progress_bar import duration, progress, progress_line
from pickcli.jobs.job_run import BuildProgress
from pickcli.progress import Progress


def test_lines_tell_what_is_done_and_how_long_it_takes() -> None:
    assert progress_line("picking", Progress(3, 12, "bin_A"), 30.0) == "picking: 3/12, about 90 s left: bin_A"
    assert progress_line("picking", Progress(0, 12), 5.0) == "picking: 0/12"


def test_a_log_gets_a_line_per_period(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter([0.0, 4.0, 11.0, 12.0, 30.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    with progress("building") as report:
        for done in (1, 2, 3, 4):
            report(Progress(done, 4))
    out, err = capsys.readouterr()
    assert out == ""
    assert err.splitlines() == ["building: 2/4, about 11 s left", "building: 4/4, about 0 s left"]


def test_a_log_hears_of_long_work_that_reports_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "LINE_PERIOD", 0.05)
    with progress("playing") as report:
        time.sleep(0.3)
        report(Progress(1, 2))
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "playing: 0 s" and lines[-1].startswith("playing: 1/2")
    assert len([line for line in lines if line.startswith("playing: 1/2")]) > 1


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
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    clock = iter([0.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock, 700.0))
    told = BuildProgress(133, 332, "bin_B, drop_12_down, empty", 33, 2, effort_done=1.0, effort_total=2.0)
    with progress("building the trajectories") as report:
        report(told)
    shown = screen.getvalue()
    assert "133/332, 12 min left" in shown and "2 failed" in shown
    assert ("drop_12_down, empty" in shown) == (width == 160)
