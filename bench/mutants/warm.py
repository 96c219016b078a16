"""A process in which everything is imported and every test collected: a fork of it tries a mutant at once.

A fork puts the mutant's code into the functions that there are. That shows what a fresh import of the mutant
would, as long as nothing ran the line before the tests began.
"""

from __future__ import annotations

import gc
import multiprocessing
import signal
import types
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

import pytest

from bench.mutants.trial import in_child, silence, tested

_Name = tuple[str, int]  # of a function in its module, and which of those of that name it is


class WarmTests:
    """Tests that are collected once, and run in a fork for every mutant."""

    def __init__(self, tests: Sequence[str]) -> None:
        """Collect them.

        tests: files of tests
        """
        context = multiprocessing.get_context("fork")
        self._to, there = context.Pipe()
        self._process = context.Process(target=_serve, args=(tests, there), daemon=False)
        self._process.start()

    def survives(self, path: Path, source: str, most: Mapping[str, float]) -> bool:
        """Whether tests pass with this source in place of the module's functions.

        most: of each test by its name, in the order in which they run: CPU time (s) after which the mutant
            counts as found, as it runs on for ever
        """
        self._to.send((path, source, dict(most)))
        return bool(self._to.recv())

    def close(self) -> None:
        """End the process."""
        self._to.send(None)
        self._process.join()


def _serve(tests: Sequence[str], asked: Connection) -> None:
    silence()
    tested(tests, [_Loop(asked)])


class _Loop:
    """A plugin of pytest that runs, instead of all tests once, some of them for every mutant."""

    def __init__(self, asked: Connection) -> None:
        self._asked = asked

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Try mutants until there are no more."""
        items = {item.nodeid: item for item in session.items}
        functions = [each for each in gc.get_objects() if isinstance(each, types.FunctionType)]
        gc.freeze()
        while (mutant := self._asked.recv()) is not None:
            path, source, most = mutant
            mutated = codes(source, path, [f for f in functions if f.__code__.co_filename == str(path)])
            chosen = [(items[name], seconds) for name, seconds in most.items()]
            passes, _ = in_child(partial(_run_with, mutated, session, chosen), sum(most.values()))
            self._asked.send(passes)
        return True


def _run_with(
    mutated: Sequence[tuple[types.FunctionType, types.CodeType]],
    session: pytest.Session,
    items: Sequence[tuple[pytest.Item, float]],
) -> int:
    """Run tests, each for so many s of CPU time, with other code in functions until one fails.

    Returns how many did; a test that takes longer ends the process.
    """
    for function, code in mutated:
        function.__code__ = code
    # Of no items, which is what a line has that only an import runs, there is no last one either.
    for (item, seconds), following in zip(items, [*(item for item, _ in items[1:]), None], strict=False):
        signal.setitimer(signal.ITIMER_PROF, seconds)
        item.config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if session.testsfailed:
            break
    return session.testsfailed


def codes(
    source: str, path: Path, functions: Sequence[types.FunctionType]
) -> list[tuple[types.FunctionType, types.CodeType]]:
    """What another source of a module has in place of the code of its functions.

    path: of the module as it was imported
    functions: of that
    """
    was = _codes(compile(path.read_text(), str(path), "exec"))
    names = {(code.co_qualname, code.co_firstlineno): name for name, code in was}
    new = dict(_codes(compile(source, str(path), "exec")))
    places = [(f.__code__.co_qualname, f.__code__.co_firstlineno) for f in functions]
    return [(f, new[names[place]]) for f, place in zip(functions, places, strict=True)]


def _codes(module: types.CodeType) -> Iterator[tuple[_Name, types.CodeType]]:
    """The code of every function of a module, nested ones too, by name, in their order."""
    met: dict[str, int] = {}
    for code in _nested(module):
        rank = met[code.co_qualname] = met.get(code.co_qualname, -1) + 1
        yield (code.co_qualname, rank), code


def _nested(code: types.CodeType) -> Iterator[types.CodeType]:
    for const in code.co_consts:
        if isinstance(const, types.CodeType):
            yield const
            yield from _nested(const)
