"""Finds links that nothing tests against each other although they collide: allowed pairs of a cell or SRDF.

A disabled pair is trusted by planner and verifier alike, so that a wrong one lets real self-collisions pass.
As in MoveIt's Setup Assistant, configurations are sampled uniformly within the limits, and meshes collide
where their triangles do. What counts are configurations that every test that is not disabled would pass.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.cell import SRDF_REASON, AllowedPair, ArmState, Cell
from pickcli.cell.station import NO_POD, Obstacles
from pickcli.cell.tool import ToolState
from pickcli.cell.workcell import Workcell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.link_pairs import LinkPair, link_pairs
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_rng
from pickcli.verification.link_shapes import LinkShapes

N_SAMPLES = 10_000  # configurations, as MoveIt's Setup Assistant takes by default
N_STANDING = 8  # states of other arms, among which the samples of pairs between arms are divided
N_MEASURED = 100  # of those in which spheres collide: measured for the share, and as many for the depth
N_DEPTHS = 5  # of those in which shapes collide: measured in depth
ALWAYS = 0.9  # share from which a pair counts as always colliding: MoveIt's 0.95, less the error of a sample
LEAST_DEPTH = 1e-3  # m; meshes are no truer than that

# Search for collisions too rare for the sample, from its configurations in which the spheres are nearest.
NEAR = 0.05  # m, largest distance of the spheres in which it begins
N_ROUNDS, N_BEST, N_AROUND = 3, 16, 32  # rounds; nearest configurations in each; samples around each of them
SPREAD = 0.02  # standard deviation of these, as a share of each joint's range

# What a reason that MoveIt's Setup Assistant writes into an SRDF means if the two collide all the same.
_MEANT = {
    "Never": "the sample that never met it was too small, or robot, tool or limits have changed since",
    "Default": "it was disabled because they overlap in the default pose, which says nothing of others",
    "Adjacent": "in this URDF no joint connects them",
    "Always": "when it was made they always collided: shapes or limits have changed since",
    "User": "it was disabled by hand",
}


@dataclass(frozen=True, eq=False)
class UntestedPair:
    """Two links that are never tested against each other, and collide.

    Attributes:
        pair: The allowed pair.
        share: Share of the configurations free of all other self-collisions in which the two collide; meshes
            count where their triangles meet.
        pieces: Share of these in which their shapes overlap as the verifier has them: the convex pieces of
            meshes.
        depth: m, of the deepest overlap found.
        arm: State of the arm in the deepest overlap found.
        others: States of the other arms in it, if not parked.
    """

    pair: AllowedPair
    share: float
    pieces: float
    depth: float
    arm: ArmState
    others: tuple[ArmState, ...]

    @property
    def names(self) -> frozenset[str]:
        """Names of the two links."""
        return frozenset((self.pair.a, self.pair.b))

    @property
    def is_sometimes(self) -> bool:
        """Whether the two collide in some configurations, but not in nearly all as what touches by design."""
        return 0.0 < self.share < ALWAYS

    @property
    def is_hidden(self) -> bool:
        """Whether only convex pieces overlap, so often that no test could tell the meshes apart."""
        return self.share == 0.0 and self.pieces >= ALWAYS

    @property
    def text(self) -> str:
        """How often the two collide and how deep, what was probably meant, and what to do."""
        names, reason = f"{self.pair.a} and {self.pair.b}", self.pair.reason.removeprefix(SRDF_REASON)
        often = f"{self.share:.0%}" if self.share >= 0.01 else f"1 of {1 / self.share:.0f}"
        at = " and ".join(_text(state) for state in (self.arm, *self.others))
        meant = f"; {_MEANT[reason]}" if self.pair.srdf is not None and reason in _MEANT else ""
        return (
            f"{names} are not tested against each other ({reason}), but collide in {often} of the "
            f"configurations that pass all other tests, up to {1e3 * self.depth:.0f} mm deep, e.g. at "
            f"{at}{meant}; {self._advice}"
        )

    @property
    def _advice(self) -> str:
        if self.pieces < ALWAYS:
            return "delete the pair, or use smaller shapes if the real links are apart there"
        return (
            "no test tells them apart, as convex pieces of their meshes overlap in all configurations: cut "
            "these into more convex parts, each with its own <collision>, and delete the pair"
        )


def _text(state: ArmState) -> str:
    """Format the state of an arm as the command line has it."""
    numbers = ",".join(f"{value + 0.0:.3f}" for value in state.q.tolist())
    return f"{state.arm}={numbers}" if state.arm else numbers


def overlap_note(found: Sequence[UntestedPair]) -> str | None:
    """Say which links nothing tests because convex pieces of their meshes overlap in all configurations.

    Args:
        found: Untested pairs of a cell.

    Returns:
        The note; None without such a pair.
    """
    pairs = [f"{each.pair.a} and {each.pair.b}" for each in found if each.is_hidden]
    if not pairs:
        return None
    return (
        f"nothing tests {', '.join(pairs)}: convex pieces of their meshes overlap in all configurations, the "
        f"meshes in none of {2 * N_MEASURED} measured ones; if these can collide, cut them into more convex "
        "parts, each with its own <collision> in the URDF, and delete the pair"
    )


def untested_pairs(cell: Cell, seed: int = 0) -> list[UntestedPair]:
    """Find the allowed pairs of links that collide in sampled or named configurations.

    Args:
        cell: The cell.
        seed: Seed of the configurations.

    Returns:
        The pairs, in the order of the cell's. Neighbouring links, which no command tests anyway, are left
        out, and so are pairs that the verifier tests.
    """
    return _worst(cell, _colliding(cell, _silent(cell), seed, N_SAMPLES))


def untested_pairs_of_arms(workcell: Workcell, seed: int = 0) -> list[UntestedPair]:
    """Find the allowed pairs of links that collide, those between two arms included.

    Args:
        workcell: The cell with all its arms.
        seed: Seed of the configurations.

    Returns:
        The pairs, in the order of the cell's, each with the arm for which it collides most often.
    """
    found = [each for cell in workcell.arms.values() for each in untested_pairs(cell, seed)]
    arms = list(workcell.arms.items())
    for k, (arm, cell) in enumerate(arms):
        elsewhere = frozenset[str]().union(*(_moving_links(other) for _, other in arms[k + 1 :]))
        own, silent = _moving_links(cell) - elsewhere, _silent(cell)
        between = {names: pair for names, pair in silent.items() if names & own and names & elsewhere}
        standing = [_free_states(other, seed) for _, other in arms[k + 1 :]] if between else []
        for states in zip(*standing, strict=False):
            beside = workcell.cell(arm, states)
            met = _colliding(beside, between, seed, N_SAMPLES // N_STANDING)
            found += [replace(each, others=beside.others) for each in met]
    return _worst(workcell.preferred, found)


def _silent(cell: Cell) -> dict[frozenset[str], AllowedPair]:
    """Return the first pair of each two links that neither planner nor verifier tests, by their names."""
    links = {link.name for link in cell.robot.links}
    silent: dict[frozenset[str], AllowedPair] = {}
    for pair in cell.allowed_pairs:
        if not pair.verified and {pair.a, pair.b} <= links:
            silent.setdefault(frozenset((pair.a, pair.b)), pair)
    return silent


def _worst(cell: Cell, found: Iterable[UntestedPair]) -> list[UntestedPair]:
    """Return of each two links the finding with the largest share, in the order of the cell's pairs."""
    worst: dict[frozenset[str], UntestedPair] = {}
    for each in found:
        known = worst.setdefault(each.names, each)
        if each.share > known.share:
            worst[each.names] = each
    order = dict.fromkeys(frozenset((pair.a, pair.b)) for pair in cell.allowed_pairs)
    return [worst[names] for names in order if names in worst]


def _moving_links(cell: Cell) -> frozenset[str]:
    """Return the links that the arm of a cell moves."""
    model = CollisionModel(cell)
    return frozenset(name for name, body in zip(model.frame_names, model.bodies, strict=True) if body > 0)


def _free_states(cell: Cell, seed: int) -> list[ArmState]:
    """Return a few states of an arm that are free of self-collisions, the others parked."""
    state, model = cell.robot.tool.default_state, CollisionModel(_alone(cell))
    Q = Arm(cell.robot).random_seeds(derived_rng(seed, "where another arm stands"), 10 * N_STANDING)
    free = Q[checker(model, state, PayloadClass.EMPTY).are_valid(Q)]
    return [ArmState(cell.arm, q, state) for q in free[:N_STANDING]]


def _alone(cell: Cell) -> Cell:
    """Return the cell without anything around its robot."""
    return replace(cell, pod=NO_POD, tote=None, own_carriers=(), obstacles=Obstacles(()))


def _colliding(
    cell: Cell, silent: dict[frozenset[str], AllowedPair], seed: int, n: int
) -> Iterator[UntestedPair]:
    """Yield the pairs that collide, in each state of the tool, in named or n sampled configurations."""
    if not silent:
        return
    tested, every = CollisionModel(_alone(cell)), CollisionModel(replace(_alone(cell), allowed_pairs=()))
    Q = Arm(cell.robot).random_seeds(derived_rng(seed, "collisions of links"), n)
    for state in cell.robot.tool.states:
        named = [each.q for each in cell.configurations.values() if each.tool_state == state]
        Q_state = np.vstack([*named, Q])
        others = checker(tested, state, PayloadClass.EMPTY)
        free = Q_state[others.are_valid(Q_state)]
        for pair in link_pairs(every, state, silent) if len(free) else ():
            met = _Contacts.of(cell, pair, state, free[~pair.checker.are_free(free, 0.0)])
            share, pieces = met.n_colliding / len(free), met.n_overlapping / len(free)
            if not share and pieces < ALWAYS and met.n_near < N_MEASURED:
                rng = derived_rng(seed, "collisions of links", pair.a, pair.b)
                met = _Contacts.of(cell, pair, state, _approached(pair, free, others, rng))
                share, pieces = (min(n, 1.0) / len(free) for n in (met.n_colliding, met.n_overlapping))
            depth, q = met.deepest(N_DEPTHS if share < ALWAYS else 1)
            if depth >= LEAST_DEPTH:
                stated = silent[frozenset((pair.a, pair.b))]
                yield UntestedPair(stated, share, pieces, depth, ArmState(cell.arm, q, state), ())


def _approached(pair: LinkPair, free: Array, others: SceneChecker, rng: np.random.Generator) -> Array:
    """Search near free configurations (N, n) for some (K, n) in which the spheres of two links collide.

    All of them pass all other tests, ``others``, and stay within the ranges of the free ones.
    """
    lower, upper = free.min(axis=0), free.max(axis=0)
    found = free[~pair.checker.are_free(free, NEAR)]
    for _ in range(N_ROUNDS if len(found) else 0):
        best = found[np.argsort(pair.checker.clearances(found, NEAR), kind="stable")[:N_BEST]]
        around = np.repeat(best, N_AROUND, axis=0)
        around = np.clip(around + rng.normal(size=around.shape) * SPREAD * (upper - lower), lower, upper)
        found = np.vstack([best, around[others.are_valid(around)]])
    return found[~pair.checker.are_free(found, 0.0)] if len(found) else found


@dataclass(frozen=True, eq=False)
class _Contacts:
    """Where two links overlap and collide, measured in some of the configurations where their spheres do.

    Attributes:
        cell: The cell.
        pair: The links.
        tool_state: State of the tool.
        n_near: Number of configurations in which their spheres collide.
        n_overlapping: Estimated number of these in which their shapes overlap: convex pieces of meshes.
        n_colliding: Estimated number of these in which they collide: meshes by their triangles.
        Q: (K, n) configurations in which they collide, else those in which they overlap; the deepest first,
            by their spheres.
    """

    cell: Cell
    pair: LinkPair
    tool_state: ToolState
    n_near: int
    n_overlapping: float
    n_colliding: float
    Q: Array

    @classmethod
    def of(cls, cell: Cell, pair: LinkPair, state: ToolState, near: Array) -> _Contacts:
        """Measure the deepest of the configurations near (N, n), and as many spread evenly over all."""
        if not len(near):
            return cls(cell, pair, state, 0, 0.0, 0.0, near)
        deepest = near[np.argsort(pair.checker.clearances(near), kind="stable")[:N_MEASURED]]
        even = near[np.unique(np.linspace(0, len(near) - 1, N_MEASURED).astype(int))]
        overlap = [LinkShapes(cell.robot, Q, state).overlap(pair.a, pair.b) for Q in (deepest, even)]
        collide = [
            _collide(cell, pair, Q, state, which) for Q, which in zip((deepest, even), overlap, strict=True)
        ]
        n_colliding, n_overlapping = (
            max(float(of_even.mean()) * len(near), float(of_deepest.sum()))
            for of_deepest, of_even in (collide, overlap)
        )
        of = collide if n_colliding else overlap
        Q = np.vstack([deepest[of[0]], even[of[1]]])
        return cls(cell, pair, state, len(near), n_overlapping, n_colliding, Q)

    def deepest(self, n: int) -> tuple[float, Array]:
        """The greatest depth in m in the first n of ``Q``, 0 without any, and its configuration (n,)."""
        if not len(self.Q):
            return 0.0, self.cell.robot.limits.window[0]
        depths = LinkShapes(self.cell.robot, self.Q[:n], self.tool_state).depths(self.pair.a, self.pair.b)
        worst = int(np.argmax(depths))
        return float(depths[worst]), self.Q[worst]


def _collide(
    cell: Cell, pair: LinkPair, Q: Array, state: ToolState, overlap: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Return where in Q (N, n) two links collide, whose shapes overlap in some (N,): meshes by triangles."""
    bodies = (*cell.robot.link(pair.a).bodies, *cell.robot.link(pair.b).bodies)
    if not overlap.any() or all(body.piece_of is None for body in bodies):
        return overlap
    found = overlap.copy()
    found[overlap] = LinkShapes(cell.robot, Q[overlap], state).touch(pair.a, pair.b)
    return found
