"""Overlap of solids against oracles: sampled directions bound the depth, sampled points find common ones."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.scene.solid_overlap import TOUCH, PosedSolid, overlap_depth
from support.solid_oracles import corners, hull_depth, is_inside, points_inside

DIRECTIONS = np.random.default_rng(7).normal(size=(4000, 3))
DIRECTIONS /= np.linalg.norm(DIRECTIONS, axis=1)[:, None]

sizes = st.floats(0.01, 0.2)
boxes = st.tuples(sizes, sizes, sizes).map(lambda s: Shape(ShapeKind.BOX, s))
cylinders = st.tuples(sizes, sizes).map(lambda s: Shape(ShapeKind.CYLINDER, s))
balls = sizes.map(lambda r: Shape(ShapeKind.SPHERE, (r,)))
shapes = st.one_of(boxes, cylinders, balls)
offsets = st.floats(-0.2, 0.2)
angles = st.floats(-np.pi, np.pi)
places = st.builds(
    lambda p, rpy: pose(p, rpy=rpy), st.tuples(offsets, offsets, offsets), st.tuples(angles, angles, angles)
)
solids = st.builds(PosedSolid, shapes, places)

CAN = Shape(ShapeKind.CYLINDER, (0.125, 0.125))
ROUNDING = 2.0**-52


@given(solids, st.integers(0, len(DIRECTIONS) - 1))
def test_the_support_is_a_point_of_the_solid_and_none_lies_farther(solid: PosedSolid, k: int) -> None:
    n = DIRECTIONS[k]
    p = solid.support(n)
    local = (p - solid.T[:3, 3]) @ solid.T[:3, :3]
    assert is_inside(solid.shape.inflated(1e-9), local[None]).all()
    assert np.max(points_inside(solid) @ n) <= p @ n + 1e-9
    if solid.shape.kind is not ShapeKind.SPHERE:
        assert np.max(corners(solid) @ n) <= p @ n + 1e-9


@given(solids, solids)
@example(PosedSolid(CAN, pose((0.0, 0.0, ROUNDING))), PosedSolid(CAN, pose((0.0, ROUNDING, ROUNDING))))
def test_no_overlap_means_no_common_point_deeper_than_a_touch(a: PosedSolid, b: PosedSolid) -> None:
    if overlap_depth(a, b) == 0.0:
        world = points_inside(a.shrunk(TOUCH))
        local = (world - b.T[:3, 3]) @ b.T[:3, :3]
        assert not np.any(is_inside(b.shrunk(TOUCH).shape, local))


@given(solids, solids)
def test_no_false_alarm_where_a_direction_parts_them(a: PosedSolid, b: PosedSolid) -> None:
    shadows = [float(n @ (a.support(n) - b.support(-n))) for n in DIRECTIONS[:800]]
    if min(shadows) <= TOUCH - 1e-6:
        assert overlap_depth(a, b) == 0.0


@given(solids, solids)
def test_order_and_frame_mean_nothing(a: PosedSolid, b: PosedSolid) -> None:
    T = pose((0.3, -0.2, 0.1), rpy=(0.4, 1.0, -2.0))
    depth = overlap_depth(a, b)
    if depth > TOUCH + 1e-6:
        assert overlap_depth(b, a) == pytest.approx(depth, abs=1e-7)
        assert overlap_depth(PosedSolid(a.shape, T @ a.T), PosedSolid(b.shape, T @ b.T)) == pytest.approx(
            depth, abs=1e-7
        )


@given(st.builds(PosedSolid, boxes, places), st.builds(PosedSolid, boxes, places))
def test_the_depth_of_boxes_is_the_shortest_way_out(a: PosedSolid, b: PosedSolid) -> None:
    assert overlap_depth(a, b, 0.0) == pytest.approx(hull_depth(a, b), abs=1e-9)


@given(st.builds(PosedSolid, cylinders, places), st.builds(PosedSolid, st.one_of(boxes, cylinders), places))
@settings(max_examples=50)
def test_the_depth_of_cylinders_is_never_under_the_shortest_way_out(a: PosedSolid, b: PosedSolid) -> None:
    """But 0 where it is within the tolerance."""
    for tolerance in (0.0, 0.02):
        depth = overlap_depth(a, b, tolerance)
        assert depth == 0.0 or depth >= max(tolerance, hull_depth(a, b) - 1e-9)


BOX = Shape(ShapeKind.BOX, (0.1, 0.06, 0.04))
BALL = Shape(ShapeKind.SPHERE, (0.03,))
CAN = Shape(ShapeKind.CYLINDER, (0.03, 0.12))


@pytest.mark.parametrize(
    ("a", "b", "T_a_b"),
    [
        (BOX, BOX, pose((0.0, 0.0, 0.04))),
        (BOX, BALL, pose((0.0, 0.0, 0.05))),
        (BALL, BALL, pose((0.06, 0.0, 0.0))),
        (CAN, CAN, pose((0.0, 0.06, 0.0))),
        (CAN, CAN, pose((0.0, 0.06, 0.0), rpy=(0.0, np.pi / 2, 0.0))),
        (CAN, BOX, pose((0.0, 0.0, 0.08))),
        (
            CAN,
            BOX,
            pose((0.06 / np.sqrt(2), 0.06 / np.sqrt(2), 0.0), rpy=(0.0, 0.0, np.pi / 4)) @ pose((0.02, 0, 0)),
        ),
        (BALL, CAN, pose((0.0, 0.0, 0.09), rpy=(0.0, 0.0, 0.3))),
    ],
)
def test_bodies_that_touch_do_not_overlap_but_pushed_3_mm_they_do(a: Shape, b: Shape, T_a_b: Array) -> None:
    towards = -T_a_b[:3, 3] / np.linalg.norm(T_a_b[:3, 3])
    one = PosedSolid(a, np.eye(4))
    assert overlap_depth(one, PosedSolid(b, pose(0.001 * towards) @ T_a_b)) == 0.0
    assert overlap_depth(one, PosedSolid(b, pose(0.003 * towards) @ T_a_b)) == pytest.approx(0.003, abs=1e-4)


def test_a_solid_thinner_than_what_is_taken_off_becomes_a_sliver() -> None:
    plate = PosedSolid(Shape(ShapeKind.BOX, (0.2, 0.1, 0.01)), np.eye(4))
    np.testing.assert_allclose(plate.shrunk(0.002).shape.extents, (0.196, 0.096, 0.006))
    np.testing.assert_allclose(plate.shrunk(0.5).shape.extents, (0.1902, 0.0902, 0.0002))


turns = st.tuples(angles, angles, angles).map(lambda rpy: pose(rpy=rpy))
directions = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1)
depths = st.floats(0.0, 0.9)


def _met(a: PosedSolid, b: PosedSolid, n: Array, depth: float) -> PosedSolid:
    """b moved to where its farthest point along -n lies ``depth`` m behind a's farthest point along n."""
    return PosedSolid(b.shape, pose(a.support(n) - depth * n - b.support(-n)) @ b.T)


@given(shapes, turns, shapes, turns, directions, depths)
@example(CAN, pose(), CAN, pose(rpy=(1.0, 0.7, 0.0)), (0.3, 0.4, 0.8), 0.5)
@example(
    CAN, pose(), Shape(ShapeKind.BOX, (0.1, 0.06, 0.04)), pose(rpy=(1.0, 0.7, 0.4)), (0.3, 0.4, 0.8), 0.5
)
def test_solids_that_a_plane_parts_but_for_a_touch_do_not_overlap(
    a: Shape, T_a: Array, b: Shape, T_b: Array, n: tuple[float, float, float], depth: float
) -> None:
    """Wherever that plane lies: corner on rim, rim on rim, edge on mantle."""
    one, direction = PosedSolid(a, T_a), np.array(n) / np.linalg.norm(n)
    other = _met(one, PosedSolid(b, T_b), direction, depth * TOUCH)
    assert overlap_depth(one, other) == 0.0
    assert overlap_depth(other, one) == 0.0


@example(Shape(ShapeKind.BOX, (0.125, 0.125, 0.125)), np.eye(4), np.eye(4), (1.0, 1.0, 1.0), 0.02, 0.1015625)
@given(boxes, turns, places, directions, st.floats(0.02, 0.2), st.floats(0.1, 0.99))
def test_a_ball_stands_in_a_box_as_deep_as_its_radius_exceeds_its_distance(
    box: Shape, T: Array, T_world: Array, n: tuple[float, float, float], radius: float, share: float
) -> None:
    """As long as its middle is outside: over a face, an edge or a corner."""
    size, depth = box.extents / 2, share * radius
    outside = np.array(n) / np.linalg.norm(n)
    surface = np.where(abs(outside) > 0.3, np.copysign(size, outside), outside * size)
    normal = np.where(abs(outside) > 0.3, outside, 0.0)
    middle = surface + (radius - depth) * normal / np.linalg.norm(normal)
    one = PosedSolid(box, T_world)
    ball = PosedSolid(Shape(ShapeKind.SPHERE, (radius,)), T_world @ pose(middle) @ T)
    expected = depth if depth > TOUCH else 0.0
    assert overlap_depth(one, ball) == pytest.approx(expected, abs=1e-9)
    assert overlap_depth(ball, one) == pytest.approx(expected, abs=1e-9)


@given(places, st.floats(-0.5, 0.5), st.floats(0.2, 1.3), st.floats(0.003, 0.02))
def test_a_can_along_an_edge_stands_in_it_as_deep_as_its_radius_exceeds_its_distance(
    T_world: Array, along: float, angle: float, depth: float
) -> None:
    """A can much longer than the box, and its middle anywhere beside it."""
    can = Shape(ShapeKind.CYLINDER, (0.03, 0.3))
    outwards = np.array([np.cos(angle), np.sin(angle), 0.0])
    box = PosedSolid(Shape(ShapeKind.BOX, (0.1, 0.06, 0.04)), T_world)
    middle = np.array([0.05, 0.03, 0.2 * along]) + (0.03 - depth) * outwards
    assert overlap_depth(box, PosedSolid(can, T_world @ pose(middle))) == pytest.approx(depth, abs=1e-9)
    assert overlap_depth(PosedSolid(can, T_world @ pose(middle)), box) == pytest.approx(depth, abs=1e-9)


def test_solids_far_apart_do_not_overlap_and_a_solid_overlaps_itself() -> None:
    for shape in (Shape(ShapeKind.BOX, (0.1, 0.06, 0.04)), CAN, Shape(ShapeKind.SPHERE, (0.03,))):
        one = PosedSolid(shape, np.eye(4))
        assert overlap_depth(one, PosedSolid(shape, pose((1.0, 0.0, 0.0)))) == 0.0
        assert overlap_depth(one, one) == pytest.approx(min(shape.extents))
