"""Time shortcutting of a collision-free motion; every shortcut is proven before it is accepted.

Two moves are tried at random places: a stretch of the motion is replaced by the fastest segment between the
states at its ends (Hauser and Ng-Thow-Hing 2010), or by two segments through a state near the motion, so that
joints with spare time avoid obstacles of the slowest joint.
"""

from __future__ import annotations

import numpy as np

from pickcli.kernel import ParabolicLimits, ParabolicSegment, ParabolicTrajectory, steer_min_time
from pickcli.trajopt.parabolic_segment import TICK
from pickcli.trajopt.perturbations import perturbed_state, random_interval
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

# Standard deviation of a perturbation in the first and the last move, as shares of what a joint can travel.
_FIRST, _LAST = 0.3, 0.02
_BEND = 0.7  # share of the moves with an intermediate state


def shortcut_time(
    proof: TrajectoryValidator,
    limits: ParabolicLimits,
    motion: ParabolicTrajectory,
    target: float,
    *,
    seed: int,
    iterations: int,
) -> ParabolicTrajectory:
    """Make a proven motion faster, jerk limits included. Repeatable by seed.

    Only new segments are proven; the rest of the motion is known to be free.

    Args:
        proof: Validator of the scene.
        limits: Velocity, acceleration and jerk limits.
        motion: A proven motion.
        target: s; the search ends when the segments take no longer than this and a pause.
        seed: Seed of all random choices.
        iterations: Number of moves, at most.

    Returns:
        A motion with the same ends that takes no longer.
    """
    rng = np.random.default_rng(seed)
    total = motion.total(limits)
    for share in np.geomspace(_FIRST, _LAST, max(iterations, 1)):
        if total <= target + limits.pause + TICK / 2:
            break
        start, end = random_interval(motion, rng)
        segments = _shortcut(proof, limits, motion, start, end, float(share), rng)
        if segments is None:
            continue
        changed = motion.replaced(start, end, segments)
        shorter = changed.total(limits)
        if shorter < total - TICK / 2 and proof.is_valid(segments):
            motion, total = changed, shorter
    return motion


def _shortcut(
    proof: TrajectoryValidator,
    limits: ParabolicLimits,
    motion: ParabolicTrajectory,
    start: float,
    end: float,
    share: float,
    rng: np.random.Generator,
) -> tuple[ParabolicSegment, ...] | None:
    """Return segments that take no more time than the stretch, not yet proven; None if none were found."""
    first, last, at_most = motion.state(start), motion.state(end), end - start
    if rng.random() >= _BEND:
        segment = steer_min_time(first, last, limits, at_most)
        return None if segment is None else (segment,)
    at = start + at_most * rng.uniform(0.1, 0.9)
    middle = perturbed_state(motion.state(at), share, motion.duration, proof.space, limits, rng)
    there = steer_min_time(first, middle, limits, at_most)
    if there is None:
        return None
    back = steer_min_time(middle, last, limits, at_most - there.duration)
    return None if back is None else (there, back)
