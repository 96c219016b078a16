"""The search for the quickest motion: of what passes the last test, the quickest is taken."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from pickcli.kernel import ParabolicLimits, ParabolicTrajectory
from pickcli.trajopt.minimum_time_search import MinimumTimeSearch
from pickcli.trajopt.trajectory_settings import TrajectorySettings

PACE = ParabolicLimits(np.ones(1), np.ones(1), np.full(1, 20.0), 0.05)


@dataclass(frozen=True)
class Taking:
    """Legs, or a motion, of so many s."""

    duration: float


@dataclass(frozen=True, eq=False)
class Listed(MinimumTimeSearch):
    """A search that finds segments of these durations."""

    durations: tuple[float, ...] = ()
    asked: list[float] = field(default_factory=list)

    def motions(self, seed: int, is_wanted: Callable[[float], bool]) -> Iterator[ParabolicTrajectory]:
        for duration in self.durations:
            self.asked.append(duration)
            yield Taking(duration)  # type: ignore[misc]


def search(*durations: float) -> Listed:
    ends = np.zeros(1), np.ones(1)
    return Listed(None, None, PACE, ends, TrajectorySettings(), durations)  # type: ignore[arg-type]


def finished_in(longer: dict[float, float]) -> Callable[[ParabolicTrajectory], Taking | None]:
    """Motions that take so much longer than their segments; those without an entry fail."""
    return lambda segments: (
        Taking(segments.duration + longer[segments.duration]) if segments.duration in longer else None
    )


def test_the_quickest_is_taken_also_if_a_later_one_only_promised_more() -> None:
    best = search(2.0, 1.9, 1.8).minimum_time(
        0, finished_in({2.0: 0.05, 1.9: 0.2, 1.8: 0.3}), good_enough=0.0
    )
    assert best == Taking(2.05)


def test_what_is_good_ends_the_search() -> None:
    some = search(3.0, 2.0, 1.0)
    assert some.minimum_time(0, finished_in({3.0: 0.05, 2.0: 0.05, 1.0: 0.05}), good_enough=2.1) == Taking(
        2.05
    )
    assert some.asked == [3.0, 2.0]


def test_what_fails_or_is_not_wanted_is_nothing() -> None:
    some = search(3.0, 2.0)
    assert some.minimum_time(0, finished_in({}), good_enough=0.0) is None
    assert some.minimum_time(0, finished_in({3.0: 0.05, 2.0: 0.05}), 0.0, shorter_than=2.0) is None
    assert some.minimum_time(0, finished_in({3.0: 0.05, 2.0: 0.05}), 0.0, max_duration=1.9) is None
    assert some.minimum_time(0, finished_in({3.0: 0.05}), 0.0) == Taking(3.05)
