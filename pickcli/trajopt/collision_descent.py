"""Collision descent: a free motion of a given duration from one in collision, by random perturbations.

The duration is fixed while the depth in collision decreases. If one joint needs all of the time, the other
joints are bent around it without loss: most blocked straight lines can be avoided like this in the time of
the line.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array
from pickcli.kernel import (
    JointState,
    ParabolicLimits,
    ParabolicSegment,
    ParabolicTrajectory,
    parabolic_positions,
    steer_fixed_time,
    steer_via,
)
from pickcli.path_planning.state_space import JointSpace
from pickcli.trajopt.parabolic_segment import TICK
from pickcli.trajopt.perturbations import perturbed_state, random_interval
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

Clearances = Callable[[Array], Array]
"""Configurations (N, n) -> m from the nearest solid, negative inside, (N,)."""

_WIDEST, _NARROWEST = 0.4, 0.02  # standard deviations of a bend: shares of a joint's possible travel
_SAMPLE_TIME = 0.03  # s between the configurations whose depth is measured
_WHOLE = 0.4  # share of the perturbations that replace the whole motion
_NEARLY = 1e-3  # m of mean depth below which a proof may succeed
_PATIENCE = 80  # perturbations in which the depth must fall by a tenth; else the search fails


@dataclass(frozen=True, eq=False)
class CollisionDepth:
    """How deep configurations are in collision, and how far beyond the position limits.

    Attributes:
        clearances: Distances of configurations from the nearest solid.
        margin: Clearance that a configuration should have, m.
        space: Joint space with the position limits.
    """

    clearances: Clearances
    margin: float
    space: JointSpace

    def over(self, segments: Sequence[ParabolicSegment], times: Array) -> Array:
        """Compute the depth of a motion at given times.

        Args:
            segments: K or more parabolic segments, one after the other.
            times: (K,) s since the start of the first segment, increasing.

        Returns:
            (K,) m that is missing to the margin, plus the excess of the joints over their limits (rad or m).
        """
        if not len(times):
            return np.zeros(0)
        Q = parabolic_positions(segments, times)
        outside = np.maximum(np.maximum(self.space.lower - Q, Q - self.space.upper), 0.0).sum(axis=1)
        return np.asarray(np.maximum(self.margin - self.clearances(Q), 0.0) + outside)


def descend_collisions(
    proof: TrajectoryValidator,
    depth: CollisionDepth,
    limits: ParabolicLimits,
    ends: tuple[Array, Array],
    duration: float,
    *,
    seed: int,
    iterations: int,
) -> ParabolicTrajectory | None:
    """Search for a proven motion of a given duration between two configurations.

    Perturbations of random stretches are kept if they do not increase the depth in collision; once the mean
    depth is small, a proof is tried. Repeatable by seed.

    Args:
        proof: Validator that has to accept the result.
        depth: Collision depth that is to be reduced to 0.
        limits: Velocity, acceleration and jerk limits.
        ends: Start and goal configuration, (n,) each.
        duration: Duration of the motion in s, a whole number of ticks.
        seed: Seed of all random choices.
        iterations: Number of perturbations, at most.

    Returns:
        The motion, or None if none was found.
    """
    segment = steer_fixed_time(JointState.at_rest(ends[0]), JointState.at_rest(ends[1]), limits, duration)
    if segment is None:
        return None

    rng = np.random.default_rng(seed)
    motion = ParabolicTrajectory((segment,))
    times = (np.arange(np.ceil(duration / _SAMPLE_TIME)) + 0.5) * (
        duration / np.ceil(duration / _SAMPLE_TIME)
    )
    depths = depth.over(motion.segments, times)
    since, then = 0, np.inf
    for i in range(iterations):
        if i - since >= _PATIENCE:
            if depths.sum() >= 0.9 * then:
                return None
            since, then = i, float(depths.sum())
        start, end = (0.0, duration) if rng.random() < _WHOLE else random_interval(motion, rng)
        segments = _perturbed_segments(proof, limits, motion, start, end, rng)
        if segments is None:
            continue
        concerned = (times >= start) & (times < end)
        deep = depth.over(segments, times[concerned] - start)
        less = float(depths[concerned].sum() - deep.sum())
        if less < 0.0:
            continue
        motion, depths[concerned] = motion.replaced(start, end, segments), deep
        is_other = less > 0.0 or not depths.any()
        if is_other and depths.mean() < _NEARLY and proof.is_valid(motion.segments):
            return motion
    return None


def _perturbed_segments(
    proof: TrajectoryValidator,
    limits: ParabolicLimits,
    motion: ParabolicTrajectory,
    start: float,
    end: float,
    rng: np.random.Generator,
) -> tuple[ParabolicSegment, ...] | None:
    """Make two segments for the time of a stretch, via a state near the motion; joints bend if they can."""
    at = start + round((end - start) * rng.uniform(0.1, 0.9) / TICK) * TICK
    if at - start < TICK / 2 or end - at < TICK / 2:
        return None
    first, here, last = (motion.state(t) for t in (start, at, end))
    share = _NARROWEST * (_WIDEST / _NARROWEST) ** rng.random()
    middles = [perturbed_state(here, share, motion.duration, proof.space, limits, rng), here]
    direct = steer_fixed_time(first, last, limits, end - start)
    if direct is not None:
        middles.append(direct.state(at - start))
    return steer_via(first, middles, last, limits, at - start, end - at)
