"""Which mutants are tried, and which tests first."""

from __future__ import annotations

from bench.mutants.__main__ import PACKAGES, own_first, sample

LOADS, VERIFIER = (next(p for p in PACKAGES if p.name == name) for name in ("load rules", "verifier"))


def test_fewer_mutants_are_the_first_of_more_so_that_what_time_leaves_is_a_sample() -> None:
    few, many = sample(LOADS, 20, 7), sample(LOADS, 60, 7)
    assert few == many[:20]
    assert len({module for module, _ in few}) == len(LOADS.modules)
    assert [m.line for _, m in many] != sorted(m.line for _, m in many)
    assert few != sample(LOADS, 20, 8)


def test_the_tests_that_name_a_module_come_first() -> None:
    ordered = own_first(VERIFIER.tests, "verification/tipping_check")
    assert ordered[0] == "tests/verification/test_tipping_check.py"
    assert sorted(ordered) == sorted(VERIFIER.tests)
    assert own_first(VERIFIER.tests, "verification/nothing") == list(VERIFIER.tests)
