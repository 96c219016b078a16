"""Bending a motion out of what it hits: when it is proven, when it gives up, which samples it looks at."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.kernel import ParabolicLimits
from pickcli.path_planning.state_space import JointSpace
from pickcli.trajopt.collision_descent import CollisionDepth, descend_collisions
from pickcli.trajopt.parabolic_segment import resting_segment
from pickcli.trajopt.trajectory_validator import TrajectoryValidator
from support.fake_validator import FakeValidator

PACE = ParabolicLimits(np.ones(2), np.full(2, 4.0), np.full(2, 80.0), 0.05)
SPACE = JointSpace(("a", "b"), np.full(2, -2.0), np.full(2, 2.0), PACE.velocity, PACE.acceleration)
ENDS = np.array([-1.5, 0.0]), np.array([1.5, 0.0])


@dataclass
class Grudging(FakeValidator):
    """Free everywhere, but only after it has been asked some times."""

    n_refused: int
    asked: list[bytes] = field(default_factory=list)

    def is_valid(self, q: Array) -> bool:
        return False

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        self.asked.append(Q.tobytes())
        return 0 if len(self.asked) <= self.n_refused else -1


def nothing_near(Q: Array) -> Array:
    return np.ones(len(Q))


def test_where_no_sample_is_deep_another_bend_may_be_proven() -> None:
    checker = Grudging(n_refused=5)
    proof, depth = TrajectoryValidator(checker, SPACE), CollisionDepth(nothing_near, 0.01, SPACE)
    motion = descend_collisions(proof, depth, PACE, ENDS, 4.0, seed=1, iterations=400)
    assert motion is not None and motion.duration == 4.0
    assert len(set(checker.asked)) == 6


def test_what_no_bend_improves_is_given_up() -> None:
    for nothing_helps in (nothing_near, lambda Q: -nothing_near(Q)):
        checker = Grudging(n_refused=10**9)
        assert (
            descend_collisions(
                TrajectoryValidator(checker, SPACE),
                CollisionDepth(nothing_helps, 0.01, SPACE),
                PACE,
                ENDS,
                4.0,
                seed=1,
                iterations=10**9,
            )
            is None
        )


@given(st.lists(st.integers(1, 40), min_size=1, max_size=5), st.integers(1, 60), st.integers(-2, 2))
def test_every_sample_has_a_depth_also_those_at_the_ends_of_legs(ticks: list[int], n: int, ulps: int) -> None:
    segments = tuple(resting_segment(ENDS[0], 0.004 * k) for k in ticks)
    times = np.linspace(0.0, sum(segment.duration for segment in segments), n)
    for _ in range(abs(ulps)):
        times = np.nextafter(times, np.inf if ulps > 0 else -np.inf)
    assert CollisionDepth(nothing_near, 0.01, SPACE).over(segments, times).shape == (n,)
