"""Counts over sampled configurations whether pairs of links collide always, sometimes or never.

MoveIt's Setup Assistant samples in the same way, but the result is used differently. Pairs that never
collided in the sample are still checked: a sample proves nothing, and checks cost little. Only pairs that
collide in every sample are allowed, with the counts as reason, since otherwise nothing could be planned.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import AllowedPair, Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.collision_world import KERNEL_KINDS
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kernel import Checker
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.seeds import derived_rng
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses

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
    model, robot, clearance = CollisionModel(cell), cell.robot, cell.clearance + COARSE_RESERVE
    Q = Arm(robot).random_seeds(derived_rng(seed, "collisions of links"), N_SPHERES)
    poses = link_poses(robot, Q[:N_SHAPES])
    found = []
    for a, b, checker in (*_with_base(model), *_moving(model)):
        spheres = _spheres_colliding(checker, Q, clearance)
        shapes, least, most = None, np.inf, np.inf
        if spheres is CollisionFrequency.ALWAYS:
            distances = _distances(cell, a, b, poses)
            shapes = _frequency(distances <= clearance)
            least, most = float(distances.min()), float(distances.max())
        found.append(CollisionCount(a, b, spheres, shapes, least, most, clearance))
    return found


def _moving(model: CollisionModel) -> Iterator[tuple[str, str, Checker]]:
    """Pairs of links that move relative to each other, with a checker for each pair."""
    robot, names = model.state(model.robot.tool.default_state), model.frame_names
    for i, j in robot.self_pairs.tolist():
        yield names[i], names[j], robot.of_frames([i, j])


def _with_base(model: CollisionModel) -> Iterator[tuple[str, str, Checker]]:
    """Pairs of a static and a moving link, with a checker for each pair."""
    robot, solids = model.state(model.robot.tool.default_state), dict[str, list[tuple[Array, Shape]]]()
    for link, T, body in model.static_bodies():
        solids.setdefault(link, []).append((T @ body.T_parent_shape, body.shape))
    for link, T, radius in model.static_spheres():
        solids.setdefault(link, []).append((T, Shape(ShapeKind.SPHERE, (radius,))))
    for frame in np.unique(robot.spheres.frames).tolist():
        name = model.frame_names[frame]
        for link, standing in solids.items():
            if not model.are_joined(link, name) and not model.is_allowed(link, name):
                checker = robot.of_frames([frame])
                _surround(checker, standing)
                yield link, name, checker


def _surround(checker: Checker, solids: Sequence[tuple[Array, Shape]]) -> None:
    """Set the world of a checker to solids at poses (4, 4)."""
    checker.set_world(
        np.array([T for T, _ in solids]),
        np.array([shape.extents / 2 for _, shape in solids]),
        np.zeros(len(solids), dtype=np.uint64),
        np.array([KERNEL_KINDS[shape.kind] for _, shape in solids], dtype=np.int32),
    )


def _spheres_colliding(checker: Checker, Q: Array, clearance: float) -> CollisionFrequency:
    """Frequency of clearance violations over Q (N, n)."""
    collides = ~checker.are_free(Q[:N_FIRST], clearance)
    if 0 < np.count_nonzero(collides) < N_FIRST:
        return CollisionFrequency.SOMETIMES
    return _frequency(~checker.are_free(Q, clearance))


def _distances(cell: Cell, a: str, b: str, poses: Array) -> Array:
    """Distances (N,) in m between the shapes of two links, at link poses (L, N, 4, 4)."""
    names = [link.name for link in cell.robot.links]
    one, other = (
        [(Solid(body.shape), body, names.index(name)) for body in cell.robot.link(name).bodies]
        for name in (a, b)
    )
    distances = []
    for k in range(poses.shape[1]):
        for solid, body, link in (*one, *other):
            solid.place(poses[link, k] @ body.T_parent_shape)
        distances.append(min(first.distance(second) for first, _, _ in one for second, _, _ in other))
    return np.array(distances)


def _frequency(collides: NDArray[np.bool_]) -> CollisionFrequency:
    if collides.all():
        return CollisionFrequency.ALWAYS
    return CollisionFrequency.SOMETIMES if collides.any() else CollisionFrequency.NEVER
