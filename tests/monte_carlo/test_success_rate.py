"""Success rates and their intervals, against scipy."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from pickcli.monte_carlo.success_rate import SuccessRate


@given(st.integers(1, 400).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))))
def test_the_interval_is_wilsons(counts: tuple[int, int]) -> None:
    k, n = counts
    expected = stats.binomtest(k, n).proportion_ci(0.95, method="wilson")
    rate = SuccessRate(k, n)
    assert rate.interval == pytest.approx((expected.low, expected.high), abs=1e-12)
    assert rate.interval[0] <= rate.share == k / n <= rate.interval[1]


def test_without_tries_everything_is_possible() -> None:
    assert (SuccessRate(0, 0).share, SuccessRate(0, 0).interval) == (0.0, (0.0, 1.0))
