"""Widths, gaps and overlaps of single solids against points on their surfaces, and what is known by hand."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind, hull
from pickcli.geometry import Array, pose
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.verification.separation import (
    GAP_TOLERANCE,
    corners,
    face_normals,
    gap,
    half_width_terms,
    half_widths,
    overlap,
    separation,
    support,
    widest_gaps,
)
from support.solid_oracles import hull_depth

BOX = Shape(ShapeKind.BOX, (0.2, 0.4, 0.6))
CAN = Shape(ShapeKind.CYLINDER, (0.1, 0.5))
BALL = Shape(ShapeKind.SPHERE, (0.15,))
WEDGE = hull("wedge", np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.4], [0.3, 0, 0.1]])).shape
SHAPES = [BOX, CAN, BALL, WEDGE]
T = pose((0.3, -0.2, 0.7), rpy=(0.3, -0.5, 1.1))


def outline(shape: Shape, n: int = 90) -> Array:
    """Points on the surface in the shape's own frame, among them all corners."""
    if shape.kind is ShapeKind.HULL:
        return np.array(shape.vertices)
    if shape.kind is ShapeKind.BOX:
        return np.array(list(product((-0.5, 0.5), repeat=3))) * shape.extents
    turns = np.linspace(0.0, 2.0 * np.pi, n)
    if shape.kind is ShapeKind.CYLINDER:
        (radius, length), z = shape.size, (-0.5, 0.5)
        return np.array([(radius * np.cos(t), radius * np.sin(t), length * s) for t in turns for s in z])
    tilts = np.linspace(-np.pi / 2, np.pi / 2, n)
    around, up = np.meshgrid(turns, tilts)
    unit = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1)
    return shape.size[0] * unit.reshape(-1, 3)


def ways(n: int = 30) -> Array:
    """Unit directions (n, 3), the six along the axes of ``T`` among them."""
    random = np.random.default_rng(3).normal(size=(n - 6, 3))
    return np.vstack([T[:3, :3].T, -T[:3, :3].T, random / np.linalg.norm(random, axis=1)[:, None]])


def half_width(shape: Shape, T: Array, way: Array) -> float:
    """From the middle of a posed shape to the plane across a direction that touches it, m."""
    return float(half_widths(shape, (way @ T[:3, :3])[None])[0])


@pytest.mark.parametrize("shape", SHAPES)
def test_a_solid_is_as_wide_as_its_farthest_point_and_the_support_is_that_point(shape: Shape) -> None:
    points = outline(shape) @ T[:3, :3].T
    for way in ways():
        farthest = float((points @ way).max())
        width = half_width(shape, T, way)
        assert farthest - 1e-12 <= width <= farthest + 1.5e-3 * max(shape.extents)
        at = support(shape, T, 3.0 * way)
        assert float((at - T[:3, 3]) @ way) == pytest.approx(width, abs=1e-12)
        assert all(float((at - T[:3, 3]) @ w) <= half_width(shape, T, w) + 1e-12 for w in ways())


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
def test_one_formula_tells_the_width_of_every_shape(shape: Shape) -> None:
    terms = half_width_terms(shape)
    for way in ways():
        x, y, z = np.abs(way)
        told = terms @ [x, y, z, np.hypot(x, y), 1.0]
        assert told == pytest.approx(half_width(shape, np.eye(4), way), abs=1e-12)


def test_of_a_hull_the_formula_tells_the_width_of_the_box_around_it() -> None:
    box = Shape(ShapeKind.BOX, tuple(float(2 * np.abs(c).max()) for c in corners(WEDGE).T))
    np.testing.assert_allclose(half_width_terms(WEDGE)[3:], 0.0)
    for way in np.eye(3):
        assert half_width_terms(WEDGE)[:3] @ way >= half_width(WEDGE, np.eye(4), way) - 1e-12
        assert half_width_terms(WEDGE)[:3] @ way <= half_width(box, np.eye(4), way) + 1e-12


def test_a_hull_leaves_another_across_its_faces() -> None:
    normals = face_normals(WEDGE)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    for face in ((-1, 0, 0), (0, -1, 0), (0, 0, -1)):
        assert np.abs(normals - face).sum(axis=1).min() < 1e-6
    for shape in (BOX, CAN, BALL):
        np.testing.assert_array_equal(face_normals(shape), np.eye(3))


@pytest.mark.parametrize("a", SHAPES)
@pytest.mark.parametrize("b", SHAPES)
def test_the_gap_across_a_direction_is_what_is_empty_between_the_two(a: Shape, b: Shape) -> None:
    T_b = T @ pose((0.9, 0.4, -0.5), rpy=(1.0, 0.2, 0.3))
    for way in ways(12):
        one = (outline(a) @ T[:3, :3].T + T[:3, 3]) @ way
        other = (outline(b) @ T_b[:3, :3].T + T_b[:3, 3]) @ way
        assert gap(a, T, b, T_b, 7.0 * way) == pytest.approx(other.min() - one.max(), abs=2e-3)
    assert gap(a, T, b, T_b, np.zeros(3)) == -np.inf


@pytest.mark.parametrize("far", [1e-4, 0.02, 0.7])
@pytest.mark.parametrize(
    ("a", "b", "way", "reach"),
    [
        (BOX, BOX, (1, 0, 0), 0.2),
        (BOX, BALL, (0, 1, 0), 0.35),
        (CAN, BOX, (0, 0, 1), 0.55),
        (CAN, CAN, (0.6, 0.8, 0), 0.2),
        (CAN, BALL, (0.6, -0.8, 0), 0.25),
        (BALL, BALL, (2 / 3, 1 / 3, 2 / 3), 0.3),
        (BOX, WEDGE, (-1, 0, 0), None),
    ],
)
def test_solids_that_were_moved_apart_are_that_far_apart(
    a: Shape, b: Shape, way: tuple[float, float, float], reach: float | None, far: float
) -> None:
    """Both as one turns them, one moved along a direction in which they first touch."""
    n = np.array(way, dtype=float)
    touching = reach or half_width(a, np.eye(4), n) + half_width(b, np.eye(4), -n)
    T_b = T @ pose((touching + far) * n)
    for found in (separation(a, T, b, T_b), separation(b, T_b, a, T)):
        assert far - 2 * GAP_TOLERANCE <= found <= far + 1e-12
    assert separation(a, T, b, T @ pose((touching - 1e-4) * n)) == 0.0


def test_corners_and_edges_are_as_far_apart_as_their_nearest_points() -> None:
    """A corner 30, 40 and 120 mm beyond a corner, and an edge 30 and 40 mm beyond an edge."""
    size = np.array(BOX.size)
    for beyond, far in (((0.03, 0.04, 0.12), 0.13), ((0.03, 0.04, -0.2), 0.05), ((0.03, -0.1, -0.2), 0.03)):
        T_b = T @ pose(size + beyond)
        assert far - 2 * GAP_TOLERANCE <= separation(BOX, T, BOX, T_b) <= far + 1e-12
        # The axes of both, their products and the centres' line: two boxes that meet have no gap at all.
        terms = half_width_terms(BOX)[None]
        assert far / 3 < widest_gaps(terms, T[None], terms, T_b[None])[0] <= far + 1e-12


def test_the_bounds_of_many_pairs_are_those_of_their_best_directions() -> None:
    """A box and one that is turned by 45 degrees are as far apart as its edge from the face before it."""
    terms = half_width_terms(BOX)[None]
    reach = 0.1 + (0.1 + 0.2) / np.sqrt(2)
    for far in (0.05, -0.05):
        moved = T @ pose((reach + far, 0.0, 0.0), rpy=(0.0, 0.0, np.pi / 4))
        for one, other in ((T, moved), (moved, T)):
            assert widest_gaps(terms, one[None], terms, other[None])[0] == pytest.approx(far, abs=1e-9)
    same = widest_gaps(terms, T[None], terms, T[None])[0]
    assert same == pytest.approx(-0.2)  # as much as the push across its narrow side


def test_edges_that_cross_are_told_apart_by_their_product() -> None:
    """Two boxes edge over edge, one turned about x and the other about y: no face of either parts them."""
    cube = Shape(ShapeKind.BOX, (0.2, 0.2, 0.2))
    terms, half = half_width_terms(cube)[None], 0.1 * np.sqrt(2)
    below = T @ pose(rpy=(np.pi / 4, 0.0, 0.0))
    above = T @ pose((0.0, 0.0, 2 * half + 0.01)) @ pose(rpy=(0.0, np.pi / 4, 0.0))
    assert widest_gaps(terms, below[None], terms, above[None])[0] == pytest.approx(0.01, abs=1e-9)
    sunk = T @ pose((0.0, 0.0, 2 * half - 0.01)) @ pose(rpy=(0.0, np.pi / 4, 0.0))
    assert overlap(cube, below, cube, sunk, [])[0] == pytest.approx(0.01, abs=1e-9)


@pytest.mark.parametrize("seed", range(20))
def test_boxes_overlap_by_the_shortest_way_out(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a = Shape(ShapeKind.BOX, tuple(rng.uniform(0.05, 0.3, 3).tolist()))
    b = Shape(ShapeKind.BOX, tuple(rng.uniform(0.05, 0.3, 3).tolist()))
    T_b = T @ pose(rng.uniform(-0.03, 0.03, 3), rpy=rng.uniform(-np.pi, np.pi, 3))
    depth = hull_depth(PosedSolid(a, T), PosedSolid(b, T_b))
    assert depth > 0.0
    assert overlap(a, T, b, T_b, [])[0] == pytest.approx(depth, abs=1e-9)
    assert overlap(b, T_b, a, T, [])[0] == pytest.approx(depth, abs=1e-9)
    assert separation(a, T, b, T_b) == 0.0


@pytest.mark.parametrize(
    ("a", "b", "T_a_b", "depth"),
    [
        (BALL, BALL, pose((0.12, 0.16, 0.0)), 0.1),
        (CAN, BALL, pose((0.16, 0.12, 0.1)), 0.05),
        (CAN, CAN, pose((0.09, 0.12, 0.3)), 0.05),
        (CAN, BALL, pose((0.01, 0.02, 0.36)), 0.04),
        (BOX, BALL, pose((0.02, 0.03, 0.4)), 0.05),
    ],
)
def test_round_solids_overlap_by_what_their_radii_exceed_their_distance(
    a: Shape, b: Shape, T_a_b: Array, depth: float
) -> None:
    assert overlap(a, T, b, T @ T_a_b, [])[0] == pytest.approx(depth, abs=1e-9)
    assert overlap(b, T @ T_a_b, a, T, [])[0] == pytest.approx(depth, abs=1e-9)


def test_a_direction_that_is_given_counts() -> None:
    """Corner of a hull in the face of a box: only a direction that is given tells how deep."""
    peak = hull("peak", np.array([[0, 0, 0], [1, 1, 2], [1, -1, 2], [-1, 1, 2], [-1, -1, 2]]) * 0.05).shape
    down = np.array([0.0, 0.0, -1.0])
    lowest = half_width(peak, np.eye(4), down)
    there = T @ pose((0.02, 0.03, 0.3 + lowest - 0.02))
    assert overlap(BOX, T, peak, there, [T[:3, 2]])[0] == pytest.approx(0.02, abs=1e-9)
    assert overlap(BOX, T, peak, there, [-5.0 * T[:3, 2], np.zeros(3)])[0] == pytest.approx(0.02, abs=1e-9)
