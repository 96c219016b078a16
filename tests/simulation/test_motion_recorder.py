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


def played(recorder: MotionRecorder, joint: str, t: float, duration: float, gain: float) -> None:
    """Enter a world at a time, and let its joint move to gain * time of the trial."""
    moving = world(joint)
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
    ends = begins + round(second / LOOK_TIME) * LOOK_TIME
    for name, start, end, gain in (("a", 0.0, first, 1.0), ("b", begins, ends, 2.0)):
        column = joints[:, recorder.joint_names.index(name)]
        moving = (times >= start) & (times <= min(end, times[-1]))
        # The other arm's samples are up to one of its own looks old.
        assert column[moving] == pytest.approx(
            gain * np.minimum(times[moving], end), abs=2.1 * gain * LOOK_TIME
        )
        after = times > end + 2 * LOOK_TIME
        assert column[after] == pytest.approx(gain * end, abs=2.1 * gain * LOOK_TIME)
    assert times[-1] >= max(first, ends) - 2 * LOOK_TIME


def test_a_world_of_the_same_arm_is_in_place_of_what_the_one_before_showed_of_later_times() -> None:
    recorder = MotionRecorder({"a": 0.0})
    played(recorder, "a", 0.0, 2.0, 1.0)
    played(recorder, "a", 1.0, 0.5, 5.0)
    recorder.finish()
    at = np.array(recorder.joints)[:, 0]
    times = np.array(recorder.times)
    assert times[-1] == pytest.approx(1.5, abs=LOOK_TIME)
    assert at[times >= 1.0] == pytest.approx(5.0 * times[times >= 1.0])
