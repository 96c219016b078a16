"""The motion of the tool frame while the cup turns, against its own differences."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.kinematics.arm import Arm
from pickcli.kinematics.tool_change import changing_tip
from support.tool_states import DOWN, STRAIGHT

DURATION = 0.3  # s


@pytest.mark.parametrize(("before", "after"), [(STRAIGHT, DOWN), (DOWN, STRAIGHT)])
def test_it_leads_from_one_state_to_the_other_from_rest_to_rest(
    arm: Arm, rng: np.random.Generator, before: object, after: object
) -> None:
    q = arm.random_seeds(rng, 1)[0]
    turn = changing_tip(arm, q, before, after, DURATION)  # type: ignore[arg-type]
    np.testing.assert_allclose(turn.poses[0], arm.tip(q, before), atol=1e-12)  # type: ignore[arg-type]
    np.testing.assert_allclose(turn.poses[-1], arm.tip(q, after), atol=1e-12)  # type: ignore[arg-type]
    for part in (turn.velocity, turn.angular_velocity, turn.acceleration, turn.angular_acceleration):
        assert np.abs(part[[0, -1]]).max() < 1e-9 < np.abs(part).max()


def test_its_velocities_and_accelerations_are_the_differences(arm: Arm, rng: np.random.Generator) -> None:
    q = arm.random_seeds(rng, 1)[0]
    turn = changing_tip(arm, q, STRAIGHT, DOWN, DURATION)
    step = DURATION / (len(turn.poses) - 1)
    p, R = turn.poses[:, :3, 3], turn.poses[:, :3, :3]
    inner = slice(1, -1)
    np.testing.assert_allclose(turn.velocity[inner], (p[2:] - p[:-2]) / (2 * step), atol=0.01)
    change = (p[2:] - 2 * p[1:-1] + p[:-2]) / step**2
    np.testing.assert_allclose(turn.acceleration[inner], change, atol=0.06)
    spin = (R[2:] - R[:-2]) / (2 * step) @ R[1:-1].transpose(0, 2, 1)
    found = np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], axis=1)
    np.testing.assert_allclose(turn.angular_velocity[inner], found, atol=0.03)
    faster = (turn.angular_velocity[2:] - turn.angular_velocity[:-2]) / (2 * step)
    np.testing.assert_allclose(turn.angular_acceleration[inner], faster, atol=0.6)
