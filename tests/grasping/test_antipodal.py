"""Pinches against an oracle: what lines between the pads meet, its normals, thickness, all of the pads."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import Finger, ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import Array, is_pose, pose, rotation_from_vector, rotation_rpy
from pickcli.grasping.antipodal import MAX_TILT, Pinch, flattened, limits_of, patch, pinches
from pickcli.scene.scene import PoseNoise
from pickcli.verification.pinch_check import pads_on

PAD = (0.02, 0.018)
GRIPPER = ParallelGripper(
    (Finger("left", "left_slide", 1.0, 1.0), Finger("right", "right_slide", -1.0, 1.0)),
    PAD, 0.0, PinchLimits(40.0, 0.5, PAD), 0.1, 0.1,
)  # fmt: skip
FAN = (0.0, 0.25, -0.25)

sizes = st.floats(0.02, 0.2)
boxes = st.builds(lambda *size: Shape(ShapeKind.BOX, size), sizes, sizes, sizes)
cylinders = st.builds(lambda *size: Shape(ShapeKind.CYLINDER, size), st.floats(0.015, 0.06), sizes)
spheres = st.builds(lambda r: Shape(ShapeKind.SPHERE, (r,)), st.floats(0.015, 0.06))
angles = st.floats(-3.1, 3.1)
ways = st.builds(lambda *rpy: rotation_rpy(*rpy)[:, 0], angles, angles, angles)


def found(shape: Shape, way_in: Array, grid: int = 3) -> list[Pinch]:
    return [*pinches(shape, PAD, way_in, FAN, grid, np.random.default_rng(5), 2)]


def limits(shape: Shape, pinch: Pinch) -> PinchLimits:
    found = limits_of(GRIPPER, shape, pinch.face, pinch.T_item_tip, PoseNoise())
    assert found is not None
    return found


@settings(deadline=None, max_examples=60)
@given(st.one_of(boxes, cylinders, spheres), ways)
def test_both_pads_meet_the_item_square_on(shape: Shape, way_in: Array) -> None:
    """The oracle shoots lines through the pads: what they hit first and last, how far apart, how steep."""
    for pinch in found(shape, way_in)[::7]:
        assert is_pose(pinch.T_item_tip)
        pads = pads_on(shape, pinch.T_item_tip, GRIPPER)
        assert pads is not None
        assert_allclose(pads.width, pinch.width, atol=2e-4)  # between two lines a round side stands out
        assert pads.steepest <= np.arctan(GRIPPER.limits.friction)
        assert_allclose(pads.points.mean(axis=0), 0.0, atol=PAD[0] / 2)


@settings(deadline=None, max_examples=60)
@given(st.one_of(boxes, cylinders, spheres), ways)
def test_the_hand_comes_along_the_way_in(shape: Shape, way_in: Array) -> None:
    for pinch in found(shape, way_in):
        assert pinch.T_item_tip[:3, 2] @ way_in >= np.cos(MAX_TILT + max(FAN)) - 1e-9


@settings(deadline=None, max_examples=40)
@given(boxes, ways)
def test_what_touches_of_a_pad_lies_on_both_faces(shape: Shape, way_in: Array) -> None:
    for pinch in found(shape, way_in)[::5]:
        touching = patch(shape, pinch.face, pinch.T_item_tip, PAD)
        assert touching is not None
        R, half = pinch.T_item_tip[:3, :3], shape.extents / 2
        for sx in (-0.5, 0.5):
            for sz in (-0.5, 0.5):
                p = pinch.T_item_tip[:3, 3] + sx * touching[0] * R[:, 0] + sz * touching[1] * R[:, 2]
                across = np.delete(np.abs(p) - half, "xyz".index(pinch.face))
                assert (across <= 1e-9).all()


@settings(deadline=None, max_examples=40)
@given(st.one_of(boxes, cylinders, spheres), ways, st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6))
def test_the_planner_trusts_the_pads_with_no_more_than_the_verifier(
    shape: Shape, way_in: Array, wrench: list[float]
) -> None:
    """At 0.8 of the limits of the one the other still accepts, but where it sees a smaller part of a pad."""
    w = np.array(wrench) * (40.0, 40.0, 40.0, 0.3, 0.3, 0.3)
    for pinch in found(shape, way_in, 0)[:3]:
        if patch(shape, pinch.face, pinch.T_item_tip, PAD) != PAD:
            continue
        pads = pads_on(shape, pinch.T_item_tip, GRIPPER)
        assert pads is not None
        planned = float(limits(shape, pinch).ratio(w))
        assert pads.ratio(w[None], GRIPPER)[0] <= planned / 0.8 + 1e-9


def test_a_box_is_pinched_by_every_pair_of_faces_across_the_way_in() -> None:
    shape = Shape(ShapeKind.BOX, (0.1, 0.06, 0.03))
    assert {p.face for p in found(shape, np.array([0.0, 0.0, -1.0]))} == {"x", "y"}
    assert {p.width for p in found(shape, np.array([0.0, 0.0, -1.0]))} == {0.1, 0.06}
    assert {p.face for p in found(shape, np.array([1.0, 0.0, 0.0]))} == {"y", "z"}


def test_a_standing_cylinder_is_pinched_all_around_and_a_lying_one_across() -> None:
    shape = Shape(ShapeKind.CYLINDER, (0.03, 0.1))
    standing = found(shape, np.array([0.0, 0.0, -1.0]))
    assert len({tuple(np.round(p.T_item_tip[:3, 1], 3)) for p in standing}) >= 12
    lying = [p for p in found(shape, np.array([1.0, 0.0, 0.0])) if p.face == "mantle"]
    assert lying and all(abs(p.T_item_tip[2, 1]) < 1e-9 for p in lying)
    assert {p.face for p in found(shape, np.array([1.0, 0.0, 0.0]))} == {"mantle", "z"}


@pytest.mark.parametrize("face", ["x", "y"])
def test_pads_that_are_half_beside_a_face_bear_less(face: str) -> None:
    shape = Shape(ShapeKind.BOX, (0.05, 0.05, 0.0095))
    of_face = [p for p in found(shape, np.array([0.0, 0.0, -1.0])) if p.face == face]
    assert of_face
    for pinch in of_face:
        found_limits = limits(shape, pinch)
        assert found_limits.pad[1] <= 0.0095 and found_limits.max_twist < GRIPPER.limits.max_twist


def test_beside_the_middle_of_a_ball_the_cones_are_left() -> None:
    """Pads 15 to 35 mm beside the middle of a ball of 30 mm meet it at a slope of 30 degrees and more."""
    ball = Shape(ShapeKind.SPHERE, (0.03,))
    beside = pads_on(ball, pose((0.025, 0.0, 0.0)), GRIPPER)
    assert beside is not None and beside.steepest > np.arctan(0.5)
    middle = pads_on(ball, np.eye(4), GRIPPER)
    assert middle is not None and middle.steepest < np.radians(15.0)
    assert pads_on(ball, pose((0.05, 0.0, 0.0)), GRIPPER) is None


@given(st.sampled_from(["x", "y", "z", "mantle", "sphere"]), st.integers(0, 2**31))
def test_flattened_pads_close_along_a_normal_midway(face: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    T = pose(rng.normal(size=3), R=rotation_from_vector(rng.normal(size=3)))
    flat = flattened(face, T)
    y, middle = flat[:3, 1], flat[:3, 3]
    assert is_pose(flat)
    assert_allclose(flattened(face, flat), flat, atol=1e-12)
    assert y @ T[:3, 1] >= 0.0  # closes the same way round
    if face in ("x", "y", "z"):
        k = "xyz".index(face)
        assert abs(y[k]) == pytest.approx(1.0) and middle[k] == 0.0
        np.testing.assert_array_equal(np.delete(middle, k), np.delete(T[:3, 3], k))
    elif face == "mantle":
        assert y[2] == 0.0 and (middle[:2] == 0.0).all() and middle[2] == T[2, 3]
    else:
        assert (middle == 0.0).all()
