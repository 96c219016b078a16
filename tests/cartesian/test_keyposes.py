"""Geometry of the key waypoints."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cartesian.keyposes import LIP_DISTANCE, RETREAT_DISTANCE, LiftPoses, lift_options, pick_poses
from pickcli.cartesian.line import line
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.station import Bin
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, is_pose, pose, rotation_angle, transform_points

BIN = Bin(
    "bin_B", pose([0.0, 0.0, 1.5536]), 0.2988, 0.2319, (-0.1494, 0.1494), 0.4361, -0.0108, -0.0297, 0.21, 0.255, 0.236
)  # fmt: skip
FORWARD = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


def corners(T: Array, extents: Array) -> Array:
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return transform_points(T, signs * extents / 2)


@given(st.floats(0.05, 0.4), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5), st.floats(0.0, 0.006))
def test_contact_lies_beyond_the_surface_by_the_overtravel(x: float, y: float, yaw: float, over: float) -> None:
    T_world_item = BIN.T_pod_bin @ pose([x, y, 0.03], rpy=[0, 0, yaw])
    T_item_tip = pose([-0.04, 0.0, 0.0], R=FORWARD)
    poses = pick_poses(BIN.T_pod_bin, T_world_item, T_item_tip, 0.04, over)
    surface = T_world_item @ T_item_tip
    assert np.allclose(poses.contact[:3, 3] - surface[:3, 3], over * surface[:3, 2])
    assert np.allclose(poses.approach[:3, 3] - surface[:3, 3], -0.04 * surface[:3, 2])
    assert (inverse(BIN.T_pod_bin) @ poses.preapproach)[0, 3] <= -0.06 + 1e-9
    moved = poses.preapproach[:3, 3] - poses.approach[:3, 3]
    assert np.allclose(moved[1:], 0.0)  # straight along the bin's axis
    assert all(is_pose(T) for T in (poses.preapproach, poses.approach, poses.touch, poses.contact))


@given(st.floats(0.08, 0.35), st.floats(-0.08, 0.08), st.floats(0.02, 0.12), st.floats(-3.1, 3.1))
def test_the_held_item_passes_the_mouth_and_ends_outside(x: float, y: float, size: float, yaw: float) -> None:
    extents = np.array([size, size * 0.7, size * 0.9])
    T_item = BIN.T_pod_bin @ pose([x, y, -0.0297 + extents[2] / 2], rpy=[0, 0, yaw])
    contact = T_item.copy()
    options = lift_options(BIN, BIN.T_pod_bin, T_item, Shape(ShapeKind.BOX, tuple(extents)), contact, 0.03)
    assert isinstance(options, tuple) and options
    for option in options:
        assert isinstance(option, LiftPoses)
        at_lift = transform_points(inverse(BIN.T_pod_bin), corners(option.lift @ inverse(contact) @ T_item, extents))
        assert at_lift[:, 2].min() >= LIP_DISTANCE - 1e-9
        assert at_lift[:, 2].max() <= BIN.mouth_height - LIP_DISTANCE + 1e-9
        assert np.abs(at_lift[:, 1]).max() <= BIN.mouth_width / 2 - LIP_DISTANCE + 1e-9
        out = transform_points(inverse(BIN.T_pod_bin), corners(option.retreat @ inverse(contact) @ T_item, extents))
        assert out[:, 0].max() <= -RETREAT_DISTANCE + 1e-9
        assert np.linalg.norm(option.freed[:3, 3] - contact[:3, 3]) <= 0.03 + 1e-9


def test_too_tall_an_item_is_refused_with_its_size() -> None:
    T_item = BIN.T_pod_bin @ pose([0.2, 0.0, 0.08])
    reason = lift_options(BIN, BIN.T_pod_bin, T_item, Shape(ShapeKind.BOX, (0.1, 0.1, 0.23)), T_item, 0.03)
    assert isinstance(reason, Reason)
    assert "100 x 230 mm" in reason.detail


def test_a_line_includes_both_ends_and_turns_evenly() -> None:
    T_a, T_b = pose([0, 0, 0]), pose([0.1, 0.0, 0.0], rpy=[0.0, 0.0, 0.4])
    poses = line(T_a, T_b)
    assert np.allclose(poses[0], T_a) and np.allclose(poses[-1], T_b)
    steps = [rotation_angle(a[:3, :3].T @ b[:3, :3]) for a, b in zip(poses, poses[1:], strict=False)]
    assert max(steps) == pytest.approx(min(steps), abs=1e-9)
    assert max(steps) <= np.radians(2.0) + 1e-9
