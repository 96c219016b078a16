"""The best alignment against all alignments there are, and angles against those that agree."""

from __future__ import annotations

from itertools import combinations, pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.perception.tracking.alignment import aligned
from pickcli.perception.tracking.mean_yaw import mean_yaw


@st.composite
def gains(draw: st.DrawFn) -> np.ndarray:
    n, m = draw(st.integers(0, 5)), draw(st.integers(0, 5))
    values = st.one_of(st.floats(-10.0, 10.0), st.just(-np.inf))
    return np.array([[draw(values) for _ in range(m)] for _ in range(n)]).reshape(n, m)


@given(gains())
@settings(max_examples=200, deadline=None)
def test_no_alignment_gains_more(gain: np.ndarray) -> None:
    pairs = aligned(gain)
    assert all(a[0] < b[0] and a[1] < b[1] for a, b in pairwise(pairs))
    assert all(gain[i, j] > 0.0 for i, j in pairs)
    n, m = gain.shape
    best = max(
        sum(gain[i, j] for i, j in zip(rows, columns, strict=True))
        for k in range(min(n, m) + 1)
        for rows in combinations(range(n), k)
        for columns in combinations(range(m), k)
    )
    assert abs(sum(gain[i, j] for i, j in pairs) - best) <= 1e-9


@given(st.floats(-np.pi, np.pi), st.integers(0, 10_000), st.integers(4, 20))
@settings(max_examples=100, deadline=None)
def test_angles_that_are_wrong_do_not_count(yaw: float, seed: int, n: int) -> None:
    rng, sigma = np.random.default_rng(seed), np.radians(2.0)
    angles = yaw + rng.uniform(-sigma, sigma, n)
    wrong = rng.permutation(n)[: (n - 1) // 3]
    angles[wrong] += rng.uniform(0.5, 2 * np.pi - 0.5, len(wrong))
    mean, n_used = mean_yaw((angles + np.pi) % (2 * np.pi) - np.pi, sigma)
    right = np.delete(np.arange(n), wrong)
    off = (mean - angles[right].mean() + np.pi) % (2 * np.pi) - np.pi
    assert n_used == len(right) and abs(off) < 1e-9
