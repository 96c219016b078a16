"""Counts over sampled configurations whether pairs of links collide always, sometimes or never.

MoveIt's Setup Assistant samples in the same way, but the result is used differently. Pairs that never
collided in the sample are still checked: a sample proves nothing, and checks cost little. Only pairs that
collide in every sample are allowed, with the counts as reason, since otherwise nothing could be planned.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import AllowedPair, Cell
from pickcli.collision.link_pairs import link_pairs
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kernel import Checker
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.seeds import derived_rng
from pickcli.verification.link_shapes import LinkShapes

N_SPHERES = 10_000  # configurations for tests of spheres
N_FIRST = 500  # of these, tested first, which suffice for most pairs that collide sometimes
N_SHAPES = 200  # of these, for measurements of shapes


class CollisionFrequency(StrEnum):
    """How often two links are closer than the clearance of coarse motions."""

    ALWAYS = "always"
    SOMETIMES = "sometimes"
    NEVER = "never"


@dataclass(frozen=True)
class CollisionCount:
    """Collision frequency of two links at the clearance of coarse motions.

    Attributes:
        a: Name of one link.
        b: Name of the other.
        spheres: Frequency for their spheres, which planning uses.
        shapes: Frequency for their shapes, which the verifier uses; None if not measured.
        least: m, smallest measured distance of the shapes.
        most: m, greatest one.
        clearance: m, clearance of the cell plus the planning reserve.
    """

    a: str
    b: str
    spheres: CollisionFrequency
    shapes: CollisionFrequency | None
    least: float
    most: float
    clearance: float

    @property
    def allowed(self) -> AllowedPair | None:
        """The allowed pair that planning requires; None if it requires none."""
        if self.spheres is not CollisionFrequency.ALWAYS:
            return None
        near = f"{1e3 * self.clearance:g} mm"
        if self.shapes is CollisionFrequency.ALWAYS:
            reason = f"within {near} of each other in all of {N_SHAPES} sampled configurations"
            return AllowedPair(self.a, self.b, reason, self._is_verified)
        some = "in none" if self.shapes is CollisionFrequency.NEVER else "in some"
        apart = "" if self.is_doubtful else f", {1e3 * self.least:.1f} mm apart at least"
        reason = (
            f"spheres within {near} of each other in all of {N_SPHERES} sampled configurations, "
            f"shapes {some}{apart}"
        )
        return AllowedPair(self.a, self.b, reason, self._is_verified)

    @property
    def is_doubtful(self) -> bool:
        """Whether the pair is never tested although its shapes collide only in some configurations."""
        return self.spheres is CollisionFrequency.ALWAYS and self.least <= 0.0 < self.most

    @property
    def _is_verified(self) -> bool:
        """Whether the shapes keep the cell's clearance in all samples, so that the verifier can test them."""
        return self.least >= self.clearance - COARSE_RESERVE


def count_collisions(cell: Cell, seed: int) -> list[CollisionCount]:
    """Count over sampled configurations how often links collide.

    Args:
        cell: The cell, whose allowed pairs are left out.
        seed: Seed of the configurations.

    Returns:
        Counts for every pair of links that planning checks, base first.
    """
    robot, clearance = cell.robot, cell.clearance + COARSE_RESERVE
    state = robot.tool.default_state
    Q = Arm(robot).random_seeds(derived_rng(seed, "collisions of links"), N_SPHERES)
    measured = LinkShapes(robot, Q[:N_SHAPES], state)
    found = []
    for pair in link_pairs(CollisionModel(cell), state):
        spheres = _spheres_colliding(pair.checker, Q, clearance)
        shapes, least, most = None, np.inf, np.inf
        if spheres is CollisionFrequency.ALWAYS:
            distances = measured.distances(pair.a, pair.b)
            shapes = _frequency(distances <= clearance)
            least, most = float(distances.min()), float(distances.max())
        found.append(CollisionCount(pair.a, pair.b, spheres, shapes, least, most, clearance))
    return found


def _spheres_colliding(checker: Checker, Q: Array, clearance: float) -> CollisionFrequency:
    """Frequency of clearance violations over Q (N, n)."""
    collides = ~checker.are_free(Q[:N_FIRST], clearance)
    if 0 < np.count_nonzero(collides) < N_FIRST:
        return CollisionFrequency.SOMETIMES
    return _frequency(~checker.are_free(Q, clearance))


def _frequency(collides: NDArray[np.bool_]) -> CollisionFrequency:
    if collides.all():
        return CollisionFrequency.ALWAYS
    return CollisionFrequency.SOMETIMES if collides.any() else CollisionFrequency.NEVER
