"""A mutant's trial: the tests run in a process that sees the mutant where the module would be."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
import resource
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import hypothesis
import pytest

ROOT = Path(__file__).parents[2]


class _InPlace(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds one module before anyone else does, with another source."""

    def __init__(self, path: Path, source: str) -> None:
        self.path, self.source = path, source
        self.name = ".".join(path.relative_to(ROOT).with_suffix("").parts)

    def find_spec(self, fullname: str, *_: object) -> importlib.machinery.ModuleSpec | None:
        """The module's spec, of this module only."""
        if fullname != self.name:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, origin=str(self.path))

    def exec_module(self, module: object) -> None:
        """Run the other source."""
        module.__file__ = str(self.path)  # type: ignore[attr-defined]
        exec(compile(self.source, str(self.path), "exec"), module.__dict__)


class _Only:
    """A plugin of pytest: these tests, in this order, and no others."""

    def __init__(self, names: Sequence[str]) -> None:
        self._ranks = {name: rank for rank, name in enumerate(names)}

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Choose and sort among what was collected."""
        chosen = [item for item in items if item.nodeid in self._ranks]
        items[:] = sorted(chosen, key=lambda item: self._ranks[item.nodeid])


def survives(path: Path, source: str, names: Sequence[str], seconds: float) -> bool:
    """Whether tests pass with this source in place of the module's.

    names: of the tests, in the order in which they run
    seconds: CPU time after which a mutant counts as found: it runs on for ever
    """
    if not names:
        return True

    def run() -> int:
        sys.meta_path.insert(0, _InPlace(path, source))
        return tested(sorted({name.split("::")[0] for name in names}), [_Only(names)])

    passes, _ = in_child(run, seconds)
    return passes


def in_child(run: Callable[[], int], seconds: float) -> tuple[bool, float]:
    """Whether a silent process ends with 0, and the CPU time that it took, s.

    run: gives what the process ends with
    seconds: CPU time after which it is ended
    """
    pid = os.fork()
    if pid == 0:
        _be_child(run, seconds)
    _, status, usage = os.wait4(pid, 0)
    return status == 0, usage.ru_utime + usage.ru_stime


def _be_child(run: Callable[[], int], seconds: float) -> None:
    code = 1
    try:
        silence()
        limit = max(1, round(seconds))
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1))
        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        code = run()
    finally:
        os._exit(code)


def silence() -> None:
    """Nothing that this process prints is seen from here on."""
    null = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):
        os.dup2(null, stream)


def tested(tests: Sequence[str], plugins: Sequence[object]) -> int:
    """Run tests in this process until one fails; returns pytest's exit code."""
    # Every mutant meets the same examples: none kept from others, none found too slow on a busy machine.
    phases = (hypothesis.Phase.explicit, hypothesis.Phase.generate)
    hypothesis.settings.register_profile("mutants", database=None, deadline=None, phases=phases)
    options = ["-x", "-q", "-p", "no:cacheprovider", "-m", "not slow", f"--rootdir={ROOT}"]
    options += ["--hypothesis-profile=mutants", "--hypothesis-seed=0"]
    return int(pytest.main([*options, *(str(ROOT / test) for test in tests)], plugins))
