"""Proof of a timed motion, and of how far it keeps from everything."""

from __future__ import annotations

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.motion.trajectory import Trajectory
from pickcli.path_planning.state_space import JointSpace
from pickcli.timing.trajectory_chords import trajectory_chords
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

_WIDEST = 0.128  # m: clearances beyond are told as this
_HALVINGS = 7  # to a millimetre


def is_proven(trajectory: Trajectory, proof: TrajectoryValidator) -> bool:
    """Whether the quintics of a trajectory are proven free and inside the position limits."""
    return proof.proves(lambda step: trajectory_chords(refined(trajectory, step)))


def refined(trajectory: Trajectory, step: float) -> Trajectory:
    """The same motion with points ``step`` s apart at most; exact for quintics, but for rounding."""
    counts = np.ceil(np.diff(trajectory.times) / step - 1e-9).astype(int)
    starts = trajectory.times[:-1]
    pieces = [
        t + h * np.arange(n) / n for t, h, n in zip(starts, np.diff(trajectory.times), counts, strict=True)
    ]
    t = np.concatenate([*pieces, trajectory.times[-1:]])
    return Trajectory(trajectory.joint_names, t, *(trajectory.sample(t, order) for order in range(3)))


def keeps_clearance(
    trajectory: Trajectory, space: JointSpace, checker: SceneChecker, clearance: float
) -> bool:
    """Whether a motion is proven to keep that many m from everything."""
    return is_proven(trajectory, TrajectoryValidator(checker.at_margin(clearance), space))


def proven_clearance(trajectory: Trajectory, space: JointSpace, checker: SceneChecker) -> float:
    """m that a motion, proven with the checker, is proven to keep from everything, to a millimetre."""
    low, high = checker.margin, _WIDEST
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if keeps_clearance(trajectory, space, checker, middle) else (low, middle)
    return low
