"""The closed-form TOPP-RA against the library that implements it with linear programs."""

from __future__ import annotations

import numpy as np
import pytest
from timing_paths import dense_curve, limits, random_walk

from pickcli.geometry import Array
from pickcli.timing.blend import Curve, blend
from pickcli.timing.bounds import path_bounds
from pickcli.timing.topp import Grid, parametrize


def fine_grid(curve: Curve, n: int = 600) -> Grid:
    """Even gridpoints, no lines: what toppra sees too."""
    bounds = path_bounds(curve, limits(), np.array([0.0, curve.length]), np.ones(1), np.array([np.inf]), None)
    s = np.linspace(0.0, curve.length, n)
    _, dq, ddq, _ = curve.evaluate_all(s)
    speed = (bounds.limits.velocity / np.maximum(np.abs(dq), 1e-9)).min(axis=1)
    acceleration = np.tile(bounds.limits.acceleration, (n - 1, 1))
    return Grid(s, dq, ddq, acceleration, speed, np.full(n - 1, 1e3), np.zeros(n - 1, dtype=bool))


def toppra_profile(curve: Curve, s: Array) -> Array:
    """ds/dt (M,) by toppra on the same gridpoints."""
    toppra = pytest.importorskip("toppra")
    from toppra import algorithm, constraint

    class Path(toppra.interpolator.AbstractGeometricPath):  # type: ignore[misc]
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
