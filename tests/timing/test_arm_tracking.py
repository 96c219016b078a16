"""An arm that follows a belt: its tool is where the planned motion has it, displaced along the belt."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.errors import Reason
from pickcli.geometry import rotation_angle
from pickcli.kinematics.arm import Arm
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.arm_tracking import ArmTracking
from pickcli.timing.line_tracking import TrackedMotion

ALONG = np.array([0.0, -1.0, 0.0])
RAMP, T_MET, END = 0.4, 1.0, 2.2  # s


def tracking(speed: float = 0.1, sideways: float = 0.0) -> ArmTracking:
    """A Panda that lowers its hand a little, at rest before and after."""
    cell = load_cell("panda_table")
    arm, state = Arm(cell.robot), cell.robot.tool.default_state
    q = cell.home.q + np.array([sideways, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    t = np.array([0.0, RAMP, T_MET, 1.4, END])
    Q = q + np.outer([0.0, 0.0, 1.0, 1.0, 1.0], [0.0, 0.1, 0.0, -0.05, 0.0, 0.1, 0.0])
    still = np.zeros_like(Q)
    relative = Trajectory(arm.names, t, Q, still, still.copy())
    tracked = TrackedMotion(0, speed, 0.0, RAMP, END - RAMP, END)
    return ArmTracking(arm, state, ALONG, relative, tracked, T_MET)


@pytest.mark.parametrize("speed", [0.05, 0.1, 0.2])
def test_the_tool_is_displaced_along_the_belt_at_every_instant(speed: float) -> None:
    given = tracking(speed)
    followed = given.followed()
    assert isinstance(followed, Trajectory)
    times = np.linspace(0.0, END, 2201)
    shift = given.tracked.offset(times)[0] - given.tracked.offset(np.array([T_MET]))[0]
    for t, by, q in zip(times, shift, followed.sample(times), strict=True):
        wanted = given.arm.tip(given.relative.sample(t)[0], given.tool_state)
        tip = given.arm.tip(q, given.tool_state)
        assert np.linalg.norm(tip[:3, 3] - wanted[:3, 3] - by * ALONG) < 1e-6
        assert rotation_angle(tip[:3, :3].T @ wanted[:3, :3]) < 1e-6


def test_both_motions_coincide_at_the_contact_and_the_ends_are_at_rest() -> None:
    given = tracking()
    followed = given.followed()
    assert isinstance(followed, Trajectory)
    assert followed.sample(T_MET)[0] == pytest.approx(given.relative.sample(T_MET)[0], abs=1e-9)
    for k in (1, 2):
        assert not followed.sample(np.array([0.0, END]), k).any()


def test_velocities_and_accelerations_are_those_of_the_positions() -> None:
    followed = tracking(0.2).followed()
    assert isinstance(followed, Trajectory)
    times, h = followed.times[1:-1], 1e-4
    for k in (0, 1):
        slope = (followed.sample(times + h, k) - followed.sample(times - h, k)) / (2 * h)
        assert np.abs(slope - followed.sample(times, k + 1)).max() < 2e-3
    jerk = np.abs(followed.sample(np.linspace(0.0, END, 4001), 3)).max()
    assert jerk < 60.0  # what ramps and lines ask for: points that contradict each other would shake


def test_an_end_that_the_arm_does_not_reach_is_told() -> None:
    told = tracking(1.0, sideways=-0.8).followed()
    assert isinstance(told, Reason) and told.what == "out of reach"
    assert told.where.startswith("following the belt at ")
