"""Converts recorded motions to data of a page: positions, tracks of items, vacuum and joint limits."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.files.packed_array import packed
from pickcli.geometry import Array
from pickcli.page.motion_parts import TIME_RESOLUTION, limit_signal
from pickcli.page.page_motion import PageMotion, Signal, Track
from pickcli.trial.motion_record import RecordedMotion

JOINT, POSE, KILOPASCAL = 1e-4, 1e-4, 0.05  # resolutions


def replayed(motion: RecordedMotion) -> PageMotion:
    """Convert a recorded motion.

    Args:
        motion: The recorded motion.

    Returns:
        The motion of the page.
    """
    return PageMotion(
        float(motion.times[-1]),
        packed(motion.times, TIME_RESOLUTION),
        packed(motion.joints, JOINT),
        tracks=tuple(
            Track(item, packed(times, TIME_RESOLUTION), packed(poses, POSE))
            for item, (times, poses) in motion.items.items()
        ),
        is_path_drawn=False,
    )


def vacuum_signals(motion: RecordedMotion) -> Iterator[Signal]:
    """Yield the vacuum in the cup over time, if there was any.

    Args:
        motion: The recorded motion.

    Yields:
        The signal.
    """
    if len(motion.vacuum):
        yield Signal(
            "vacuum", "kPa", packed(motion.vacuum_times, TIME_RESOLUTION),
            packed(motion.vacuum[:, None] / 1e3, KILOPASCAL), ("in the cup",), (1.0,), (), 0.0, 62.0,
        )  # fmt: skip


def joint_signals(motion: RecordedMotion, cell: Cell, is_only: bool = True) -> Iterator[Signal]:
    """Yield velocity, acceleration and jerk in all executions of a cell's arm, with 0 in between.

    Args:
        motion: The recorded motion.
        cell: The cell as seen by the arm.
        is_only: Whether no other arm plays; else signals have the arm's name.

    Yields:
        Three signals; none if the arm did not move.
    """
    moves = [each for each in motion.executions if each.shares and each.arm == cell.arm]
    if not moves:
        return
    n = cell.robot.n_joints
    for k in range(3):
        times, rows = [np.zeros(1)], [np.zeros((1, n))]
        for each in moves:
            times += [each.times[:1] - 2 * TIME_RESOLUTION, each.times, each.times[-1:] + 2 * TIME_RESOLUTION]
            rows += [np.zeros((1, n)), each.shares[k], np.zeros((1, n))]
        at = np.concatenate(times)
        is_later = np.append(True, np.diff(np.maximum.accumulate(at)) > 0.0)
        shares = _without_rest(np.concatenate(rows))[is_later]
        yield limit_signal(k + 1, shares, cell, at[is_later], "" if is_only else cell.arm)


def _without_rest(shares: Array) -> Array:
    return np.clip(shares, -1.2, 1.2)
