"""Laws of SE(3): group axioms, and that every representation comes back from every other."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from pickcli.geometry import (
    Array,
    cross,
    from_quaternion,
    inverse,
    is_pose,
    length,
    perpendiculars,
    pose,
    rotation_axis_angle,
    rotation_rpy,
    rotation_vector,
    skew,
    to_quaternion,
    to_rpy,
    transform_points,
)

angles = st.floats(-np.pi, np.pi)
lengths = st.floats(-5.0, 5.0)
vectors = st.tuples(lengths, lengths, lengths)
rpys = st.tuples(angles, angles, angles)
poses = st.builds(lambda xyz, rpy: pose(xyz, rpy=rpy), vectors, rpys)
half_turns = st.builds(
    lambda rpy, error: rotation_axis_angle(rotation_rpy(*rpy)[:, 0], np.pi + error),
    rpys,
    st.sampled_from([0.0, 1e-15, -1e-15, 1e-9, -1e-9, 1e-5]),
)
rotations = st.one_of(st.builds(lambda rpy: rotation_rpy(*rpy), rpys), half_turns)


@given(poses, poses, poses)
def test_poses_form_a_group(T_a: Array, T_b: Array, T_c: Array) -> None:
    assert_allclose((T_a @ T_b) @ T_c, T_a @ (T_b @ T_c), atol=1e-12)
    assert_allclose(T_a @ inverse(T_a), np.eye(4), atol=1e-12)
    assert_allclose(inverse(T_a @ T_b), inverse(T_b) @ inverse(T_a), atol=1e-12)
    assert is_pose(T_a @ T_b)


@given(rotations)
def test_quaternions_come_back_even_at_half_turns(R: Array) -> None:
    q = to_quaternion(R)
    assert abs(float(np.linalg.norm(q)) - 1.0) < 1e-12
    assert q[3] >= 0.0
    assert_allclose(from_quaternion(q), R, atol=1e-12)


@given(rotations, rotations)
def test_a_product_of_quaternions_is_a_product_of_matrices(R_a: Array, R_b: Array) -> None:
    (x, y, z, w), (X, Y, Z, W) = to_quaternion(R_a), to_quaternion(R_b)
    product = (
        w * X + x * W + y * Z - z * Y,
        w * Y - x * Z + y * W + z * X,
        w * Z + x * Y - y * X + z * W,
        w * W - x * X - y * Y - z * Z,
    )
    assert_allclose(from_quaternion(product), R_a @ R_b, atol=1e-12)


@given(rotations)
def test_the_rotation_vector_turns_back_into_the_matrix(R: Array) -> None:
    v = rotation_vector(R)
    angle = float(np.linalg.norm(v))
    assert angle <= np.pi + 1e-9
    axis = v / angle if angle > 0.0 else np.array([1.0, 0.0, 0.0])
    assert_allclose(rotation_axis_angle(axis, angle), R, atol=1e-7)


@given(rpys)
def test_roll_pitch_yaw_turn_about_fixed_axes(rpy: tuple[float, float, float]) -> None:
    roll, pitch, yaw = rpy
    one_by_one = (
        rotation_axis_angle((0, 0, 1), yaw)
        @ rotation_axis_angle((0, 1, 0), pitch)
        @ rotation_axis_angle((1, 0, 0), roll)
    )
    assert_allclose(rotation_rpy(roll, pitch, yaw), one_by_one, atol=1e-12)


@given(rotations)
def test_roll_pitch_yaw_come_back_even_where_they_lock(R: Array) -> None:
    assert_allclose(rotation_rpy(*to_rpy(R)), R, atol=1e-8)


@given(st.tuples(angles, st.floats(-1.57, 1.57), angles))
def test_roll_pitch_yaw_are_found_as_they_were_stated(rpy: tuple[float, float, float]) -> None:
    turns = np.subtract(to_rpy(rotation_rpy(*rpy)), rpy) / (2 * np.pi)
    assert_allclose(turns, np.round(turns), atol=1e-12)


@given(rotations)
def test_perpendiculars_complete_a_direction_to_a_right_handed_frame(R: Array) -> None:
    for normal in (R[:, 2], *np.eye(3), *-np.eye(3)):
        assert is_pose(pose(R=np.column_stack([*perpendiculars(normal), normal])), tolerance=1e-12)


@given(vectors, vectors)
def test_the_cross_product_is_that_of_numpy(a: tuple[float, ...], b: tuple[float, ...]) -> None:
    np.testing.assert_array_equal(cross(np.array(a), np.array(b)), np.cross(a, b))


@given(st.integers(0, 2**31))
def test_the_matrix_of_a_vector_multiplies_by_its_cross_product(seed: int) -> None:
    a, b = np.random.default_rng(seed).normal(size=(2, 3))
    assert_allclose(skew(a) @ b, np.cross(a, b), atol=1e-12)


@given(st.lists(st.floats(-1e150, 1e150), min_size=1, max_size=9))
def test_the_length_is_that_of_numpy_to_the_last_bit(v: list[float]) -> None:
    assert length(np.array(v)) == np.linalg.norm(np.array(v))


@given(poses, st.lists(vectors, min_size=1, max_size=5))
def test_transformed_points_keep_their_distances(T: Array, points: list[tuple[float, float, float]]) -> None:
    p = np.array(points)
    moved = transform_points(T, p)
    assert_allclose(moved[0], (T @ np.append(p[0], 1.0))[:3], atol=1e-12)
    assert_allclose(np.linalg.norm(moved - moved[0], axis=1), np.linalg.norm(p - p[0], axis=1), atol=1e-9)


def test_what_is_no_pose_is_told_apart() -> None:
    mirrored = np.diag([1.0, 1.0, -1.0, 1.0])
    stretched = np.diag([1.1, 1.0, 1.0, 1.0])
    broken = np.full((4, 4), np.nan)
    assert is_pose(np.eye(4))
    assert not any(is_pose(T) for T in (mirrored, stretched, broken, np.eye(3)))
