"""Anytime search for the fastest free motion between two configurations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol, TypeVar

import numpy as np

from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array
from pickcli.kernel import (
    JointState,
    ParabolicLimits,
    ParabolicSegment,
    ParabolicTrajectory,
    steer_min_time,
)
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.seeds import derived_seed
from pickcli.trajopt.collision_descent import CollisionDepth, descend_collisions
from pickcli.trajopt.parabolic_segment import resting_segment, straight_segment, ticks_up
from pickcli.trajopt.time_shortcutting import shortcut_time
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.trajopt.trajectory_validator import TrajectoryValidator

_CALM = 1.002  # times the least duration: limit for the straight line, which is the calmest motion
_LADDER = (1.01, 1.03, 1.06, 1.1, 1.15, 1.25, 1.5)  # durations of collision descents, times the least
_CLEARANCE_GAIN = 0.002  # m of clearance beyond the checker's margin that collision descent aims at


class HasDuration(Protocol):
    """Something with a duration, which a search minimises."""

    @property
    def duration(self) -> float:
        """Duration of the motion, s."""


T = TypeVar("T", bound=HasDuration)


@dataclass(frozen=True, eq=False)
class MinimumTimeSearch:
    """One search between two free configurations, for one collision checker.

    Attributes:
        proof: Validator that every motion has to pass.
        checker: Collision checker of the same scene, for planning and clearances.
        limits: Velocity, acceleration and jerk limits.
        ends: Start and goal configuration, (n,) each.
        settings: Effort of the search.
    """

    proof: TrajectoryValidator
    checker: SceneChecker
    limits: ParabolicLimits
    ends: tuple[Array, Array]
    settings: TrajectorySettings

    def minimum_time(
        self,
        seed: int,
        finish: Callable[[ParabolicTrajectory], T | None],
        good_enough: float,
        shorter_than: float = np.inf,
        max_duration: float = np.inf,
    ) -> T | None:
        """Find the fastest motion that passes a final test. Repeatable by seed.

        Args:
            seed: Seed of all random choices.
            finish: Turns a candidate into its final form, or returns None if it fails the final test. The
                final form takes at least a pause longer than the candidate.
            good_enough: s; a motion that takes no longer ends the search.
            shorter_than: s; candidates whose final form takes at least as long are skipped.
            max_duration: s; candidates that take longer are skipped.

        Returns:
            The final form of the fastest motion found, or None.
        """
        best: T | None = None

        def is_wanted(duration: float) -> bool:
            limit = shorter_than if best is None else best.duration
            return duration + self.limits.pause < limit and duration <= max_duration

        for motion in self.motions(seed, is_wanted):
            made = finish(motion) if is_wanted(motion.duration) else None
            if made is not None and (best is None or made.duration < best.duration):
                best = made
            if best is not None and best.duration <= good_enough:
                break
        return best

    def motions(self, seed: int, is_wanted: Callable[[float], bool]) -> Iterator[ParabolicTrajectory]:
        """Yield proven motions, the most promising first. Repeatable by seed.

        Later motions are only useful if the earlier ones are slow or fail a later test.

        Args:
            seed: Seed of all random choices.
            is_wanted: Whether a motion of a given duration (s) is still worth searching for.

        Yields:
            Proven parabolic trajectories between the ends.
        """
        line = ParabolicTrajectory((straight_segment(*self.ends, self.limits),))
        is_line_free = self.proof.is_valid(line.segments)
        if is_line_free and line.duration <= _CALM * self.least:
            yield line
        if self.proof.is_valid(self._direct.segments):
            yield self._direct
        found: list[ParabolicTrajectory] = []
        for motion in self._searched(seed, is_line_free, is_wanted):
            found.append(motion)
            yield motion
        for again in range(self.settings.n_repeats):
            if not found or not is_wanted(_LADDER[0] * self.least):
                return
            best = min(found, key=lambda motion: motion.total(self.limits))
            found.append(self._shortcut_in_time(best, derived_seed(seed, "again", again)))
            yield found[-1]

    def _searched(
        self, seed: int, is_line_free: bool, is_wanted: Callable[[float], bool]
    ) -> Iterator[ParabolicTrajectory]:
        """Yield results of collision descent in the least time, the planner, and descents in more time."""
        yield from self._pressed(seed, 1.0)
        if is_line_free:
            yield self._shortcut_in_time(
                ParabolicTrajectory((straight_segment(*self.ends, self.limits),)), seed
            )
        if is_wanted(_LADDER[-1] * self.least):
            yield from self._planned(seed)
        for factor in _LADDER:
            if is_wanted(factor * self.least):
                yield from self._pressed(seed, factor)

    @cached_property
    def _direct(self) -> ParabolicTrajectory:
        """The motion in which every joint moves independently, in the time of the slowest."""
        segment = steer_min_time(
            JointState.at_rest(self.ends[0]), JointState.at_rest(self.ends[1]), self.limits, np.inf
        )
        assert segment is not None  # it always exists from rest to rest
        return ParabolicTrajectory((segment,))

    @property
    def least(self) -> float:
        """Duration (s) of the motion in which every joint moves independently.

        This is the time of the slowest joint, or up to 32 ticks more if another joint has no segment of
        exactly that time (see ``steer_min_time``).
        """
        return self._direct.duration

    def _pressed(self, seed: int, factor: float) -> Iterator[ParabolicTrajectory]:
        """Yield at most one motion: bent until free in ``factor`` times the least duration, then shortcut."""
        for attempt in range(self.settings.n_descents):
            own = derived_seed(seed, "press", factor, attempt)
            motion = descend_collisions(
                self.proof, self._depth, self.limits, self.ends, float(ticks_up(factor * self.least)),
                seed=own, iterations=self.settings.n_perturbations,
            )  # fmt: skip
            if motion is not None:
                yield self._shortcut_in_time(motion, own)
                return

    @property
    def _depth(self) -> CollisionDepth:
        return CollisionDepth(self._clearances, self.checker.margin + _CLEARANCE_GAIN, self.proof.space)

    def _clearances(self, Q: Array) -> Array:
        return self.checker.clearances(Q, self.checker.margin + _CLEARANCE_GAIN)

    def _planned(self, seed: int) -> Iterator[ParabolicTrajectory]:
        """Yield paths of the planner, shortened, with stops at the corners that shortcutting removes."""
        for attempt in range(self.settings.n_tries):
            own = derived_seed(seed, "try", attempt)
            options = PlannerOptions(self.settings.planner, self.settings.max_iterations)
            path = plan(
                self.checker, self.proof.space, self.ends[0], self.ends[1][None], seed=own, options=options
            )
            if path is not None:
                short = shorten(
                    self.checker, self.proof.space, path, seed=own, iterations=self.settings.n_shortcuts
                )
                yield self._shortcut_in_time(ParabolicTrajectory(self._stopping(short.waypoints)), own)

    def _stopping(self, waypoints: Array) -> tuple[ParabolicSegment, ...]:
        """Return straight segments with rests between them, long enough for the jerk limits."""
        segments: list[ParabolicSegment] = []
        for a, b in pairwise(waypoints):
            segments += [straight_segment(a, b, self.limits), resting_segment(b, self.limits.pause)]
        return tuple(segments[:-1])

    def _shortcut_in_time(self, motion: ParabolicTrajectory, seed: int) -> ParabolicTrajectory:
        return shortcut_time(
            self.proof, self.limits, motion, self.least,
            seed=derived_seed(seed, "quicken"), iterations=self.settings.n_final_shortcuts,
        )  # fmt: skip
