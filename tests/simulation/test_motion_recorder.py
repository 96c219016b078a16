"""What the recorder keeps of worlds that follow each other, and of worlds at the same time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.simulation.motion_recorder import LOOK_TIME, MotionRecorder


def world(joint: str, vacuum: float = 0.0) -> Any:
    """A world without items, in which one joint is where its time is."""
    return SimpleNamespace(
        t=0.0,
        scene=SimpleNamespace(items=()),
        robot=SimpleNamespace(moving_joints=(joint,)),
        joints=np.zeros(1),
        tool=SimpleNamespace(pressure=vacuum),
        held=None,
        observer=None,
    )


def played(
    recorder: MotionRecorder, joint: str, t: float, duration: float, gain: float, vacuum: float = 0.0
) -> None:
    """Enter a world at a time, and let its joint move to gain * time of the trial."""
    moving = world(joint, vacuum)
    moving.joints = np.array([gain * t])
    recorder.enter(moving, t)
    for _ in range(round(duration / LOOK_TIME)):
        moving.t += LOOK_TIME
        moving.joints = np.array([gain * (t + moving.t)])
        recorder.look(moving)


@given(st.floats(0.0, 3.0), st.floats(0.3, 3.0), st.floats(0.3, 3.0))
def test_arms_that_move_in_worlds_of_their_own_at_the_same_time_are_both_recorded(
    begins: float, first: float, second: float
) -> None:
    recorder = MotionRecorder({"a": 0.0, "b": 0.0})
    played(recorder, "a", 0.0, first, 1.0)
    played(recorder, "b", begins, second, 2.0)
    recorder.finish()
    times, joints = np.array(recorder.times), np.array(recorder.joints)
    assert (np.diff(times) > 0.0).all() and len(times) == len(joints) == len(recorder.vacuum)
    ends = [start + round(lasts / LOOK_TIME) * LOOK_TIME for start, lasts in ((0.0, first), (begins, second))]
    for name, start, end, gain in (("a", 0.0, ends[0], 1.0), ("b", begins, ends[1], 2.0)):
        column = joints[:, recorder.joint_names.index(name)]
        moving = (times >= start) & (times <= end - LOOK_TIME)
        assert column[moving] == pytest.approx(gain * times[moving], abs=1e-9)  # at the time of each sample
        after = times > end + 2 * LOOK_TIME
        assert column[after] == pytest.approx(gain * end, abs=2.1 * gain * LOOK_TIME)
    assert times[-1] >= max(ends) - 2 * LOOK_TIME


@given(st.floats(0.0, 1.9))
def test_the_vacuum_of_an_arm_is_recorded_while_another_one_without_moves(begins: float) -> None:
    recorder = MotionRecorder({"a": 0.0, "b": 0.0})
    played(recorder, "a", 0.0, 2.0, 1.0, vacuum=5e4)
    played(recorder, "b", begins, 1.0, 2.0)
    recorder.finish()
    held = np.array(recorder.times) <= 2.0 - 2 * LOOK_TIME
    assert (np.array(recorder.vacuum)[held] == 5e4).all()


def test_a_world_of_the_same_arm_is_in_place_of_what_the_one_before_showed_of_later_times() -> None:
    recorder = MotionRecorder({"a": 0.0})
    played(recorder, "a", 0.0, 2.0, 1.0)
    played(recorder, "a", 1.0, 0.5, 5.0)
    recorder.finish()
    at = np.array(recorder.joints)[:, 0]
    times = np.array(recorder.times)
    assert times[-1] == pytest.approx(1.5, abs=LOOK_TIME)
    assert at[times >= 1.0] == pytest.approx(5.0 * times[times >= 1.0])
