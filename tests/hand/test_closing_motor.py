"""The closing motor: its current is the torque, its speed is limited, both joints of a finger move."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.hand.closing_motor import ClosingMotor
from support.belt_hands import HAND

DRIVE, DT = HAND.drive, 2e-3


def test_against_blocked_fingers_the_current_is_the_torque() -> None:
    motor = ClosingMotor(DRIVE, 0.1, wanted=DRIVE.speed, set_point=3.0)
    blocked = np.array([[0.1, 0.0], [0.1, 0.0]])
    for _ in range(2000):
        torques = motor.advance(blocked, np.zeros((2, 2)), DT)
    assert motor.current == 3.0
    assert abs(motor.rate) < 1e-3
    share = 3.0 * DRIVE.torque_constant / 2
    assert torques[:, 0] == pytest.approx([share, share], rel=1e-3)
    assert torques[:, 1] == pytest.approx([DRIVE.hinge_ratio * share - DRIVE.spring] * 2, rel=1e-3)
    assert motor.angle - 0.1 == pytest.approx(share / DRIVE.stiffness, rel=1e-2)


def test_one_blocked_finger_takes_all_while_the_other_follows() -> None:
    motor = ClosingMotor(DRIVE, 0.0, wanted=DRIVE.speed, set_point=3.0)
    for _ in range(2000):
        followed = np.array([[0.0, 0.0], [motor.angle, 0.0]])
        torques = motor.advance(followed, np.array([[0.0, 0.0], [motor.rate, 0.0]]), DT)
    assert torques[:, 0] == pytest.approx([3.0 * DRIVE.torque_constant, 0.0], abs=2e-2)


def test_free_fingers_close_at_the_speed_with_little_current() -> None:
    motor = ClosingMotor(DRIVE, -0.5, wanted=DRIVE.speed, set_point=3.0)
    for _ in range(200):
        fingers = np.array([[motor.angle, 0.0]] * 2)
        motor.advance(fingers, np.array([[motor.rate, 0.0]] * 2), DT)
    assert motor.rate == pytest.approx(DRIVE.speed, rel=1e-3)
    assert abs(motor.current) < 0.05
