"""Concatenation of runs, with rests between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.polyline_simplification import NOWHERE
from pickcli.timing.timed_run import TimedRun

_Rows: TypeAlias = tuple[Array, Array, Array, Array]


@dataclass(frozen=True, eq=False)
class RestingRun:
    """A run in which the arm rests, e.g. while only the tool moves.

    Attributes:
        trajectory: Two equal points.
        part_times: (2,) s of its start and end.
        piece_scales: (1,) speed scale, for ``check_limits``.
    """

    trajectory: Trajectory
    part_times: Array
    piece_scales: Array

    @classmethod
    def of(cls, joint_names: tuple[str, ...], q: Array, duration: float) -> RestingRun:
        """Return a run at rest.

        Args:
            joint_names: Names of the n joints.
            q: (n,) configuration.
            duration: s, above 0.

        Returns:
            The run.
        """
        trajectory = _trajectory(joint_names, [_at_rest(q, 0.0), _at_rest(q, duration)])
        return cls(trajectory, trajectory.times, np.ones(1))


Run: TypeAlias = TimedRun | RestingRun


@dataclass(frozen=True, eq=False)
class ConcatenatedRuns:
    """Several runs as one trajectory.

    Attributes:
        trajectory: From the start of the first run to the end of the last.
        part_times: (P + 1,) s when each part of all runs begins, and the end; a rest belongs to the part
            before it.
        starts: (R,) s when each run starts.
        ends: (R,) s when each run is at rest again.
        piece_scales: (N - 1,) speed scale of each piece, for ``check_limits``.
    """

    trajectory: Trajectory
    part_times: Array
    starts: Array
    ends: Array
    piece_scales: Array


def concatenate(runs: Sequence[Run], rests: Sequence[float]) -> ConcatenatedRuns:
    """Join runs to one trajectory, with a rest after each run except the last.

    Args:
        runs: R runs, each beginning where the one before it ends.
        rests: (R - 1,) s, at least 0.

    Returns:
        The joined runs.

    Raises:
        ValueError: If a run does not start where the previous one ends, or the number of rests is wrong.
    """
    if not runs or len(rests) != len(runs) - 1 or min(rests, default=0.0) < 0.0:
        raise ValueError(f"{len(runs)} runs need {len(runs) - 1} rests of at least 0 s, not {list(rests)}")
    rows: list[_Rows] = [_at_rest(runs[0].trajectory.positions[0], 0.0)]
    scales: list[Array] = []
    starts, ends, now = [], [], 0.0
    for run, rest in zip(runs, [*rests, 0.0], strict=True):
        _check_join(rows[-1][1][-1], run.trajectory.positions[0])
        starts.append(now)
        now += run.trajectory.duration
        ends.append(now)
        rows.append(_rows_after_first(run.trajectory, starts[-1]))
        scales.append(run.piece_scales)
        if rest > 0.0:
            now += rest
            rows.append(_at_rest(rows[-1][1][-1], now))
            scales.append(np.ones(1))
    inner = [run.part_times[:-1] + start for run, start in zip(runs, starts, strict=True)]
    part_times = np.concatenate([*inner, [now]])
    trajectory = _trajectory(runs[0].trajectory.joint_names, rows)
    return ConcatenatedRuns(trajectory, part_times, np.array(starts), np.array(ends), np.concatenate(scales))


def delayed(trajectory: Trajectory, delay: float) -> Trajectory:
    """Begin a trajectory with a rest.

    Args:
        trajectory: The trajectory.
        delay: s, 0 or longer.

    Returns:
        The trajectory that rests at its first point for ``delay``.
    """
    if delay <= 0.0:
        return trajectory
    first = trajectory.positions[0]
    rows = [_at_rest(first, 0.0), _at_rest(first, delay), _rows_after_first(trajectory, delay)]
    return _trajectory(trajectory.joint_names, rows)


def _at_rest(q: Array, t: float) -> _Rows:
    """Return one point at rest: two equal ones make a quintic that is exactly constant."""
    still = np.zeros((1, len(q)))
    return np.array([t]), q[None].copy(), still, still


def _rows_after_first(trajectory: Trajectory, start: float) -> _Rows:
    """Return all points except the first, which is the last one of the rows before."""
    t = trajectory.times[1:] + start
    return t, trajectory.positions[1:], trajectory.velocities[1:], trajectory.accelerations[1:]


def _trajectory(names: tuple[str, ...], rows: Sequence[_Rows]) -> Trajectory:
    t, q, v, a = (np.concatenate(column) for column in zip(*rows, strict=True))
    return Trajectory(names, t, q, v, a)


def _check_join(end: Array, start: Array) -> None:
    gap = float(np.abs(end - start).max())
    if gap > NOWHERE:
        raise ValueError(f"a run starts {gap:.3g} from where the run before it ends")
