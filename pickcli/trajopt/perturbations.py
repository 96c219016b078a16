"""Random perturbations that the searches for motions share."""

from __future__ import annotations

import numpy as np

from pickcli.kernel import JointState, ParabolicLimits, ParabolicTrajectory
from pickcli.path_planning.state_space import JointSpace
from pickcli.trajopt.parabolic_segment import TICK

_TO_AN_END = 0.3  # share of the stretches that extend to an end of the motion, for each end
_SHORTEST = 6  # ticks
_MOVED = 0.4  # share of the joints that a perturbation moves: a step in all is rarely good for the slowest
_SPEED = 3.0  # ratio of the spread of velocities to that of positions


def random_interval(motion: ParabolicTrajectory, rng: np.random.Generator) -> tuple[float, float]:
    """Sample two times of a motion, on ticks and not too close to each other.

    Args:
        motion: The motion.
        rng: Source of random numbers.

    Returns:
        Start and end, s.
    """
    n_ticks = round(motion.duration / TICK)
    start, end = sorted((rng.random(2) * n_ticks).tolist())
    start = 0.0 if rng.random() < _TO_AN_END else min(start, n_ticks - _SHORTEST)
    end = n_ticks if rng.random() < _TO_AN_END else max(end, start + _SHORTEST)
    first = max(round(start), 0)
    return first * TICK, min(max(round(end), first + 1), n_ticks) * TICK


def perturbed_state(
    state: JointState,
    share: float,
    duration: float,
    space: JointSpace,
    limits: ParabolicLimits,
    rng: np.random.Generator,
) -> JointState:
    """Sample a state near another: some joints displaced, some with another velocity, within limits.

    Args:
        state: The state to be perturbed.
        share: Standard deviation of a step in position, as a share of what a joint can travel in the duration
            at full speed.
        duration: s.
        space: Position limits.
        limits: Velocity limits.
        rng: Source of random numbers.

    Returns:
        The perturbed state.
    """
    is_moved, is_changed = rng.random((2, space.n)) < _MOVED
    velocity = limits.velocity
    q = state.q + rng.normal(0.0, share * duration, space.n) * velocity * is_moved
    v = state.v + rng.normal(0.0, _SPEED * share, space.n) * velocity * is_changed
    within = np.minimum(np.maximum(q, space.lower), space.upper)  # like np.clip, in a third of its time
    return JointState(within, np.minimum(np.maximum(v, -velocity), velocity))
