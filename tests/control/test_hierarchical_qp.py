"""Levels of strict priority: answers by hand, conditions of optimality, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.hierarchies import off_optimum, random_levels
from pickcli.control.hierarchical_qp import BoundedRows, Hierarchy, solve
from pickcli.geometry import Array


def rows(*values: list[float]) -> Array:
    return np.array(values, dtype=np.float64)


def unit_box(n: int) -> BoundedRows:
    return BoundedRows(np.eye(n), np.full(n, -1.0), np.full(n, 1.0))


def violations(found: Hierarchy) -> list[float]:
    return [float(np.linalg.norm(each)) for each in found.violations]


def test_a_level_is_met_as_far_as_those_before_it_allow() -> None:
    """x + y = 3 in the unit square leaves 1 at its corner; y = 0 comes after, and changes nothing."""
    total = BoundedRows.equal(rows([1.0, 1.0]), np.array([3.0]))
    levels = [unit_box(2), total, BoundedRows.equal(rows([0.0, 1.0]), np.zeros(1))]
    found = solve(levels, np.zeros(2))
    np.testing.assert_allclose(found.x, [1.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(violations(found), [0.0, 1.0, 1.0], atol=1e-12)


def test_the_order_of_the_levels_decides() -> None:
    left, right = (BoundedRows.equal(rows([1.0, 0.0]), np.array([at])) for at in (-1.0, 2.0))
    for first, second, x in ((left, right, -1.0), (right, left, 2.0)):
        found = solve([first, second], np.array([0.3, 0.7]))
        assert found.x == pytest.approx([x, 0.7])
        assert violations(found) == pytest.approx([0.0, 3.0])


def test_rows_of_one_level_in_conflict_share_the_violation() -> None:
    level = BoundedRows.at_most(rows([1.0], [-1.0]), np.array([-1.0, -2.0]))  # x <= -1 and x >= 2
    found = solve([level], np.zeros(1))
    assert found.x == pytest.approx([0.5])
    assert found.violations[0] == pytest.approx([1.5, 1.5])


def test_what_is_free_stays_where_it_began() -> None:
    start = np.array([0.2, -0.4, 0.9])
    found = solve([unit_box(3), BoundedRows.at_most(rows([1.0, 0.0, 0.0]), np.array([0.5]))], start)
    np.testing.assert_array_equal(found.x, start)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 2, 3, 8, 16]))
def test_every_level_is_at_its_optimum(seed: int, n: int) -> None:
    levels = random_levels(np.random.default_rng(seed), n, seed % 2 == 1)
    found = solve(levels, np.zeros(n))
    assert off_optimum(levels, found.x) < 1e-6
    for level, violation in zip(levels, found.violations, strict=True):
        at = level.rows @ found.x
        beyond = np.maximum(0.0, at - level.upper) - np.maximum(0.0, level.lower - at)
        np.testing.assert_allclose(violation, beyond, atol=1e-7)


@given(st.integers(0, 2**32 - 1))
def test_rows_that_depend_on_each_other_are_solved_too(seed: int) -> None:
    """Repeated rows, rows of nothing, and levels that repeat one before them."""
    rng = np.random.default_rng(seed)
    levels = random_levels(rng, 6, seed % 2 == 1)
    doubled = levels[1]
    levels[1] = BoundedRows(
        np.concatenate([doubled.rows, doubled.rows[:5], np.zeros((2, 6))]),
        np.concatenate([doubled.lower, doubled.lower[:5], [-1.0, 0.5]]),
        np.concatenate([doubled.upper, doubled.upper[:5], [1.0, 0.7]]),
    )
    levels.insert(3, doubled)
    levels.insert(4, BoundedRows(np.zeros((0, 6)), np.zeros(0), np.zeros(0)))
    found = solve(levels, np.zeros(6))
    assert off_optimum(levels, found.x) < 1e-6
    assert found.violations[1][-1] == pytest.approx(-0.5)  # 0 x is below 0.5, whatever x is


@given(st.integers(0, 2**32 - 1), st.integers(2, 7), st.floats(0.0, 2.0))
def test_rows_that_an_earlier_level_settles_take_no_freedom(seed: int, n: int, off: float) -> None:
    """A level that repeats the rows of the first one, with other values too, leaves all else to the third."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(int(rng.integers(1, n)), n))
    b = rng.normal(size=len(A))
    again = BoundedRows.equal(-2.0 * A, -2.0 * (b + off))
    found = solve([BoundedRows.equal(A, b), again, BoundedRows.equal(np.eye(n), np.zeros(n))], np.ones(n))
    np.testing.assert_allclose(found.x, np.linalg.pinv(A) @ b, atol=1e-6 * (1.0 + np.abs(found.x).max()))
    np.testing.assert_allclose(found.violations[0], 0.0, atol=1e-7)


@given(st.integers(0, 2**32 - 1))
def test_later_levels_cost_earlier_ones_nothing(seed: int) -> None:
    levels = random_levels(np.random.default_rng(seed), 8, seed % 2 == 1)
    whole = violations(solve(levels, np.zeros(8)))
    for n in range(1, len(levels)):
        assert violations(solve(levels[:n], np.zeros(8))) == pytest.approx(whole[:n], abs=1e-7)


def test_the_same_problem_gives_the_same_bits() -> None:
    levels = random_levels(np.random.default_rng(5), 8, True)
    first, second = (solve(levels, np.zeros(8)).x for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize(
    ("level", "text"),
    [
        (BoundedRows(np.eye(2), np.ones(2), np.zeros(2)), "lower: row 0 is above its upper bound"),
        (BoundedRows(np.eye(3), np.zeros(3), np.ones(3)), "rows of level 1 have 3 columns, start has 2"),
        (BoundedRows(np.eye(2), np.zeros(3), np.ones(2)), "lower: shape (3) instead of (2)"),
        (
            BoundedRows.equal(np.ones((1, 2)), np.array([np.inf])),
            "row 0 has an infinite bound",
        ),
        (BoundedRows(np.full((1, 2), np.nan), np.zeros(1), np.ones(1)), "rows: not finite"),
        (BoundedRows(np.eye(2), np.full(2, np.nan), np.ones(2)), "lower: not finite"),
    ],
)
def test_mistakes_are_told_by_name(level: BoundedRows, text: str) -> None:
    with pytest.raises(ValueError) as told:
        solve([level], np.zeros(2))
    assert text in str(told.value)
