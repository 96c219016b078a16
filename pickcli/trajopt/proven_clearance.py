"""Proof that a timed motion is free, and the clearance that it is proven to keep."""

from __future__ import annotations

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.motion.trajectory import Trajectory
from pickcli.path_planning.state_space import JointSpace
from pickcli.timing.trajectory_chords import trajectory_chords
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

_WIDEST = 0.128  # m: largest clearance that is proven
_HALVINGS = 7  # to a millimetre


def is_proven(trajectory: Trajectory, proof: TrajectoryValidator) -> bool:
    """Whether a trajectory is proven free and inside the position limits at every instant.

    Args:
        trajectory: The timed motion; the proof is of its quintics, not of its points.
        proof: Validator for a checker and a joint space.

    Returns:
        True if every instant is proven.
    """
    return proof.proves(lambda step: trajectory_chords(refined(trajectory, step)))


def refined(trajectory: Trajectory, step: float) -> Trajectory:
    """Resample a trajectory so that its points are at most ``step`` s apart.

    The motion stays the same: exact for quintics, except for rounding.

    Args:
        trajectory: The trajectory to divide.
        step: Longest time between two points, s.

    Returns:
        The trajectory with more points.
    """
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
    """Whether a trajectory is proven to keep a clearance from everything.

    Args:
        trajectory: The timed motion.
        space: Position limits of the joints.
        checker: Collision checker of the scene; its own margin is not used.
        clearance: Least distance that is to be proven, m.

    Returns:
        True if the clearance is proven at every instant.
    """
    return is_proven(trajectory, TrajectoryValidator(checker.at_margin(clearance), space))


def proven_clearance(trajectory: Trajectory, space: JointSpace, checker: SceneChecker) -> float:
    """Compute the clearance that a trajectory is proven to keep from everything, to a millimetre.

    It is found by bisection between the checker's margin and 0.128 m.

    Args:
        trajectory: A timed motion that is proven with the checker's own margin.
        space: Position limits of the joints.
        checker: Collision checker of the scene.

    Returns:
        Proven clearance, m; larger clearances than 0.128 m are reported as that.
    """
    low, high = checker.margin, _WIDEST
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if keeps_clearance(trajectory, space, checker, middle) else (low, middle)
    return low
