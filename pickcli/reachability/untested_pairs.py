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
N_DEPTHS = 10  # of those in which shapes collide: measured in depth
ALWAYS = 0.9  # share from which a pair counts as always colliding: MoveIt's 0.95, less the error of a sample
LEAST_DEPTH = 1e-3  # m; meshes are no truer than that

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
        free = Q_state[checker(tested, state, PayloadClass.EMPTY).are_valid(Q_state)]
        for pair in link_pairs(every, state, silent) if len(free) else ():
            found = _measured(cell, pair, silent[frozenset((pair.a, pair.b))], free, state)
            if found is not None:
                yield found


def _measured(
    cell: Cell, pair: LinkPair, stated: AllowedPair, free: Array, state: ToolState
) -> UntestedPair | None:
    """Measure where two links collide in free configurations (N, n); None if they nowhere do."""
    near = free[~pair.checker.are_free(free, 0.0)]
    if not len(near):
        return None
    deepest = near[np.argsort(pair.checker.clearances(near), kind="stable")[:N_MEASURED]]
    even = near[np.unique(np.linspace(0, len(near) - 1, N_MEASURED).astype(int))]
    shapes = [LinkShapes(cell.robot, Q, state) for Q in (deepest, even)]
    overlap = [each.overlap(pair.a, pair.b) for each in shapes]
    collide = [
        _collide(cell, pair, Q, state, which) for Q, which in zip((deepest, even), overlap, strict=True)
    ]
    share, pieces = (
        max(float(of_even.mean()) * len(near), float(of_deepest.sum())) / len(free)
        for of_deepest, of_even in (collide, overlap)
    )
    of = collide if share else overlap
    met = np.vstack([deepest[of[0]], even[of[1]]])[: N_DEPTHS if share < ALWAYS else 1]
    if not len(met):
        return None
    depths = LinkShapes(cell.robot, met, state).depths(pair.a, pair.b)
    worst = int(np.argmax(depths))
    if depths[worst] < LEAST_DEPTH:
        return None
    arm = ArmState(cell.arm, met[worst], state)
    return UntestedPair(stated, share, pieces, float(depths[worst]), arm, ())


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
