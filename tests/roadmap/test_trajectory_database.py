"""The trajectory database answers in both directions."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.roadmap.trajectory_database import CoarseMotion, PayloadClass, TrajectoryDatabase
from support.stored_samples import database


def test_lookup_by_name_and_payload() -> None:
    found = database().lookup("a", "b", PayloadClass.EMPTY)
    assert found is not None and found.duration == 2.0
    assert database().lookup("a", "c", PayloadClass.EMPTY) is None
    assert database().lookup("b", "c", PayloadClass.CUBE) is None


def test_the_way_back_is_the_way_there_in_reverse() -> None:
    there = _found(database(), "a", "b")
    back = _found(database(), "b", "a")
    assert (back.key.start, back.key.goal) == ("b", "a")
    np.testing.assert_array_equal(back.path.waypoints, there.path.waypoints[::-1])
    assert there.trajectory is not None and back.trajectory is not None
    t = np.linspace(0.0, 2.0, 41)
    for derivative, sign in ((0, 1), (1, -1), (2, 1)):
        forwards = there.trajectory.sample(2.0 - t, derivative)
        np.testing.assert_allclose(back.trajectory.sample(t, derivative), sign * forwards, atol=1e-9)


def test_lookup_by_configuration_is_exact() -> None:
    stored = _found(database(), "a", "b")
    q0, q1 = stored.path.start, stored.path.end
    found = database().between(q1, q0, PayloadClass.EMPTY)
    assert found is not None and found.key.start == "b"
    assert database().between(q0, q1 + 1e-12, PayloadClass.EMPTY) is None


def test_iteration_gives_what_was_put_in() -> None:
    motions = list(database())
    again = TrajectoryDatabase.of(database().joint_names, motions)
    assert again.keys == database().keys
    np.testing.assert_array_equal(again.waypoints, database().waypoints)


def test_motions_without_time_are_not_taken() -> None:
    untimed = CoarseMotion(
        database().keys[0], database().tool_states[0], _found(database(), "a", "b").path, 2.0
    )
    with pytest.raises(ValueError, match="timed"):
        TrajectoryDatabase.of(database().joint_names, [untimed])


def test_an_empty_database_is_one() -> None:
    empty = TrajectoryDatabase.of(("x",), [])
    assert len(empty) == 0 and empty.lookup("a", "b", PayloadClass.EMPTY) is None


def _found(stored: TrajectoryDatabase, start: str, goal: str) -> CoarseMotion:
    found = stored.lookup(start, goal, PayloadClass.EMPTY)
    assert found is not None
    return found
