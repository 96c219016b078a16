"""Geometry of the key waypoints."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cartesian.key_waypoints import pick_poses
from pickcli.cartesian.line import line
from pickcli.geometry import inverse, is_pose, pose, rotation_angle
from support.front_places import front_place

BIN = front_place()
FORWARD = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])


@given(st.floats(0.05, 0.4), st.floats(-0.1, 0.1), st.floats(-0.5, 0.5), st.floats(0.0, 0.006))
def test_contact_lies_beyond_the_surface_by_the_overtravel(
    x: float, y: float, yaw: float, over: float
) -> None:
    T_world_item = BIN.T_carrier_place @ pose([x, y, 0.03], rpy=[0, 0, yaw])
    T_item_tip = pose([-0.04, 0.0, 0.0], R=FORWARD)
    poses = pick_poses(BIN.T_carrier_place, T_world_item, T_item_tip, 0.04, over)
    surface = T_world_item @ T_item_tip
    assert np.allclose(poses.contact[:3, 3] - surface[:3, 3], over * surface[:3, 2])
    assert np.allclose(poses.approach[:3, 3] - surface[:3, 3], -0.04 * surface[:3, 2])
    assert (inverse(BIN.T_carrier_place) @ poses.preapproach)[0, 3] <= -0.06 + 1e-9
    moved = poses.preapproach[:3, 3] - poses.approach[:3, 3]
    assert np.allclose(moved[1:], 0.0)  # straight along the bin's axis
    assert all(is_pose(T) for T in (poses.preapproach, poses.approach, poses.touch, poses.contact))


def test_a_line_includes_both_ends_and_turns_evenly() -> None:
    T_a, T_b = pose([0, 0, 0]), pose([0.1, 0.0, 0.0], rpy=[0.0, 0.0, 0.4])
    poses = line(T_a, T_b)
    assert np.allclose(poses[0], T_a) and np.allclose(poses[-1], T_b)
    steps = [rotation_angle(a[:3, :3].T @ b[:3, :3]) for a, b in pairwise(poses)]
    assert max(steps) == pytest.approx(min(steps), abs=1e-9)
    assert max(steps) <= np.radians(2.0) + 1e-9
