"""Progress goes to stderr, and where no terminal is, as lines that a log can hold."""

from __future__ import annotations

import pytest

from pickcli.commands import progress as module
from pickcli.commands.progress import progress, progress_line


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
