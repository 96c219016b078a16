"""Ctrl-C at any moment: exit code 130, no traceback, nothing half-written."""

from __future__ import annotations

import gc
import os
import re
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import pickcli.precompute.artifact_cache
import pickcli.trial.simulated_cell
from pickcli.cell import cell_file
from pickcli.cell.cell import Cell
from pickcli.commands.command import Terminated
from pickcli.commands.main import _terminate
from pickcli.jobs.journal import Journal
from support.command_line import Made, apc
from support.small_cell import alone, small_cell


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """Raise what Ctrl-C raises, once, in the middle of whatever runs then.

    Not in the middle of collecting garbage: what is raised in a callback of that is lost.
    """
    gc.disable()
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
        gc.enable()


def terminate() -> None:
    os.kill(os.getpid(), signal.SIGTERM)


@pytest.mark.parametrize("seconds", [0.3, 1.1])
def test_a_trial_leaves_nothing(seconds: float, made: Made, tmp_path: Path) -> None:
    with interrupted_after(seconds):
        answer = apc("run-trial", made.order, "-o", tmp_path / "out")
    assert answer.code == 130
    *kept, last = answer.err.splitlines()
    assert answer.out == "" and last == "interrupted" and kept
    told = (
        "run the same command again to continue",
        "the same command starts over",
        "plays the same one from its",
    )
    assert all(any(text in line for text in told) for line in kept)
    assert list(tmp_path.iterdir()) == []


def interrupt() -> None:
    raise KeyboardInterrupt


ENDS = {"interrupted": (interrupt, 130), "terminated": (terminate, 143)}


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("jobs", [1, 2])
@pytest.mark.parametrize("name", ["build-roadmap", "build-trajectories"])
def test_a_build_leaves_its_journal_and_says_how_to_go_on(
    name: str, jobs: int, end: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    cell = small_cell("home", "bin_A", "bin_E", "tote", "tote_10h")
    monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(cell))
    append, n_left = Journal.append, 2

    def interrupted(*arguments: Any) -> None:
        nonlocal n_left
        n_left -= 1
        append(*arguments)
        if not n_left:
            ENDS[end][0]()

    monkeypatch.setattr(Journal, "append", interrupted)
    answer = apc(name, "--jobs", jobs, "-o", tmp_path / "out.h5")
    assert answer.code == ENDS[end][1] and answer.out == ""
    (journal,) = tmp_path.iterdir()
    told = rf"\d+ of \d+ tasks are kept in {re.escape(str(journal))}; run the same command again to continue"
    assert re.search(told, answer.err)
    assert answer.err.splitlines()[-1] == end


@pytest.mark.parametrize("command", ["make-scene", "execute"])
def test_what_keeps_nothing_says_that_it_begins_anew(
    command: str, made: Made, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    argv = {"make-scene": (made.order, "-o", out), "execute": (made.plan, "--scene", made.scene)}[command]
    monkeypatch.setattr("pickcli.commands.logs._log.debug", lambda *_: interrupt())  # a stage begins
    answer = apc(command, *argv)
    assert answer.code == 130 and answer.err == "the same command starts over\ninterrupted\n"
    assert not out.exists()


def test_a_build_that_has_nothing_yet_leaves_nothing(tmp_path: Path) -> None:
    with interrupted_after(0.05):
        answer = apc("build-roadmap", "-o", tmp_path / "out.h5")
    assert answer.code == 130 and answer.err == "the same command starts over\ninterrupted\n"
    assert list(tmp_path.iterdir()) == []


def test_the_first_build_of_a_trial_says_that_it_goes_on(
    made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def build(cell: Cell, *_: Any) -> None:
        roadmap = pickcli.precompute.artifact_cache.default_paths(cell).roadmap
        roadmap.parent.mkdir(parents=True)
        roadmap.with_name(f"{roadmap.name}.0123456789ab.journal").touch()
        raise KeyboardInterrupt

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    monkeypatch.setattr(pickcli.precompute.artifact_cache, "ensure_artifacts", build)
    answer = apc("run-trial", made.order, "-o", tmp_path / "out")
    assert answer.code == 130 and "run the same command again to continue" in answer.err


def test_whoever_terminates_twice_does_not_wait() -> None:
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        with pytest.raises(Terminated):
            _terminate()
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL
    finally:
        signal.signal(signal.SIGTERM, before)
