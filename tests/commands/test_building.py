"""How a build tells its progress, and what it says of journals."""

from __future__ import annotations

import json
import time
from dataclasses import replace
from pathlib import Path

import click
import pytest

from pickcli.commands.operations.building import build_report, building
from pickcli.commands.output.progress_bar import progress_line
from pickcli.errors import InputError
from pickcli.jobs.dask_executor import DaskExecutor
from pickcli.jobs.executors import ProcessExecutor, SerialExecutor, available_cores, runner
from pickcli.jobs.job_run import BuildProgress
from pickcli.jobs.journal import Journal


def test_the_time_left_counts_only_what_was_done_now() -> None:
    begun = BuildProgress(50, 100, n_kept=40, effort_done=2.0, effort_total=12.0)
    assert begun.seconds_left(20.0) == pytest.approx(100.0)
    assert replace(begun, done=40, effort_done=0.0).seconds_left(20.0) is None


def test_a_line_tells_failures_coverage_and_what_was_kept() -> None:
    progress = BuildProgress(50, 100, "bin_A, tote, empty", 40, 5, 1.0, 6.0)
    assert progress_line("x", progress, 20.0) == (
        "x: 50/100, about 100 s left: 5 failed, coverage 45 %, 40 kept from before: bin_A, tote, empty"
    )
    assert progress_line("x", BuildProgress(0, 100), 0.0) == "x: 0/100: 0 failed, coverage 0 %"


def test_a_line_of_trials_tells_failures_alone_and_only_if_there_are_any() -> None:
    of_trials = BuildProgress(1, 2, "two, 5", tells_coverage=False)
    assert of_trials.detail == "two, 5"
    assert replace(of_trials, n_failed=1, n_kept=1).detail == "1 failed, 1 kept from before: two, 5"
    assert replace(of_trials, what="").detail == ""


def test_json_lines_on_stderr_one_per_task(capsys: pytest.CaptureFixture[str]) -> None:
    with build_report("building", as_json=True) as report:
        report(BuildProgress(2, 4, "", 2, 1, effort_total=3.0))
        report(BuildProgress(3, 4, "a, b", 2, 1, effort_done=1.0, effort_total=3.0))
    out, err = capsys.readouterr()
    first, second = (json.loads(text) for text in err.splitlines())
    assert out == "" and first["seconds_left"] is None and first["task"] == ""
    assert second.pop("seconds_left") >= 0.0
    assert second == {
        "event": "progress", "done": 3, "total": 4, "kept": 2, "failed": 1, "coverage": 0.5, "task": "a, b"
    }  # fmt: skip


def test_a_log_gets_a_line_per_period(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = iter([0.0, 4.0, 11.0, 12.0, 30.0])
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    with build_report("building") as report:
        for done in (1, 2, 3, 4):
            report(BuildProgress(done, 4, effort_done=done, effort_total=4.0))
    assert [text.split(",")[0] for text in capsys.readouterr().err.splitlines()] == [
        "building: 2/4",
        "building: 4/4",
    ]


def test_a_journal_of_another_build_is_named_and_left(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = Journal(tmp_path / "out.h5", "e" * 64)
    other.append(("a",), b"")
    with building("building", tmp_path / "out.h5", 1, False) as run_options:
        assert run_options.runner == SerialExecutor()
    assert f"note: {other.path} is left from an interrupted build" in capsys.readouterr().err
    assert other.path.exists()


def test_one_job_per_core_by_default(tmp_path: Path) -> None:
    with building("building", tmp_path / "out.h5", None, False) as run_options:
        assert run_options.runner == runner(available_cores())
    with building("building", tmp_path / "out.h5", 3, False) as run_options:
        assert run_options.runner == ProcessExecutor(3)


def test_a_scheduler_takes_the_place_of_jobs(tmp_path: Path) -> None:
    with building("building", tmp_path / "out.h5", None, False, "tcp://host:8786") as run_options:
        assert run_options.runner == DaskExecutor("tcp://host:8786")
    with pytest.raises(click.UsageError, match="--jobs is for this machine"):
        building("building", tmp_path / "out.h5", 2, False, "tcp://host:8786").__enter__()


def test_where_the_output_cannot_be_written_the_journal_is_named(
    tmp_path: Path,
) -> None:
    journal = tmp_path / "roadmap.h5.0.journal"
    journal.write_bytes(b"")
    with (
        pytest.raises(InputError) as stopped,
        building("building", tmp_path / "roadmap.h5", 1, as_json=False) as run_options,
    ):
        assert run_options.report is not None
        run_options.report(BuildProgress(4, 4, journal=journal))
        raise InputError("roadmap.h5: cannot be written: No space left on device")
    (note,) = stopped.value.__notes__  # which main() tells
    assert f"4 of 4 tasks are kept in {journal}; once that is mended, run the same command again" in note
