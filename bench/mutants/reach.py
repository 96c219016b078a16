"""Which tests run a line: measured once for a package, to try only those that may notice a fault there."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import coverage
import pytest

from bench.mutants.trial import ROOT, in_child, tested

_IMPORT = ""  # the context of what runs before any test


@dataclass(frozen=True)
class Reach:
    """What the tests of a package reach while there is no fault.

    seconds: wall time of every test by its name, in the order of the tests
    names: of the tests that ran a line, by module and line
    cpu_s: of all tests
    """

    seconds: dict[str, float]
    names: dict[str, dict[int, frozenset[str]]]
    cpu_s: float

    def of(self, module: str, first: int, last: int) -> tuple[list[str], list[str]]:
        """Names of the tests that may notice a fault in some lines, the quick ones first.

        Where none of them has code of its own they belong to the one before.

        Returns:
            Those that ran one; and where what runs before the tests ran one too, which may matter to any of
            them, all tests, those that run the module first.
        """
        lines = self.names[module]
        known = lines.keys() & range(first, last + 1) or [max((k for k in lines if k < first), default=0)]
        ran = frozenset[str]().union(*(lines.get(line, ()) for line in known))
        tests = sorted(self.seconds, key=self.seconds.__getitem__)
        runs = frozenset[str]().union(*lines.values()) if _IMPORT in ran else frozenset[str]()
        everyone = sorted(tests, key=lambda name: name not in runs) if runs else []
        return [name for name in tests if name in ran], everyone


def measured(modules: Sequence[str], tests: Sequence[str]) -> Reach | None:
    """Run all tests of a package once; None if one of them fails.

    modules: paths below pickcli, without suffix
    tests: files of tests
    """
    with tempfile.TemporaryDirectory() as folder:
        to = Path(folder) / "reach.json"
        passes, cpu_s = in_child(lambda: _measure(modules, tests, to), 1200.0)
        if not passes:
            return None
        seconds, names = json.loads(to.read_text())
    by_line = {m: {int(k): frozenset(some) for k, some in lines.items()} for m, lines in names.items()}
    return Reach(seconds, by_line, cpu_s)


class _Watch:
    """A plugin of pytest that notes which test runs, and how long it takes."""

    def __init__(self, cover: coverage.Coverage) -> None:
        self._cover = cover
        self.seconds: dict[str, float] = {}

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Iterator[None]:
        """Everything from here on is of this test."""
        self._cover.switch_context(item.nodeid)
        return (yield)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Add up set-up, call and tear-down."""
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration


def _measure(modules: Sequence[str], tests: Sequence[str], to: Path) -> int:
    files = {module: str(ROOT / "pickcli" / f"{module}.py") for module in modules}
    cover = coverage.Coverage(data_file=None, include=list(files.values()), config_file=False)
    watch = _Watch(cover)
    cover.start()
    code = tested(tests, [watch])
    cover.stop()
    data = cover.get_data()
    names = {module: data.contexts_by_lineno(file) for module, file in files.items()}
    to.write_text(json.dumps([watch.seconds, names]))
    return code
