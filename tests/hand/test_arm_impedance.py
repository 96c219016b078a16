"""Cartesian impedance of an arm: spring, damper and thresholds, against sums by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.geometry import pose, rotation_rpy
from pickcli.hand.arm_impedance import LIMIT_DAMPING, LIMIT_ROOM, LIMIT_STIFFNESS, ArmImpedance, limit_efforts
from support.belt_hands import HAND
from support.commissions import belts_booth

WRIST = HAND.wrist
TURNED = rotation_rpy(0.1, -0.2, 0.7)
EYE = np.eye(6)  # of an arm whose joints move the hand along and about the axes of the world


def held_at(*at: float) -> ArmImpedance:
    """An impedance that wants the hand where it is."""
    impedance = ArmImpedance(WRIST, 4.0)
    impedance.hold(pose(at, R=TURNED))
    return impedance


def test_the_pose_that_is_held_needs_no_force_but_the_weight() -> None:
    impedance, gravity = held_at(0.4, 0.1, 0.6), np.arange(6.0)
    efforts = impedance.efforts(pose((0.4, 0.1, 0.6), R=TURNED), EYE, np.zeros(6), gravity)
    assert efforts == pytest.approx(gravity, abs=1e-9)
    assert impedance.wanted[3:] == pytest.approx([0.7, -0.2, 0.1])


def test_it_is_soft_in_the_horizontal_plane_only_when_that_is_wanted() -> None:
    impedance, at = held_at(0.0, 0.0, 0.0), pose((0.01, 0.0, 0.02), R=TURNED)
    stiff = impedance.efforts(at, EYE, np.zeros(6), np.zeros(6))
    impedance.is_level_soft = True
    soft = impedance.efforts(at, EYE, np.zeros(6), np.zeros(6))
    assert stiff[[0, 2]] == pytest.approx([-0.01 * WRIST.stiff, -0.02 * WRIST.stiff])
    assert soft[[0, 2]] == pytest.approx([-0.01 * WRIST.level, -0.02 * WRIST.stiff])
    assert impedance.lifting == pytest.approx(-0.02 * WRIST.stiff)


def test_a_turn_is_opposed_about_its_axis_and_motion_by_the_stated_damping() -> None:
    impedance = held_at(0.0, 0.0, 0.0)
    turned = pose(R=rotation_rpy(0.0, 0.0, 0.05) @ TURNED)
    assert impedance.efforts(turned, EYE, np.zeros(6), np.zeros(6))[3:] == pytest.approx(
        [0.0, 0.0, -0.05 * WRIST.turning], abs=1e-9
    )
    rates = np.array([0.1, 0.0, 0.0, 0.0, 0.0, 0.0])
    still = impedance.efforts(pose(R=TURNED), EYE, rates, np.zeros(6))
    assert still[0] == pytest.approx(-2.0 * WRIST.damping * np.sqrt(WRIST.stiff * 4.0) * 0.1)


def test_a_force_beyond_the_threshold_is_an_overload() -> None:
    impedance = held_at(0.0, 0.0, 0.0)
    for over, is_overloaded in ((0.99, False), (1.01, True)):
        off = over * WRIST.most_force / WRIST.stiff
        impedance.efforts(pose((0.0, off, 0.0), R=TURNED), EYE, np.zeros(6), np.zeros(6))
        assert impedance.is_overloaded == is_overloaded


def test_motion_that_does_not_move_the_hand_is_damped_without_a_force_on_it() -> None:
    """A seventh joint that the hand does not feel."""
    impedance, J = held_at(0.0, 0.0, 0.0), np.hstack([EYE, np.zeros((6, 1))])
    rates = np.array([0.0] * 6 + [0.5])
    efforts = impedance.efforts(pose(R=TURNED), J, rates, np.zeros(7))
    assert efforts[:6] == pytest.approx(np.zeros(6), abs=1e-9)
    assert efforts[6] < 0.0


def test_joints_are_pushed_back_only_near_their_limits() -> None:
    limits = belts_booth().robot.limits
    q, inertia = 0.5 * (limits.lower + limits.upper), np.full(7, 2.0)
    q[0], q[1], q[2] = limits.upper[0] - 0.03, limits.lower[1] + 0.03, limits.upper[2] - LIMIT_ROOM - 0.001
    damping = 2.0 * LIMIT_DAMPING * np.sqrt(LIMIT_STIFFNESS * 2.0)
    efforts = limit_efforts(limits, q, np.full(7, 0.1), inertia)
    push = LIMIT_STIFFNESS * (LIMIT_ROOM - 0.03)
    assert efforts[:2] == pytest.approx([-push - 0.1 * damping, push - 0.1 * damping])
    assert efforts[2:] == pytest.approx(np.zeros(5), abs=1e-9)
