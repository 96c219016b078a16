"""Check that the smallest clearance of the whole motion is proven: branch and bound over pairs and time.

The distances of every pair between two states have a lower bound (``pair_distance``). The stretch with the
lowest bound is always split next, so fcl only measures pairs that are near. When the lowest remaining bound
is as high as the smallest measured distance, nothing in the whole motion can be nearer. If two neighbouring
states do not prove the required clearance, more states in between are measured. Bounds of all pairs at once
(``broad_phase``) leave few stretches to measure with fcl.
"""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import chain, count, pairwise

import numpy as np

from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.verification.broad_phase import (
    Stretches,
    near_stretches,
    own_bounds,
    standing_near,
    state_intervals,
    tightened,
    world_bounds,
)
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.pair_distance import FINER, Pair
from pickcli.verification.solid_arrays import Indices, SolidArrays
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures

DISTANCE_CAP = 0.05  # m, larger clearances are not distinguished
RESOLUTION = 2e-4  # m, how far below the smallest measured clearance the proven one may lie
MEASUREMENT_TOLERANCE = 1e-5  # m by which a measured distance may fall short of the clearance
BOUND_TOLERANCE = 1e-4  # m by which a bound between two of the finer states may fall short of it
MAX_REASONS = 20
FIRST_BELOW = 0.002  # m, bounds lower than it are tightened first; then the limit is doubled, and so on


@dataclass(frozen=True)
class Clearance:
    """Result of the clearance check.

    Attributes:
        minimum: m, proven for all times if there are no faults; at most DISTANCE_CAP.
        reasons: Faults.
    """

    minimum: float
    reasons: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class _Occupied:
    """A segment: its states [first, last], and the indices of its moving (P,) and static (F,) solids."""

    index: int
    first: int
    last: int
    moving: Indices
    standing: Indices


def check_clearance(
    plan: Plan,
    states: States,
    moving: Sequence[tuple[Part, ...]],
    world: PlanFixtures,
    exempt: Sequence[Exemptions],
    opening_pairs: Sequence[frozenset[tuple[str, str]]] = (),
    needed: float = 0.0,
) -> Clearance:
    """Prove that all pairs keep the clearance except those planned to touch; see the module's docstring.

    Args:
        plan: The plan.
        states: The motion's states.
        moving: Parts that move in each segment.
        world: Static solids of each segment.
        exempt: Exemptions of each segment.
        opening_pairs: Pairs (part, fixture), of each segment, that are near at the start of a recovery
            motion, which ``check_opening`` follows; () if there are none.
        needed: m, the clearance that all other pairs keep.

    Returns:
        The smallest clearance, and the faults.
    """
    fixed = [world.of(k) for k in range(len(plan.segments))]
    every: dict[int, Part | Fixture] = {id(part): part for part in chain(*moving)}
    every.update((id(fixture), fixture) for fixture in chain(*fixed))
    solids, index = SolidArrays.of(every.values()), {key: i for i, key in enumerate(every)}
    near = []
    for k, segment in enumerate(plan.segments):
        first, last = states.between(segment.t_start, segment.t_end)
        own, others = (
            np.array([index[id(each)] for each in some], np.int64) for some in (moving[k], fixed[k])
        )
        opened = opening_pairs[k] if opening_pairs else frozenset()
        at = _Occupied(k, first, last, own, others)
        near.append(_near(states, solids, at, exempt[k], opened))
    return _Search(plan, states, solids, Stretches.joined(near), needed).run()


class _Search:
    """Best-first search: split the stretch with the lowest bound until the clearance is known well enough.

    Stretches with bounds below ``_below`` m have been tightened and are in a heap; the others wait.
    """

    def __init__(
        self, plan: Plan, states: States, solids: SolidArrays, near: Stretches, needed: float
    ) -> None:
        self._plan, self._states, self._solids, self._needed = plan, states, solids, needed
        self._waiting, self._below = near, 0.0
        self._heap: list[tuple[float, int, Pair, int, int, bool]] = []
        self._ticket = count()
        self._pairs: dict[tuple[int, int, int], Pair] = {}
        self._reasons: dict[tuple[int, str], Reason] = {}
        self._smallest = self._proven = DISTANCE_CAP

    def run(self) -> Clearance:
        """Return the smallest clearance, or the faults."""
        while len(self._reasons) < MAX_REASONS and self._has_lower():
            bound, _, pair, i, j, is_measured = heapq.heappop(self._heap)
            if (pair.segment, pair.names) in self._reasons:
                continue
            if not is_measured and (known := pair.known(i, j)) > bound:
                heapq.heappush(self._heap, (known, next(self._ticket), pair, i, j, False))
                continue
            cuts = (i, (i + j) // 2, j) if is_measured else (i, j)
            for start, end in pairwise(cuts):
                if not self._measure(pair, start, end):
                    break
        return Clearance(min(self._proven, self._smallest), tuple(self._reasons.values()))

    def _has_lower(self) -> bool:
        """Whether the heap's lowest bound must be split further; waiting stretches are tightened first."""
        while True:
            enough = max(self._needed, min(self._proven, self._smallest - RESOLUTION))
            lowest = self._heap[0][0] if self._heap else DISTANCE_CAP
            if lowest < min(enough, self._below):
                return True
            if self._below >= enough:
                self._proven = min(self._proven, lowest, self._waiting.bound.min(initial=DISTANCE_CAP))
                return False
            self._tighten(min(enough, max(FIRST_BELOW, self._needed, 2.0 * self._below)))

    def _tighten(self, below: float) -> None:
        floor = max(FIRST_BELOW, self._needed, self._below + RESOLUTION)
        found, below = tightened(self._waiting, below, floor, self._states, self._solids)
        self._waiting, self._below = found[found.bound >= below], below
        low = found[found.bound < below]
        columns = (low.bound, low.segment, low.a, low.b, low.first, low.last)
        for bound, k, a, b, first, last in zip(*(column.tolist() for column in columns), strict=True):
            heapq.heappush(self._heap, (bound, next(self._ticket), self._pair(k, a, b), first, last, False))

    def _pair(self, segment: int, a: int, b: int) -> Pair:
        if (segment, a, b) not in self._pairs:
            reach = self._solids.relative_reach(np.array([a]), np.array([b]))[0]
            self._pairs[segment, a, b] = Pair(segment, *self._solids.pair(a, b), self._states, reach)
        return self._pairs[segment, a, b]

    def _measure(self, pair: Pair, i: int, j: int) -> bool:
        """Measure both ends of a stretch with fcl; return False if that yields a fault."""
        needed = self._needed
        low, near = pair.bound(i, j), min(pair.distance(i), pair.distance(j))
        is_last = j <= i + 1
        if is_last and low < needed <= near:
            near, low = self._finer(pair, i)
        self._smallest = min(self._smallest, near)
        if near <= max(0.0, needed - MEASUREMENT_TOLERANCE) or (
            is_last and low <= max(0.0, needed - BOUND_TOLERANCE)
        ):
            self._reasons[pair.segment, pair.names] = _reason(self._plan, pair, (i, j), near, needed)
            return False
        if is_last:
            self._proven = min(self._proven, low)
        else:
            heapq.heappush(self._heap, (low, next(self._ticket), pair, i, j, True))
        return True

    def _finer(self, pair: Pair, i: int) -> tuple[float, float]:
        """Measure states between a state and the next; return the smallest distance and a lower bound, m.

        fcl is used only if gaps between parallel planes, which take less time, do not prove the clearance.
        """
        states, solids = self._states.finer(i, FINER), pair.solids
        one = np.zeros(FINER + 1, dtype=np.int64)
        gaps = solids.gaps(states, one, one + 1, np.arange(FINER + 1))
        low = float((gaps[:-1] + gaps[1:] - np.diff(states.travel @ pair.reach)).min()) / 2
        return (float(gaps.min()), low) if low >= self._needed else pair.finer(i)


def _reason(plan: Plan, pair: Pair, stretch: tuple[int, int], near: float, needed: float) -> Reason:
    """Describe a fault: where it is, and the depth, the distance, or that the proof does not reach.

    Args:
        plan: The plan.
        pair: The pair.
        stretch: Indices of the states at the ends of the stretch.
        near: m, smallest distance that was measured at its ends and between them.
        needed: m, the clearance.
    """
    i = min(stretch, key=pair.distance)
    where = f"segment {pair.segment} ({plan.segments[pair.segment].kind})"
    at = f"{pair.names} at {pair.states.times[i]:.3f} s"
    if pair.b.name in plan.segments[pair.segment].touching and (pair.a.is_cup or pair.a.is_held):
        at += " (named as touched, but not near where the item or the cup is at rest)"
    if pair.distance(i) <= 0.0:
        return Reason("collision", where, f"{at}, {pair.depth(i) * 1e3:.1f} mm deep")
    if near <= 0.0:
        return Reason("collision", where, f"{at}, shortly before or after")
    apart = f"{near * 1e3:.2f} mm apart"
    if near < needed:
        return Reason("too close", where, f"{at}, {apart}, {needed * 1e3:.1f} mm are kept")
    return Reason("too close to prove", where, f"{at}, {apart}")


def _near(
    states: States,
    solids: SolidArrays,
    at: _Occupied,
    exempt: Exemptions,
    opening_pairs: frozenset[tuple[str, str]],
) -> Stretches:
    """Return every stretch of a segment in which a tested pair may come nearer than DISTANCE_CAP.

    Args:
        states: The motion's states.
        solids: The plan's solids.
        at: The segment.
        exempt: Pairs that are not tested.
        opening_pairs: Pairs (part, fixture) that ``check_opening`` follows.
    """

    def is_world_pair_tested(a: Part, b: Part | Fixture) -> bool:
        if isinstance(b, Fixture) and b.is_wall:  # of the hollow that the tool is in: nothing may touch it
            return bool(a.reach.any())
        return (a.name, b.name) not in opening_pairs and not exempt.is_world_pair_untested(a, b.name)

    def is_own_pair_tested(a: Part, b: Part | Fixture) -> bool:
        return isinstance(b, Part) and not exempt.is_own_pair_untested(a, b)

    cut = state_intervals(states, at.first, at.last, solids.reach[at.moving].max(axis=0))
    standing = standing_near(states, solids, at.moving, at.standing, cut, DISTANCE_CAP)
    bounds = world_bounds(states, solids, at.moving, standing, cut).reshape(len(cut.middle), -1)
    a, b = (index.ravel() for index in np.meshgrid(at.moving, standing, indexing="ij"))
    world = near_stretches(bounds, at.index, a, b, cut, DISTANCE_CAP)
    a, b = (at.moving[index] for index in np.triu_indices(len(at.moving), 1))
    own = near_stretches(own_bounds(states, solids, at.moving, cut), at.index, a, b, cut, DISTANCE_CAP)
    return Stretches.joined(
        [_tested(world, solids, is_world_pair_tested), _tested(own, solids, is_own_pair_tested)]
    )


def _tested(
    stretches: Stretches, solids: SolidArrays, is_tested: Callable[[Part, Part | Fixture], bool]
) -> Stretches:
    """Return the stretches of pairs that are tested; ``is_tested`` is called once for each pair."""
    keys, which = np.unique(stretches.a * len(solids.solids) + stretches.b, return_inverse=True)
    pairs = (solids.pair(*divmod(key, len(solids.solids))) for key in keys.tolist())
    return stretches[np.fromiter((is_tested(*pair) for pair in pairs), dtype=bool, count=len(keys))[which]]
