"""Covers: contain the solid, stick out no farther than stated, stay few."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.collision.hull_cover import cover_hulls, depths
from pickcli.collision.sphere_cover import Cover, cover_bodies, cover_shape
from pickcli.geometry import Array, pose, rotation_rpy

LENGTH = st.floats(0.004, 0.5)
BOXES = st.tuples(LENGTH, LENGTH, LENGTH).map(lambda size: Shape(ShapeKind.BOX, size))
CYLINDERS = st.tuples(st.floats(0.005, 0.2), LENGTH).map(lambda size: Shape(ShapeKind.CYLINDER, size))
SPHERES = st.tuples(st.floats(0.002, 0.2)).map(lambda size: Shape(ShapeKind.SPHERE, size))
SOLIDS = st.one_of(BOXES, CYLINDERS, SPHERES)

BOOK = Shape(ShapeKind.BOX, (0.2, 0.167, 0.004))
LANCE = Shape(ShapeKind.CYLINDER, (0.0125, 0.48))
CUBE = Shape(ShapeKind.BOX, (0.2, 0.2, 0.2))
CARTON = Shape(ShapeKind.BOX, (0.3, 0.15, 0.15))


def points_of(shape: Shape, rng: np.random.Generator, n: int = 3000) -> Array:
    """Points of a solid, half of them on its surface, with corners and rims."""
    unit = rng.uniform(-1, 1, (n, 3))
    unit[: n // 2] = np.where(rng.random((n // 2, 3)) < 0.5, np.sign(unit[: n // 2]), unit[: n // 2])
    if shape.kind is ShapeKind.BOX:
        return unit * shape.extents / 2
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(shape.size[0] * unit / np.linalg.norm(unit, axis=1, keepdims=True))
    radius, length = shape.size
    angle, rho = np.pi * rng.uniform(-1, 1, n), np.sqrt(np.abs(unit[:, 0])) * radius
    return np.column_stack([rho * np.cos(angle), rho * np.sin(angle), unit[:, 2] * length / 2])


def distance_outside(shape: Shape, points: Array) -> Array:
    """Distance of points to the solid, 0 inside: the textbook formulas, apart from the code under test."""
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(np.maximum(np.linalg.norm(points, axis=1) - shape.size[0], 0))
    if shape.kind is ShapeKind.BOX:
        return np.asarray(np.linalg.norm(np.maximum(np.abs(points) - shape.extents / 2, 0), axis=1))
    radius, length = shape.size
    across = np.maximum(np.hypot(points[:, 0], points[:, 1]) - radius, 0)
    return np.hypot(across, np.maximum(np.abs(points[:, 2]) - length / 2, 0))


def are_inside(cover: Cover, points: Array) -> bool:
    gaps = np.linalg.norm(points[:, None] - cover.centers, axis=2) - cover.radii
    return bool((gaps.min(axis=1) <= 1e-12).all())


def surface_of(cover: Cover, rng: np.random.Generator, n: int = 40) -> Array:
    directions = rng.normal(size=(len(cover.radii), n, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    return (cover.centers[:, None] + cover.radii[:, None, None] * directions).reshape(-1, 3)


@settings(max_examples=60, deadline=None)
@given(shape=SOLIDS, seed=st.integers(0, 2**32 - 1), excess=st.floats(0.002, 0.02))
def test_cover_contains_the_solid_and_sticks_out_as_stated(shape: Shape, seed: int, excess: float) -> None:
    rng = np.random.default_rng(seed)
    cover = cover_shape(shape, excess, 150)
    assert are_inside(cover, points_of(shape, rng))
    assert distance_outside(shape, surface_of(cover, rng)).max() <= cover.excess + 1e-9
    assert len(cover.radii) <= 150


@settings(max_examples=30, deadline=None)
@given(size=st.tuples(*3 * [st.floats(0.01, 0.08)]), excess=st.floats(0.004, 0.02))
def test_excess_is_kept_where_the_count_does_not_bind(size: tuple[float, ...], excess: float) -> None:
    for shape in (Shape(ShapeKind.BOX, size), Shape(ShapeKind.CYLINDER, size[:2])):
        cover = cover_shape(shape, excess, 2000)
        assert cover.excess <= excess + 1e-8


@pytest.mark.parametrize(
    ("shape", "max_excess", "count", "excess"),
    [
        (BOOK, 0.007, 150, 0.0095),
        (LANCE, 0.006, 20, 0.006),
        (CUBE, 0.007, 150, 0.009),
        (CARTON, 0.007, 150, 0.0095),
    ],
)
def test_typical_solids_are_covered_tightly(
    shape: Shape, max_excess: float, count: int, excess: float
) -> None:
    cover = cover_shape(shape, max_excess)
    assert len(cover.radii) <= count
    assert cover.excess <= excess + 1e-8


def test_cover_is_remembered() -> None:
    again = Shape(ShapeKind.BOX, (0.2, 0.167, 0.004))
    assert cover_shape(BOOK) is cover_shape(again)


def capsule(radius: float, length: float, T: Array) -> list[Body]:
    ends = [T @ pose((0, 0, z)) for z in (-length / 2, length / 2)]
    ball = Shape(ShapeKind.SPHERE, (radius,))
    return [
        Body("middle", Shape(ShapeKind.CYLINDER, (radius, length)), T),
        *(Body(f"end{i}", ball, end) for i, end in enumerate(ends)),
    ]


@settings(max_examples=30, deadline=None)
@given(
    radius=st.floats(0.03, 0.15), length=st.floats(0.01, 0.4), angles=st.tuples(*3 * [st.floats(-3, 3)]),
    seed=st.integers(0, 2**32 - 1),
)  # fmt: skip
def test_capsule_needs_only_spheres_on_its_axis(
    radius: float, length: float, angles: tuple[float, float, float], seed: int
) -> None:
    T = pose((0.1, -0.2, 0.3), R=rotation_rpy(*angles))
    bodies = capsule(radius, length, T)
    cover = cover_bodies(bodies, lambda body: 0.006)
    rng = np.random.default_rng(seed)
    for body in bodies:
        points = points_of(body.shape, rng, 500)
        assert are_inside(cover, points @ body.T_parent_shape[:3, :3].T + body.T_parent_shape[:3, 3])
    local = (surface_of(cover, rng) - T[:3, 3]) @ T[:3, :3]
    nearest = np.clip(local[:, 2], -length / 2, length / 2)
    outside = np.linalg.norm(local - np.column_stack([0 * nearest, 0 * nearest, nearest]), axis=1) - radius
    assert outside.max() <= cover.excess + 1e-9 <= 0.0062
    spacing = 2 * np.sqrt((radius + 0.006) ** 2 - radius**2)
    assert len(cover.radii) <= length / spacing + 2


def test_spheres_inside_others_are_dropped() -> None:
    small = Body("small", Shape(ShapeKind.SPHERE, (0.01,)), pose((0.05, 0, 0)))
    large = Body("large", Shape(ShapeKind.SPHERE, (0.1,)), pose())
    twin = Body("twin", Shape(ShapeKind.SPHERE, (0.1,)), pose())
    cover = cover_bodies([small, large, twin], lambda body: 0.006)
    np.testing.assert_array_equal(cover.radii, [0.1])


def test_no_bodies_no_spheres() -> None:
    cover = cover_bodies([], lambda body: 0.006)
    assert cover.centers.shape == (0, 3) and cover.radii.shape == (0,)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), n_pieces=st.integers(1, 3))
def test_spheres_contain_hulls_and_stick_out_no_farther_than_stated(seed: int, n_pieces: int) -> None:
    rng = np.random.default_rng(seed)
    pieces = [rng.uniform(-0.1, 0.1, 3) + rng.normal(scale=0.04, size=(12, 3)) for _ in range(n_pieces)]
    centers, radii = cover_hulls(pieces, 0.014, 0.02, 32)
    inside = np.concatenate([rng.dirichlet(np.full(12, 0.2), 2000) @ piece for piece in pieces])
    corners = np.concatenate(pieces)
    for points in (inside, corners):
        away = np.linalg.norm(points[:, None] - centers, axis=2) - radii
        assert away.min(axis=1).max() <= 1e-9
    assert (radii - depths(pieces, centers)).max() <= 0.02 + 1e-9
