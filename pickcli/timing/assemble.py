"""Runs put one after the other with holds between them, and the proof chords of the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.polyline import NOWHERE
from pickcli.timing.run import TimedRun

# Power basis of a quintic on [0, 1] to its Bernstein coefficients.
_BERNSTEIN = np.array(
    [
        [1, 0, 0, 0, 0, 0],
        [1, 1 / 5, 0, 0, 0, 0],
        [1, 2 / 5, 1 / 10, 0, 0, 0],
        [1, 3 / 5, 3 / 10, 1 / 10, 0, 0],
        [1, 4 / 5, 6 / 10, 4 / 10, 1 / 5, 0],
        [1, 1, 1, 1, 1, 1],
    ]
)


@dataclass(frozen=True, eq=False)
class Assembled:
    """Several runs as one trajectory.

    starts, ends: (R,) when each run begins and is at rest again, s; between ``ends[i]`` and
        ``starts[i + 1]`` the robot holds still
    piece_scales: (N - 1,) speed scale that held on each piece, for ``check_limits``
    """

    trajectory: Trajectory
    starts: Array
    ends: Array
    piece_scales: Array


def concatenate(runs: Sequence[TimedRun], dwells: Sequence[float]) -> Assembled:
    """One trajectory through all runs, at rest for ``dwells`` s before each run and after the last.

    dwells: (R + 1,), each 0 or longer. Raises ValueError if runs do not join or the counts do not fit.
    """
    if len(dwells) != len(runs) + 1 or not runs or min(dwells) < 0.0:
        raise ValueError(f"{len(runs)} runs need {len(runs) + 1} dwells of at least 0 s, not {list(dwells)}")
    rows = [_at_rest(runs[0].trajectory.positions[0], 0.0)]
    scales, starts, ends, now = [], [], [], 0.0
    for run, dwell in zip(runs, dwells, strict=False):
        now = _hold(rows, scales, now, dwell)
        _check_join(rows[-1][1], run.trajectory.positions[0])
        starts.append(now)
        rows.append(_rows(run.trajectory, now))
        scales.append(run.piece_scales)
        now += run.trajectory.duration
        ends.append(now)
    _hold(rows, scales, now, dwells[-1])
    t, q, v, a = (np.concatenate(column) for column in zip(*rows, strict=True))
    names = runs[0].trajectory.joint_names
    return Assembled(Trajectory(names, t, q, v, a), np.array(starts), np.array(ends), np.concatenate(scales))


_Rows = tuple[Array, Array, Array, Array]


def _at_rest(q: Array, t: float) -> _Rows:
    still = np.zeros((1, len(q)))
    return np.array([t]), q[None].copy(), still, still


def _rows(trajectory: Trajectory, start: float) -> _Rows:
    """All points but the first, which is the last one of what came before."""
    t = trajectory.times[1:] + start
    return t, trajectory.positions[1:], trajectory.velocities[1:], trajectory.accelerations[1:]


def _hold(rows: list[_Rows], scales: list[Array], now: float, dwell: float) -> float:
    """Append a hold: two equal points at rest make a quintic that is exactly constant."""
    if dwell > 0.0:
        rows.append(_at_rest(rows[-1][1][-1], now + dwell))
        scales.append(np.ones(1))
    return now + dwell


def _check_join(before: Array, start: Array) -> None:
    gap = float(np.abs(before[-1] - start).max())
    if gap > NOWHERE:
        raise ValueError(f"a run starts {gap:.3g} from where the run before it ends")


def trajectory_chords(trajectory: Trajectory) -> tuple[Array, Array]:
    """Chords (N, n) and slack (N - 1, n): each quintic piece lies within its slack, joint by joint, of its chord.

    With Bernstein coefficients b_i of a piece, its distance from the chord point at the same u is a convex
    combination of the distances of b_i from the chord at i / 5: the largest of those is a strict bound.
    """
    control = _BERNSTEIN @ trajectory.coefficients()
    q = trajectory.positions
    along = np.linspace(0.0, 1.0, 6)[None, :, None]
    chord = q[:-1, None] + along * (q[1:] - q[:-1])[:, None]
    return q, np.abs(control - chord).max(axis=1)
