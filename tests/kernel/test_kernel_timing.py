"""Paces and quintics in the kernel: exact where they say so, and wrong input named."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array
from pickcli.kernel import estimated_duration, fastest_pace, quintic_peaks, quintic_states
from pickcli.motion.trajectory import Trajectory
from support import duration_reference

Rows = tuple[Array, Array, Array, Array]


def states(seed: int, n_points: int, n: int) -> Rows:
    """Times (N,), positions, velocities and accelerations (N, n) of a wild trajectory."""
    rng = np.random.default_rng(seed)
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.003, 0.5, n_points - 1))])
    q, dq, ddq = (rng.normal(size=(n_points, n)) * size for size in (1.0, 2.0, 10.0))
    return times, q, dq, ddq


def derivatives(rows: Rows, piece: int, u: Array) -> tuple[Array, Array, Array]:
    """Velocity, acceleration and jerk (M, n) of a piece at u (M,) in [0, 1], by solving for its quintic."""
    times, p, v, a = rows
    h = times[piece + 1] - times[piece]
    powers = np.array([[k**0, k, k**2, k**3, k**4, k**5] for k in (0.0, 1.0)])
    first = np.array([[0, 1, 2 * k, 3 * k**2, 4 * k**3, 5 * k**4] for k in (0.0, 1.0)])
    second = np.array([[0, 0, 2, 6 * k, 12 * k**2, 20 * k**3] for k in (0.0, 1.0)])
    ends = np.concatenate([p[piece : piece + 2], h * v[piece : piece + 2], h * h * a[piece : piece + 2]])
    c = np.linalg.solve(np.concatenate([powers, first, second]), ends)
    found = []
    for order in (1, 2, 3):
        c = np.arange(1, len(c))[:, None] * c[1:]
        found.append(u[:, None] ** np.arange(len(c)) @ c / h**order)
    return found[0], found[1], found[2]


def control_polygon(rows: Rows, piece: int) -> np.ndarray:
    """(5, n) sizes of the Bernstein coefficients of a piece's velocity, a quartic within their hull."""
    u, k = np.linspace(0.0, 1.0, 5)[:, None], np.arange(5)
    bernstein = np.array([1, 4, 6, 4, 1]) * u**k * (1.0 - u) ** (4 - k)
    return np.asarray(np.abs(np.linalg.solve(bernstein, derivatives(rows, piece, u[:, 0])[0])))


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**31), n_points=st.integers(2, 6), n=st.integers(1, 8))
def test_peaks_are_those_of_the_quintics(seed: int, n_points: int, n: int) -> None:
    rows = states(seed, n_points, n)
    velocity, acceleration, jerk = quintic_peaks(*rows)
    u = np.linspace(0.0, 1.0, 401)
    for piece in range(n_points - 1):
        dq, ddq, dddq = (np.abs(d).max(axis=0) for d in derivatives(rows, piece, u))
        assert np.all(velocity[piece] >= dq * (1 - 1e-9))
        assert np.all(velocity[piece] <= control_polygon(rows, piece).max(axis=0) * (1 + 1e-9))
        assert np.allclose(acceleration[piece], ddq, rtol=1e-3)
        assert np.all(acceleration[piece] >= ddq * (1 - 1e-9))
        assert np.allclose(jerk[piece], dddq, rtol=1e-3)
        assert np.all(jerk[piece] >= dddq * (1 - 1e-9))


def test_a_piece_at_rest_has_no_peaks() -> None:
    still = np.zeros((2, 3))
    assert all(not peak.any() for peak in quintic_peaks(np.array([0.0, 1.0]), np.ones((2, 3)), still, still))


def test_one_joint_alone_accelerates_and_brakes() -> None:
    """A metre at 1 m/s^2 from rest to rest takes two seconds and reaches 1 m/s half-way."""
    s = np.array([0.0, 1.0])
    one, none = np.ones((2, 1)), np.zeros((2, 1))
    line = np.ones(1, dtype=np.int32)
    t, at, v = fastest_pace(s, one, none, np.ones((1, 1)), np.full(2, 9.0), np.full(1, 9.0), line)
    assert t[-1] == pytest.approx(2.0) and v.max() == pytest.approx(1.0)
    assert at[np.argmax(v)] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("s", [0.0, 0.0, 1.0]),
        ("s", [0.0, np.nan, 1.0]),
        ("ddq", np.zeros((3, 3))),
        ("acceleration", np.zeros((2, 2))),
        ("speed", np.ones(2)),
        ("is_line", [0.5, 0.5]),
    ],
)
def test_wrong_paths_are_named(name: str, value: object) -> None:
    good: dict[str, object] = {
        "s": np.arange(3.0),
        "dq": np.ones((3, 2)),
        "ddq": np.zeros((3, 2)),
        "acceleration": np.ones((2, 2)),
        "speed": np.ones(3),
        "line_speed": np.ones(2),
        "is_line": np.zeros(2, dtype=np.int32),
    }
    fastest_pace(**good)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=name):
        fastest_pace(**{**good, name: value})  # type: ignore[arg-type]


def test_times_that_do_not_increase_are_refused() -> None:
    times, *rest = states(0, 4, 2)
    times[2] = times[1]
    with pytest.raises(ValueError, match="times"):
        quintic_peaks(times, *rest)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 9), st.integers(1, 8))
def test_states_are_those_of_the_trajectory(seed: int, n_points: int, n: int) -> None:
    """Between its points, at them, and beyond its ends."""
    rows = states(seed, n_points, n)
    trajectory = Trajectory((), *rows)
    t = np.concatenate([rows[0], np.linspace(-0.1, rows[0][-1] + 0.1, 40)])
    for found, expected in zip(quintic_states(*rows, t), trajectory.states(t), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
    np.testing.assert_array_equal(quintic_states(*rows, t, 0)[0], quintic_states(*rows, t)[0])
    np.testing.assert_array_equal(quintic_states(*rows, rows[0][:-1])[0], rows[1][:-1])


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(0, 9), st.integers(1, 8))
def test_the_estimated_duration_is_that_of_numpy(seed: int, n_points: int, n: int) -> None:
    """Also where waypoints repeat, or lie on one line."""
    rng = np.random.default_rng(seed)
    bent = rng.normal(size=(n_points, n))
    limits = rng.uniform(0.5, 3.0, n), rng.uniform(1.0, 9.0, n), 0.02
    for waypoints in (bent, bent.repeat(2, axis=0), rng.random((n_points, 1)) * np.ones(n)):
        expected = duration_reference.estimated_duration(waypoints, *limits)
        assert estimated_duration(waypoints, *limits) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("bad", ["velocity", "acceleration", "corner_deviation"])
def test_limits_that_are_none_are_refused(bad: str) -> None:
    limits = {name: np.zeros(2) if name == bad else np.ones(2) for name in ("velocity", "acceleration")}
    with pytest.raises(ValueError, match=bad):
        estimated_duration(np.zeros((3, 2)), **limits, corner_deviation=0.0 if bad[0] == "c" else 0.02)
