"""The sign-flip test of a mean and its interval: scipy as oracle, both agree, chance is kept to 5 %."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from pickcli.geometry import Array
from pickcli.monte_carlo.sign_flips import SignFlipTest

VALUES = st.lists(st.integers(-8, 8).map(float), min_size=1, max_size=10).map(np.array)


def mean(values: Array, axis: int) -> Array:
    return np.asarray(values.mean(axis=axis))


@given(VALUES)
@settings(max_examples=60, deadline=None)
def test_of_few_values_it_is_exact(values: Array) -> None:
    test = SignFlipTest.of(values)
    if len(values) > 1:  # scipy takes no single one
        known = stats.permutation_test((values,), mean, permutation_type="samples", n_resamples=np.inf)
        assert test.p_value == pytest.approx(known.pvalue, abs=1e-12)
    assert test.mean == pytest.approx(values.mean())


@given(VALUES)
@settings(max_examples=60, deadline=None)
def test_the_interval_holds_what_the_test_does_not_refuse(values: Array) -> None:
    test = SignFlipTest.of(values)
    assert (test.low == -np.inf) == (test.high == np.inf) == (len(values) < 6)
    assert test.low <= test.mean <= test.high
    assert test.is_significant == (not test.low <= 0.0 <= test.high)
    for end, outwards in ((test.low, -1.0), (test.high, 1.0)):
        if np.isfinite(end) and test.high - test.low > 1e-3:  # values that are all alike have no spread
            inside = test.mean + (end - test.mean) * (1.0 - 1e-6)
            assert SignFlipTest.of(values - inside).p_value > 0.05
            assert SignFlipTest.of(values - (end + outwards * 1e-6)).p_value <= 0.05


def test_of_many_values_ways_are_drawn_and_the_figures_are_the_same_again() -> None:
    values = np.random.default_rng(3).normal(0.4, 1.0, 40)
    test, again = SignFlipTest.of(values), SignFlipTest.of(values.copy())
    assert test == again
    low, high = stats.t.interval(0.95, 39, values.mean(), stats.sem(values))
    assert (test.low, test.high) == pytest.approx((low, high), abs=0.02)
    known = stats.permutation_test((values,), mean, permutation_type="samples", n_resamples=20_000, rng=7)
    assert test.p_value == pytest.approx(known.pvalue, abs=0.003)


def test_chance_is_taken_for_a_difference_once_in_20_times_at_most() -> None:
    rng = np.random.default_rng(71)
    claimed = sum(
        SignFlipTest.of(rng.choice(np.arange(-30.0, 40.0, 10.0), 10)).is_significant for _ in range(600)
    )
    assert claimed <= stats.binom.ppf(0.999, 600, 0.05)
    assert claimed > 0
