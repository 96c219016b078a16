"""Searches over motions, for a point among boxes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.kernel import JointState, ParabolicLimits, ParabolicTrajectory, steer_min_time
from pickcli.path_planning.state_space import JointSpace
from pickcli.trajopt.collision_descent import CollisionDepth, descend_collisions
from pickcli.trajopt.parabolic_segment import resting_segment, straight_segment
from pickcli.trajopt.time_shortcutting import shortcut_time
from pickcli.trajopt.trajectory_validator import TrajectoryValidator
from support.fake_validator import FakeValidator

PACE = ParabolicLimits(np.ones(2), np.full(2, 4.0), np.full(2, 80.0), 0.05)
START, GOAL = np.array([-1.5, 0.0]), np.array([1.5, 0.0])


@dataclass(frozen=True)
class Disc(FakeValidator):
    """Free is what lies farther than a radius from the origin of a plane."""

    radius: float

    def clearances(self, Q: Array) -> Array:
        return np.asarray(np.linalg.norm(Q, axis=1) - self.radius)

    def is_valid(self, q: Array) -> bool:
        return bool(self.clearances(q[None])[0] > 0.0)

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        tubes = np.zeros_like(Q[1:]) if slack is None else slack
        for i, (a, b, s) in enumerate(zip(Q[:-1], Q[1:], tubes, strict=True)):
            way = (b - a) @ (b - a)
            u = float(np.clip(-a @ (b - a) / way, 0.0, 1.0)) if way > 0.0 else 0.0
            if np.linalg.norm(a + u * (b - a)) <= self.radius + np.linalg.norm(s):
                return i
        return -1


SPACE = JointSpace(("a", "b"), np.full(2, -2.0), np.full(2, 2.0), PACE.velocity, PACE.acceleration)


def proof(radius: float) -> TrajectoryValidator:
    return TrajectoryValidator(Disc(radius), SPACE)


def assert_avoids(motion: ParabolicTrajectory, radius: float) -> None:
    t = np.linspace(0.0, motion.duration, 1000)
    Q = np.array([motion.state(float(x)).q for x in t])
    assert np.linalg.norm(Q, axis=1).min() > radius
    np.testing.assert_allclose(Q[[0, -1]], [START, GOAL], atol=1e-9)


def least() -> float:
    segment = steer_min_time(JointState.at_rest(START), JointState.at_rest(GOAL), PACE, np.inf)
    assert segment is not None
    return segment.duration


@pytest.mark.parametrize("seed", range(3))
def test_what_is_in_the_way_of_one_joint_is_avoided_by_the_other_in_no_more_time(seed: int) -> None:
    """The first joint needs all of the time; the second has nothing to do but get out of the way."""
    motion = descend_collisions(
        proof(0.4),
        CollisionDepth(Disc(0.4).clearances, 0.01, SPACE),
        PACE,
        (START, GOAL),
        least(),
        seed=seed,
        iterations=800,
    )
    assert motion is not None and motion.duration == pytest.approx(least())
    assert_avoids(motion, 0.4)


def test_where_there_is_not_the_time_there_is_no_motion() -> None:
    """The second joint cannot get 1.4 out of the way and back in the time of the first."""
    assert (
        descend_collisions(
            proof(1.45),
            CollisionDepth(Disc(1.45).clearances, 0.01, SPACE),
            PACE,
            (START, GOAL),
            least(),
            seed=0,
            iterations=200,
        )
        is None
    )


@pytest.mark.parametrize("seed", range(3))
def test_a_detour_with_a_stop_becomes_as_quick_as_the_line(seed: int) -> None:
    corner = np.array([0.0, 1.2])
    segments = (
        straight_segment(START, corner, PACE),
        resting_segment(corner, PACE.pause),
        straight_segment(corner, GOAL, PACE),
    )
    slow = ParabolicTrajectory(segments)
    quick = shortcut_time(proof(0.4), PACE, slow, least(), seed=seed, iterations=600)
    assert quick.total(PACE) <= 1.05 * (least() + PACE.pause) < slow.total(PACE)
    assert_avoids(quick, 0.4)
    again = shortcut_time(proof(0.4), PACE, slow, least(), seed=seed, iterations=600)
    assert again.duration == quick.duration and len(again.segments) == len(quick.segments)


def test_legs_outside_of_the_joint_limits_are_not_free() -> None:
    inside, outside = np.array([1.0, 1.0]), np.array([1.0, 2.1])
    assert proof(0.1).is_valid((straight_segment(inside, np.array([1.0, 1.9]), PACE),))
    assert not proof(0.1).is_valid((straight_segment(inside, outside, PACE),))
