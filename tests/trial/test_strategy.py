"""What comes next: points per second, one retry, a clock that no wall clock moves."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.trial.order import Target
from pickcli.trial.strategy import Job, TrialClock, next_job

JOB = Job(0, Target("bin_A", "crayola_24_ct"), 10, 12.0)

jobs = st.builds(
    Job,
    index=st.integers(0, 20),
    target=st.just(JOB.target),
    points=st.integers(10, 23),
    seconds=st.floats(5.0, 30.0),
    can_hold=st.booleans(),
    attempts=st.integers(0, 1),
)


@given(st.lists(jobs, min_size=1, max_size=8, unique_by=lambda job: job.index))
def test_nothing_beats_the_chosen_job(candidates: list[Job]) -> None:
    chosen = next_job(candidates)
    assert all(job.rate <= chosen.rate for job in candidates)
    assert next_job(list(reversed(candidates))) is chosen


def test_more_points_or_less_time_come_first_and_retries_wait() -> None:
    richer = replace(JOB, index=1, points=20)
    faster = replace(JOB, index=2, seconds=5.0)
    assert next_job([JOB, richer]) is richer
    assert next_job([JOB, richer, faster]) is faster
    assert next_job([JOB, richer.failed()]) is JOB  # equal rates: the earlier line of the order
    assert next_job([replace(JOB, points=11), richer.failed()]).points == 11


def test_a_job_is_retried_once_and_only_if_the_tool_can_hold_it() -> None:
    assert JOB.failed().is_retriable
    assert not JOB.failed().failed().is_retriable
    assert not replace(JOB, can_hold=False).failed().is_retriable


def test_a_known_duration_replaces_the_estimate() -> None:
    assert JOB.failed(None, 7.5).seconds == 7.5
    assert JOB.failed(None, None).seconds == JOB.seconds


@given(st.integers(0, 50), st.floats(0, 500), st.floats(0, 1000))
def test_the_clock_adds_motion_and_planning_calls(n_plans: int, motion: float, ask: float) -> None:
    clock = TrialClock(900.0).moved(motion)
    for _ in range(n_plans):
        clock = clock.planned()
    assert clock.now == pytest.approx(motion + n_plans * clock.charge)
    assert clock.has_time_for(ask) == (clock.now + ask <= 900.0)
    assert 0.0 <= clock.left <= 900.0
