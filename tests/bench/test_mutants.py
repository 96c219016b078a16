"""Which mutants are tried, and which tests may notice them."""

from __future__ import annotations

import ast
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from bench.mutants.__main__ import PACKAGES, sample
from bench.mutants.mutate import mutants
from bench.mutants.reach import Reach
from bench.mutants.trial import in_child
from bench.mutants.warm import _run_with, codes

LOADS = next(p for p in PACKAGES if p.name == "load rules")


def test_fewer_mutants_are_the_first_of_more_so_that_what_time_leaves_is_a_sample() -> None:
    few, many = sample(LOADS, 20, 7), sample(LOADS, 60, 7)
    assert few == many[:20]
    assert len({module for module, _ in few}) == len(LOADS.modules)
    assert [m.line for _, m in many] != sorted(m.line for _, m in many)
    assert few != sample(LOADS, 20, 8)


MODULE = """
def f(x):
    if x > 1 and not x == 3:
        return max(x, 2) + 1
    raise ValueError(x)
"""


def test_every_mutant_is_another_module_and_has_no_fault_but_its_own() -> None:
    tried = mutants(MODULE)
    sources = [mutant.source() for mutant in tried]
    assert len(tried) == len({ast.unparse(ast.parse(MODULE)), *sources}) - 1 == 12
    assert [mutant.source() for mutant in reversed(tried)] == sources[::-1]


def test_no_mutant_is_made_of_a_size_that_numpy_finds() -> None:
    assert [str(m) for m in mutants("x = y.reshape(-1, 3)")] == ["1: 3 -> 4"]


def test_of_the_tests_that_run_a_line_the_quick_ones_come_first_and_all_run_what_an_import_runs() -> None:
    lines = {1: frozenset({""}), 4: frozenset({"slow", "quick"}), 6: frozenset({"slow"})}
    reach = Reach({"slow": 2.0, "other": 0.1, "quick": 0.5}, {"m": lines}, cpu_s=2.6)
    assert reach.of("m", 4, 4) == (["quick", "slow"], [])
    assert reach.of("m", 5, 5) == reach.of("m", 4, 4), "a continued line"
    assert reach.of("m", 5, 6) == reach.of("m", 6, 9) == (["slow"], [])
    assert reach.of("m", 2, 3) == ([], ["quick", "slow", "other"])


def test_where_no_test_runs_a_line_none_fails_because_of_it() -> None:
    session = cast(pytest.Session, SimpleNamespace(testsfailed=0))
    assert in_child(lambda: _run_with([], session, []), 5.0)[0]


PROPERTY = """class A:
    @property
    def x(self):
        return self._x

    @x.setter
    def x(self, to):
        self._x = to + 1


def f(x):
    def inner():

        return x + 1
    return inner()
"""


def test_code_finds_the_function_that_it_is_of(tmp_path: Path) -> None:
    """Methods, both halves of a property and functions in functions, though the other source is shorter."""
    path, tried = tmp_path / "module.py", mutants(PROPERTY)
    path.write_text(PROPERTY)
    found = []
    for mutant in tried:
        names: dict[str, Any] = {}
        exec(compile(PROPERTY, str(path), "exec"), names)
        a, f = names["A"](), names["f"]
        for function, code in codes(mutant.source(), path, [f, names["A"].x.fget, names["A"].x.fset]):
            function.__code__ = code
        a.x = 1
        found.append((a.x, f(1)))
    assert [mutant.line for mutant in tried] == [8, 8, 14, 14]
    assert sorted(found) == [(0, 2), (2, 0), (2, 3), (3, 2)]
