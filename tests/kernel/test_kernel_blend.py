"""The kernel's blended polyline against numpy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.kernel import BlendedPolyline
from pickcli.timing.corner_blending import BlendedPath, blend
from pickcli.timing.jerk_smoothing import TimeLaw
from support import blend_reference as reference


class Bounds:
    """Limits of n joints."""

    def __init__(self, rng: np.random.Generator, n: int) -> None:
        self.velocity, self.acceleration, self.jerk = (rng.uniform(1.0, 3.0, n) * 4.0**k for k in range(3))


def random_curve(rng: np.random.Generator) -> BlendedPath:
    """Of one to thirty corners, lone blends and rows of overlapping ones among them, some of them stops."""
    n = int(rng.integers(1, 9))
    steps = rng.normal(size=(int(rng.integers(1, 31)), n)) * rng.choice([0.03, 0.3, 1.0])
    waypoints = np.cumsum(steps, axis=0)
    tolerances = np.where(rng.random(len(waypoints)) < 0.2, 0.0, rng.uniform(1e-3, 0.1, len(waypoints)))
    return blend(waypoints, tolerances)


def random_intervals(rng: np.random.Generator, curve: BlendedPath) -> tuple[Array, Array]:
    marks = np.unique(np.concatenate([curve.knots, rng.uniform(0.0, max(curve.length, 1e-9), 20)]))
    return marks[:-1], marks[1:]


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_states_are_those_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = random_curve(rng)
    s = np.concatenate([rng.uniform(-0.1, curve.length + 0.1, 50), curve.knots, curve.corner_s])
    for d, (found, expected) in enumerate(
        zip(curve.evaluate_all(s), reference.evaluate(curve, s), strict=True)
    ):
        scale = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * scale, err_msg=f"derivative {d}")


@settings(max_examples=200, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_knots_are_those_of_numpy(seed: int) -> None:
    curve = random_curve(np.random.default_rng(seed))
    np.testing.assert_array_equal(curve.knots, reference.knots(curve))


@settings(max_examples=100, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
@example(seed=4653828)  # an interval begins where a blend of 0.8 um ends
def test_bounds_are_those_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = random_curve(rng)
    start, end = random_intervals(rng, curve)
    second, third = reference.derivative_bounds(curve, start, end)
    least, _ = reference.derivative_bounds(curve, start, end, are_short_wide=False)
    np.testing.assert_array_equal(curve.is_line(start, end), reference.are_lines(curve, start, end))
    found = np.asarray(
        curve.second_derivative_bound(start, end)
    )  # both are bounds beside the shortest blends
    np.testing.assert_allclose(np.clip(found, least, second), found, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(curve.third_derivative_bound(start, end), third, rtol=1e-9, atol=1e-12)
    deviation = reference.deviation(curve, start, end)
    np.testing.assert_allclose(curve.deviation(start, end), deviation, rtol=1e-9, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_time_scale_is_that_of_the_quintics(seed: int) -> None:
    rng = np.random.default_rng(seed)
    curve = random_curve(rng)
    s = np.sort(rng.uniform(0.0, curve.length, 30))
    law = TimeLaw(0.01 * np.arange(30.0), s, rng.uniform(0.0, 2.0, 30), rng.normal(size=30))
    limits, scale = Bounds(rng, curve.corners.shape[1]), rng.uniform(0.2, 20.0, 29)
    found = curve.needed_time_scale(law, limits, scale)  # type: ignore[arg-type]
    all_limits = limits.velocity, limits.acceleration, limits.jerk
    np.testing.assert_allclose(found, reference.needed_time_scale(curve, law, all_limits, scale), rtol=1e-9)


def test_what_is_no_polyline_is_refused() -> None:
    corners, turns, directions = np.zeros((2, 3)), np.zeros((2, 3)), np.zeros((3, 3))
    with pytest.raises(ValueError, match="corner_s"):
        BlendedPolyline(corners, np.array([1.0, 0.5]), np.zeros(2), directions, turns)
    with pytest.raises(ValueError, match="turns"):
        BlendedPolyline(corners, np.array([0.0, 1.0]), np.zeros(2), directions, turns[:1])
    curve = BlendedPolyline(corners, np.array([0.0, 1.0]), np.zeros(2), directions, turns)
    with pytest.raises(ValueError, match="highest"):
        curve.evaluate(np.zeros(1), 4)
