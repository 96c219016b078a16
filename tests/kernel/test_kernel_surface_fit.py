"""Distances to surfaces, and poses fitted to points on them, against numpy and scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from pickcli.geometry import Array, pose, rotation_angle, rotation_axis_angle
from pickcli.kernel import SolidKind, fit_surface, surface_distance

BOX, CYLINDER, SPHERE = (kind.value for kind in (SolidKind.BOX, SolidKind.CYLINDER, SolidKind.SPHERE))
SOLIDS = [
    (BOX, np.array([0.07, 0.05, 0.02])),
    (CYLINDER, np.array([0.04, 0.04, 0.09])),
    (SPHERE, np.array([0.035, 0.035, 0.035])),
]
BRICK = SOLIDS[0][1]
UP = np.array([0.0, 0.0, 1.0])


def reference_distance(kind: int, half: Array, points: Array) -> Array:
    """Outside by the nearest point of the solid, inside by the nearest face."""
    if kind == SPHERE:
        return np.asarray(np.linalg.norm(points, axis=1) - half[0])
    if kind == CYLINDER:
        points = np.stack([np.linalg.norm(points[:, :2], axis=1), points[:, 2]], axis=1)
        half = half[[0, 2]]
    outside = np.linalg.norm(points - np.clip(points, -half, half), axis=1)
    return np.asarray(np.where(outside > 0.0, outside, -(half - np.abs(points)).min(axis=1)))


def on_surface(kind: int, half: Array, n: int, rng: np.random.Generator) -> Array:
    """Points moved onto the surface along the gradient."""
    points = rng.uniform(-1.2, 1.2, (n, 3)) * half
    for _ in range(30):
        distance, gradient = surface_distance(kind, half, points)
        points = points - distance[:, None] * gradient
    return np.asarray(points)


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
def test_distances_are_those_to_the_nearest_point(kind: int, half: Array) -> None:
    points = np.random.default_rng(1).uniform(-0.15, 0.15, (2000, 3))
    distance, gradient = surface_distance(kind, half, points)
    np.testing.assert_allclose(distance, reference_distance(kind, half, points), atol=1e-14)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1.0, atol=1e-12)


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
def test_gradients_are_the_slopes_of_distances(kind: int, half: Array) -> None:
    points, step = np.random.default_rng(2).uniform(-0.15, 0.15, (500, 3)), 1e-7
    _, gradient = surface_distance(kind, half, points)
    slopes = np.stack(
        [
            (reference_distance(kind, half, points + d) - reference_distance(kind, half, points - d))
            / (2 * step)
            for d in step * np.eye(3)
        ],
        axis=1,
    )
    # At an edge inside, where two faces are equally near, there is no slope.
    assert (np.abs(slopes - gradient).max(axis=1) < 1e-5).mean() > 0.99


@pytest.mark.parametrize(("kind", "half"), SOLIDS)
@pytest.mark.parametrize("seed", range(5))
def test_a_fit_from_nearby_finds_the_pose(kind: int, half: Array, seed: int) -> None:
    """3 cm and 20 degrees off, 1 mm of noise, points on all sides; turns that nobody sees do not count."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=3)
    true = pose(rng.uniform(-1.0, 1.0, 3), R=rotation_axis_angle(axis / np.linalg.norm(axis), 1.0))
    points = on_surface(kind, half, 600, rng) @ true[:3, :3].T + true[:3, 3] + rng.normal(0.0, 1e-3, (600, 3))
    start = true.copy()
    start[:3, 3] += 0.03 * UP
    start[:3, :3] = rotation_axis_angle(UP, np.radians(20.0)) @ true[:3, :3]
    T, cost, steps = fit_surface(kind, half, points, start, 0.012)
    T, cost, more = fit_surface(kind, half, points, T, 0.006)
    assert np.linalg.norm(T[:3, 3] - true[:3, 3]) < 5e-4
    off = {
        BOX: rotation_angle(T[:3, :3].T @ true[:3, :3]),
        CYLINDER: float(np.arccos(np.clip(T[:3, 2] @ true[:3, 2], -1.0, 1.0))),
        SPHERE: 0.0,
    }
    assert off[kind] < np.radians(0.5)
    assert cost < 0.06
    assert steps + more < 100


def test_a_fit_ends_where_scipy_does() -> None:
    """The minimum of the same robust cost by another method, from the same start."""
    rng, half = np.random.default_rng(7), BRICK
    points = on_surface(BOX, half, 300, rng) + rng.normal(0.0, 2e-3, (300, 3))
    points[:40] += rng.uniform(-0.04, 0.04, (40, 3))  # of something else
    start, scale = pose((0.006, -0.004, 0.005), rpy=(0.0, 0.0, 0.08)), 0.008

    def residuals(x: Array) -> Array:
        T = pose(x[:3], R=rotation_axis_angle(UP, float(x[3])) @ start[:3, :3])
        return np.asarray(surface_distance(BOX, half, (points - T[:3, 3]) @ T[:3, :3])[0])

    def geman_mcclure(z: Array) -> Array:
        return np.array([z / (1.0 + z), 1.0 / (1.0 + z) ** 2, -2.0 / (1.0 + z) ** 3])

    expected = least_squares(
        residuals,
        [*start[:3, 3], 0.0],
        method="dogbox",
        loss=geman_mcclure,
        f_scale=scale,
        xtol=1e-12,
        ftol=1e-12,
    )
    T, cost, _ = fit_surface(BOX, half, points, start, scale, UP, 200)
    np.testing.assert_allclose(T[:3, 3], expected.x[:3], atol=2e-4)
    assert cost == pytest.approx(2.0 * expected.cost / scale**2 / len(points), rel=1e-3)


def test_an_upright_fit_turns_about_one_axis() -> None:
    rng, half = np.random.default_rng(3), BRICK
    points = on_surface(BOX, half, 300, rng) @ pose(rpy=(0.1, 0.1, 0.2))[:3, :3].T
    T, _, _ = fit_surface(BOX, half, points, np.eye(4), 0.01, UP)
    np.testing.assert_allclose(T[:3, 2], UP, atol=1e-12)


def test_without_points_there_is_nothing_to_fit() -> None:
    T, cost, steps = fit_surface(BOX, BRICK, np.zeros((0, 3)), pose((1.0, 2.0, 3.0)), 0.01)
    np.testing.assert_array_equal(T, pose((1.0, 2.0, 3.0)))
    assert (cost, steps) == (0.0, 0)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ((3, (0.1, 0.1, 0.1), [[0.0, 0.0, 0.0]], np.eye(4), 0.01), "kind"),
        ((0, (0.1, -0.1, 0.1), [[0.0, 0.0, 0.0]], np.eye(4), 0.01), "half_extents"),
        ((1, (0.1, 0.2, 0.1), [[0.0, 0.0, 0.0]], np.eye(4), 0.01), "half_extents"),
        ((0, (0.1, 0.1, 0.1), [[0.0, 0.0, np.nan]], np.eye(4), 0.01), "points: not finite"),
        ((0, (0.1, 0.1, 0.1), [[0.0, 0.0, 0.0]], 2.0 * np.eye(4), 0.01), "start: not a rigid pose"),
        ((0, (0.1, 0.1, 0.1), [[0.0, 0.0, 0.0]], np.eye(4), 0.0), "scale"),
    ],
)
def test_what_is_no_fit_is_told(arguments: tuple[object, ...], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        fit_surface(*arguments)  # type: ignore[arg-type]
