"""Every event once, in order, at its place: whatever the robot does with its time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.io_events.tracker import EventTracker
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.trajectory import Trajectory

DT = 1e-3
TABLE = 5e-5  # s between the commands that the simulated robot is given


def along(path: Callable[[Array], Array], length: float, speed: float, step: float = 0.008) -> Trajectory:
    """A trajectory along path(s), s = 0..length, from rest to rest, with an even speed in between."""
    ramp = 0.2
    duration = length / speed + ramp
    t = np.linspace(0.0, duration, int(duration / step) + 1)
    rise = np.clip(t / ramp, 0.0, 1.0)
    fall = np.clip((duration - t) / ramp, 0.0, 1.0)
    s = np.concatenate(
        [[0.0], np.cumsum(np.diff(t) * (np.minimum(rise, fall)[1:] + np.minimum(rise, fall)[:-1]) / 2)]
    )
    s *= length / s[-1]
    q = path(s)
    v = np.gradient(q, t, axis=0)
    v[[0, -1]] = 0.0
    return Trajectory(tuple(f"j{i}" for i in range(q.shape[1])), t, q, v, np.zeros_like(q))


def with_rest(trajectory: Trajectory, rest: float) -> Trajectory:
    """The trajectory there, a rest at its end, and back the same way."""
    back = trajectory.duration + rest
    t = np.concatenate([trajectory.times, trajectory.times + back])
    q = np.concatenate([trajectory.positions, trajectory.positions[::-1]])
    v = np.concatenate([trajectory.velocities, -trajectory.velocities[::-1]])
    return Trajectory(trajectory.joint_names, t, q, v, np.zeros_like(q))


def line(s: Array) -> Array:
    return np.column_stack([0.6 * s, 0.8 * s, 0.0 * s])


def figure_eight(s: Array) -> Array:
    """Crosses itself at the origin; about 6 long for s = 0..1."""
    a = 2.0 * np.pi * s
    return np.column_stack([np.sin(a), 0.5 * np.sin(2.0 * a), 0.0 * a])


def twice_round(s: Array) -> Array:
    """The same circle twice: every place is passed two times in the same direction."""
    a = 4.0 * np.pi * s
    return np.column_stack([0.3 * np.cos(a), 0.3 * np.sin(a), 0.0 * a])


TRAJECTORIES = {
    "line": along(line, 2.0, 2.0),
    "figure eight": along(figure_eight, 1.0, 0.25),
    "twice round": along(twice_round, 1.0, 0.4),
    "there and back": with_rest(along(line, 1.0, 1.5), 0.5),
}


def events_at(times: Array) -> list[Event]:
    return [
        Event("valve", str(i), Anchor(AnchorKind.TIME, 0, float(t)), 0.0, float(t), float(t))
        for i, t in enumerate(times)
    ]


def execute(
    trajectory: Trajectory,
    tracker: EventTracker,
    lag: float,
    pace: Callable[[int], float],
    noise: float,
    seed: int,
) -> list[tuple[Event, Array, float]]:
    """A robot that follows with a first-order lag, at a pace of its own: (event, true q, planned time)."""
    rng = np.random.default_rng(seed)
    table = trajectory.sample(np.arange(0.0, trajectory.duration + TABLE, TABLE))
    q, t, fired = trajectory.positions[0].copy(), 0.0, []
    for k in range(100_000):
        t = min(t + DT * pace(k), trajectory.duration)
        q = q + (table[round(t / TABLE)] - q) * min(DT / lag, 1.0)
        measured = q + rng.uniform(-noise, noise, len(q))
        fired += [(event, q.copy(), t) for event in tracker.update(measured, DT)]
        if t >= trajectory.duration and not tracker.pending:
            break
        if (
            t >= trajectory.duration
            and np.linalg.norm(q - trajectory.positions[-1]) < 1e-6
            and k % 1000 == 999
        ):
            break
    return fired


@given(
    name=st.sampled_from(sorted(TRAJECTORIES)),
    shares=st.lists(st.floats(0.0, 1.0), min_size=1, max_size=8),
    lag=st.floats(1e-3, 0.04),
    slow=st.floats(0.3, 1.0),
    pause=st.tuples(st.integers(0, 2000), st.integers(0, 500)),
    noise=st.sampled_from([0.0, 1e-5, 2e-4]),
    seed=st.integers(0, 1000),
)
@settings(max_examples=40, deadline=None)
def test_each_event_once_in_order_and_at_its_place(
    name: str, shares: list[float], lag: float, slow: float, pause: tuple[int, int], noise: float, seed: int
) -> None:
    trajectory = TRAJECTORIES[name]
    events = events_at(np.array(shares) * trajectory.duration)
    tracker = EventTracker(trajectory, (), events)

    def pace(k: int) -> float:
        return 0.0 if pause[0] <= k < sum(pause) else slow

    fired = execute(trajectory, tracker, lag, pace, noise, seed)
    assert [e.t_trigger for e, _, _ in fired] == sorted(
        e.t_trigger for e in events if e.t_trigger is not None
    )
    assert sorted(e.action for e, _, _ in fired) == sorted(e.action for e in events)
    for event, q, _ in fired:
        place = trajectory.sample(event.t_trigger or 0.0)[0]
        # 2 mm at a metre from the joints; what the robot cuts off at a corner is not the tracker's doing.
        cut = _distance(trajectory, q)
        assert np.linalg.norm(q - place) < 2e-3 + cut + noise


def _distance(trajectory: Trajectory, q: Array) -> float:
    path = trajectory.sample(np.linspace(0.0, trajectory.duration, 8000))
    return float(np.linalg.norm(path - q, axis=1).min())


@pytest.mark.parametrize("lag", [1e-3, 0.02, 0.1])
def test_nothing_of_a_rest_fires_before_arrival(lag: float) -> None:
    trajectory = TRAJECTORIES["there and back"]
    arrival = TRAJECTORIES["line"].duration
    rest = np.flatnonzero(np.all(np.diff(trajectory.positions, axis=0) == 0.0, axis=1))[0]
    arrival = trajectory.times[rest]
    events = events_at(np.array([arrival + 1e-6, arrival + 0.2, arrival + 0.5]))
    fired = execute(trajectory, EventTracker(trajectory, (), events), lag, lambda k: 1.0, 0.0, 0)
    for _, q, _ in fired[:2]:
        assert np.linalg.norm(q - trajectory.positions[rest]) < 2e-3
    assert len(fired) == 3


def test_time_of_a_rest_runs_by_the_clock_from_arrival() -> None:
    trajectory = TRAJECTORIES["there and back"]
    rest = np.flatnonzero(np.all(np.diff(trajectory.positions, axis=0) == 0.0, axis=1))[0]
    start, q = float(trajectory.times[rest]), trajectory.positions[rest]
    tracker = EventTracker(trajectory, (), events_at(np.array([start, start + 0.3])))
    for t in np.arange(0.0, start, DT):
        assert tracker.update(trajectory.sample(t)[0], DT) == () or tracker.progress >= start
    seen = []
    for k in range(400):
        seen += [(k, e) for e in tracker.update(q, DT)]
    assert [e.action for _, e in seen][-1] == "1"
    assert seen[-1][0] * DT == pytest.approx(0.3, abs=0.07)


def creeping(duration: float, rest: float) -> Trajectory:
    """0.3 m from rest to rest by a quintic, whose last half millimetre takes long; then a rest."""
    u = np.linspace(0.0, 1.0, 1001)
    s = 0.3 * (10.0 * u**3 - 15.0 * u**4 + 6.0 * u**5)
    v = 0.3 * (30.0 * u**2 - 60.0 * u**3 + 30.0 * u**4) / duration
    a = 0.3 * (60.0 * u - 180.0 * u**2 + 120.0 * u**3) / duration**2
    t, q = np.append(u * duration, duration + rest), np.append(s, s[-1])[:, None]
    return Trajectory(("j0",), t, q, np.append(v, 0.0)[:, None], np.append(a, 0.0)[:, None])


@pytest.mark.parametrize("lag", [DT, 0.02])
def test_events_near_a_creeping_end_fire_in_time_and_at_their_place(lag: float) -> None:
    trajectory = creeping(6.0, 0.5)
    left = trajectory.positions[-1, 0] - trajectory.positions[:, 0]
    assert trajectory.times[-2] - trajectory.times[np.argmax(left < 5e-4)] > 0.3
    triggers = np.array([4.0, 5.0, 5.4, 5.6, 5.7, 5.8, 5.9, 5.95, 5.99, 6.0, 6.2, 6.5])
    fired = execute(trajectory, EventTracker(trajectory, (), events_at(triggers)), lag, lambda k: 1.0, 0.0, 0)
    assert [event.t_trigger for event, _, _ in fired] == triggers.tolist()
    for event, q, t in fired:
        late = t - (event.t_trigger or 0.0)
        # By as much as the robot lags behind its commands; the last fires where the commands end.
        assert -DT <= late <= lag + 2e-3
        place = trajectory.sample(event.t_trigger or 0.0)[0]
        assert np.linalg.norm(q - place) < 5e-5


def test_robot_that_never_arrives_fires_nothing_of_the_rest() -> None:
    trajectory = TRAJECTORIES["there and back"]
    rest = np.flatnonzero(np.all(np.diff(trajectory.positions, axis=0) == 0.0, axis=1))[0]
    tracker = EventTracker(trajectory, (), events_at(np.array([float(trajectory.times[rest]) + 0.1])))
    short_of_it = float(trajectory.times[rest]) - 0.1
    for t in [*np.arange(0.0, short_of_it, DT), *[short_of_it] * 3000]:
        assert tracker.update(trajectory.sample(t)[0], DT) == ()


def test_events_at_or_after_the_end_fire_at_the_end() -> None:
    trajectory = TRAJECTORIES["line"]
    end = trajectory.duration
    fired = execute(
        trajectory,
        EventTracker(trajectory, (), events_at(np.array([end, end + 0.1]))),
        0.01,
        lambda k: 1.0,
        0,
        0,
    )
    assert len(fired) == 2
    assert np.linalg.norm(fired[0][1] - trajectory.positions[-1]) < 1e-3


def test_events_at_the_start_fire_with_the_first_update() -> None:
    trajectory = TRAJECTORIES["line"]
    tracker = EventTracker(trajectory, (), events_at(np.array([0.0])))
    assert len(tracker.update(trajectory.positions[0], DT)) == 1
    assert tracker.update(trajectory.positions[0], DT) == ()


@given(offset=st.floats(0.0, 1.0))
@settings(max_examples=15, deadline=None)
def test_fires_at_the_step_nearest_to_the_trigger(offset: float) -> None:
    """At 2 m/s and 1 kHz a step is 2 mm: half of that is as near as it gets."""
    trajectory = TRAJECTORIES["line"]
    trigger = 0.5 + offset * DT
    fired = execute(
        trajectory, EventTracker(trajectory, (), events_at(np.array([trigger]))), DT, lambda k: 1.0, 0.0, 0
    )
    assert np.linalg.norm(fired[0][1] - trajectory.sample(trigger)[0]) <= 1.05e-3


def test_progress_never_goes_back() -> None:
    trajectory = TRAJECTORIES["figure eight"]
    tracker, rng = EventTracker(trajectory, (), ()), np.random.default_rng(0)
    last = 0.0
    for t in np.arange(0.0, trajectory.duration, DT):
        tracker.update(trajectory.sample(max(t - 0.05 * rng.random(), 0.0))[0], DT)
        assert tracker.progress >= last
        last = tracker.progress
    assert last == pytest.approx(trajectory.duration, abs=0.06)


def test_weights_decide_what_is_near() -> None:
    """A joint that is told not to matter cannot carry the progress along."""
    trajectory = along(lambda s: np.column_stack([s, 0.1 * s]), 1.0, 1.0)
    tracker = EventTracker(trajectory, (), (), weights=np.array([0.0, 1.0]))
    moved = trajectory.positions[0] + np.array([0.5, 0.0])
    for _ in range(200):
        tracker.update(moved, DT)
    assert tracker.progress < 0.05


def test_unresolved_events_are_refused() -> None:
    with pytest.raises(ValueError, match="resolve"):
        EventTracker(TRAJECTORIES["line"], (), [Event("valve", "on", Anchor(AnchorKind.TIME, 0), 0.0)])
