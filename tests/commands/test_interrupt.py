"""Ctrl-C at any moment: exit code 130, no traceback, nothing half-written."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command_line import Made, apc

import pickcli.precompute.artifacts
import pickcli.trial.arena  # noqa: F401  imported here, so that no import is what gets interrupted


@contextmanager
def interrupted_after(seconds: float) -> Iterator[None]:
    """Raise what Ctrl-C raises, once, in the middle of whatever runs then."""
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize("seconds", [0.3, 1.1])
@pytest.mark.parametrize("name", ["build-roadmap", "build-trajectories", "run-trial"])
def test_nothing_is_left(name: str, seconds: float, made: Made, tmp_path: Path) -> None:
    out = tmp_path / "out"
    argv: dict[str, tuple[object, ...]] = {
        "build-roadmap": ("build-roadmap", "--iterations", 100_000, "-o", out),
        "build-trajectories": ("build-trajectories", "--tries", 100, "-o", out),
        "run-trial": ("run-trial", made.order, "-o", out),
    }
    with interrupted_after(seconds):
        answer = apc(*argv[name])
    assert answer.code == 130
    assert answer.out == "" and answer.err.strip() == "interrupted"
    assert list(tmp_path.iterdir()) == []
