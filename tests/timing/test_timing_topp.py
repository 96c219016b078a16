"""TOPP-RA: the kernel's passes against their numpy oracle, and against the library with linear programs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from toppra import algorithm, constraint
from toppra.interpolator import AbstractGeometricPath

from pickcli.geometry import Array
from pickcli.timing.corner_blending import BlendedPath, blend
from pickcli.timing.jerk_smoothing import smooth
from pickcli.timing.path_limits import path_bounds
from pickcli.timing.toppra_closed_form import PathGrid, parametrize
from support import reference_topp
from support.timing_paths import dense_curve, limits, random_walk


def fine_grid(curve: BlendedPath, n: int = 600) -> PathGrid:
    """Even gridpoints, no lines: what toppra sees too."""
    bounds = path_bounds(curve, limits(), np.array([0.0, curve.length]), np.ones(1), np.array([np.inf]), None)
    s = np.linspace(0.0, curve.length, n)
    _, dq, ddq, _ = curve.evaluate_all(s)
    speed = (bounds.limits.velocity / np.maximum(np.abs(dq), 1e-9)).min(axis=1)
    acceleration = np.tile(bounds.limits.acceleration, (n - 1, 1))
    return PathGrid(s, dq, ddq, acceleration, speed, np.full(n - 1, 1e3), np.zeros(n - 1, dtype=bool))


def toppra_profile(curve: BlendedPath, s: Array) -> Array:
    """ds/dt (M,) by toppra on the same gridpoints."""

    class Path(AbstractGeometricPath):  # type: ignore[misc]
        dof = curve.corners.shape[1]
        path_interval = np.array([0.0, curve.length])
        waypoints = (np.array([0.0, curve.length]), curve.corners[[0, -1]])

        def __call__(self, position: Array, order: int = 0) -> Array:
            q = curve.evaluate(position, order)
            return q[0] if np.ndim(position) == 0 else q

    bound = limits()
    constraints = [
        constraint.JointVelocityConstraint(np.column_stack([-bound.velocity, bound.velocity])),
        constraint.JointAccelerationConstraint(
            np.column_stack([-bound.acceleration, bound.acceleration]),
            discretization_scheme=constraint.DiscretizationType.Interpolation,
        ),
    ]
    solver = algorithm.TOPPRA(constraints, Path(), gridpoints=s, solver_wrapper="seidel")
    return np.asarray(solver.compute_parameterization(0.0, 0.0)[1])


@pytest.mark.parametrize("waypoints", [random_walk(0, 2), random_walk(1, 5), dense_curve(2, 30)])
def test_profile_is_that_of_toppra(waypoints: Array) -> None:
    curve = blend(waypoints, 0.02)
    grid = fine_grid(curve)
    mine = np.interp(grid.s, (profile := parametrize(grid)).s, profile.v)
    assert np.allclose(mine, toppra_profile(curve, grid.s), atol=2e-3 * mine.max())


@pytest.mark.parametrize("seed", range(5))
def test_few_gridpoints_on_the_knots_are_as_good_as_many(seed: int) -> None:
    curve = blend(random_walk(seed, 6), 0.05)
    bounds = path_bounds(curve, limits(), np.array([0.0, curve.length]), np.ones(1), np.array([np.inf]), None)
    few = bounds.grid(curve, 1.0, np.inf, 0.0)
    assert len(few.s) < 60
    assert parametrize(few).duration == pytest.approx(parametrize(fine_grid(curve, 4000)).duration, rel=0.05)


def test_cruise_lasts_as_long_as_asked() -> None:
    curve = blend(np.array([[0.0], [0.4]]), 0.02)
    bounds = path_bounds(curve, limits(1), np.array([0.0, 0.4]), np.ones(1), np.array([np.inf]), None)
    profile = parametrize(bounds.grid(curve, 1.0, np.inf, 0.3))
    fastest = profile.v.max()
    assert np.ptp(profile.t[profile.v > fastest - 1e-9]) == pytest.approx(0.3)


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**31), n_points=st.integers(2, 12), n=st.integers(1, 8), size=st.floats(1e-4, 2.0)
)
def test_the_kernel_agrees_with_numpy(seed: int, n_points: int, n: int, size: float) -> None:
    curve = blend(random_walk(seed, n_points, n, size), 0.02)
    whole = np.array([0.0, curve.length])
    bounds = path_bounds(curve, limits(n), whole, np.ones(1), np.array([np.inf]), None)
    for cruise in (0.0, 0.05):
        grid = bounds.grid(curve, 1.0, 1.0, cruise)
        mine, oracle = parametrize(grid), reference_topp.parametrize(grid)
        assert mine.duration == pytest.approx(oracle.duration, rel=1e-9)
        t = np.linspace(0.0, mine.duration, 200)
        there, expected = (reference_topp.position(profile, t) for profile in (mine, oracle))
        assert np.allclose(there, expected, rtol=0.0, atol=1e-9 * curve.length)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**31), step=st.floats(1e-3, 0.02), n_window=st.integers(1, 30))
def test_the_kernel_smooths_as_numpy_does(seed: int, step: float, n_window: int) -> None:
    curve = blend(random_walk(seed, 5), 0.02)
    whole = np.array([0.0, curve.length])
    bounds = path_bounds(curve, limits(), whole, np.ones(1), np.array([np.inf]), None)
    profile = parametrize(bounds.grid(curve, 1.0, 1.0, 0.0))
    law = smooth(profile, step, n_window)
    for found, expected in zip(
        (law.s, law.ds, law.dds), reference_topp.smooth(profile, step, n_window), strict=True
    ):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_profile_is_at_rest_at_its_ends_and_never_turns_back() -> None:
    curve = blend(random_walk(3, 8), 0.05)
    bounds = path_bounds(curve, limits(), np.array([0.0, curve.length]), np.ones(1), np.array([np.inf]), None)
    profile = parametrize(bounds.grid(curve, 1.0, 1.0, 0.05))
    assert profile.v[0] == profile.v[-1] == 0.0
    assert profile.s[0] == 0.0 and profile.s[-1] == curve.length
    assert np.all(np.diff(profile.t) > 0.0) and np.all(np.diff(profile.s) > 0.0)
