"""The smallest clearance of the whole motion, proven: branch and bound over pairs and time.

Between two states a and b of a pair whose distances are d_a and d_b, and which moves at most w relative
to each other in between, no distance is below (d_a + d_b - w) / 2 (Piyavskii and Shubert's bound for
Lipschitz functions). The stretch with the lowest bound is always split next, so fcl is asked only where
things are near, and when the lowest bound left is as high as the smallest distance measured, nothing in
the whole motion can be nearer. Where two neighbouring states do not prove the clearance that is kept, more
are looked at in between. Bounds of all pairs at once (``broad_phase``) leave few stretches to ask fcl about.
"""

from __future__ import annotations

import heapq
from bisect import bisect_left, bisect_right, insort
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, count, pairwise

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.verification.broad_phase import (
    Stretches,
    near_stretches,
    own_bounds,
    state_intervals,
    tightened,
    world_bounds,
)
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.solid_arrays import Indices, SolidArrays
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import PlanFixtures

FAR = 0.05  # m, clearances beyond it are not told apart
RESOLUTION = 2e-4  # m, how far below the smallest measured clearance the proven one may lie
FINER = 16  # parts into which a stretch between two states is cut where they do not prove the clearance
ROUNDING = 1e-5  # m by which a measured distance may fall short of the clearance
UNPROVEN = 1e-4  # m by which a bound between two of the finer states may
MAX_REASONS = 20
FIRST_BELOW = 0.002  # m, bounds lower than it are the first to be tightened; then twice as much, and so on


@dataclass(eq=False)
class Pair:
    """Two solids, at least one of which moves, over the states of one segment.

    Attributes:
        segment: Index of the segment.
        a: The solid that moves.
        b: The other, which may move, too.
        states: The motion's states.
        reach: (n,) m per unit of each joint, of one relative to the other.
        measured: Exact distances in m, by state.
    """

    segment: int
    a: Part
    b: Part | Fixture
    states: States
    reach: Array
    measured: dict[int, float] = field(default_factory=dict)
    _order: list[int] = field(default_factory=list)  # of the states that were measured

    @cached_property
    def travel(self) -> Array:
        """(N,) m, an upper bound of how far the two moved relative to each other up to each state."""
        return np.asarray(self.states.travel @ self.reach)

    @property
    def names(self) -> str:
        """Both names, for people."""
        return f"{self.a.name} and {self.b.name}"

    def distance(self, i: int) -> float:
        """Exact distance at a state.

        Args:
            i: Index of the state.

        Returns:
            m; 0 where they touch or overlap.
        """
        if i not in self.measured:
            self._place(i)
            slack = self.a.slack + self.b.slack
            self.measured[i] = max(0.0, self.a.solid.distance(self.b.solid) - slack)
            insort(self._order, i)
        return self.measured[i]

    def depth(self, i: int) -> float:
        """Depth of overlap at a state.

        Args:
            i: Index of the state.

        Returns:
            m.
        """
        self._place(i)
        inside = self.a.solid.depth(self.b.solid) or -self.a.solid.distance(self.b.solid)
        return inside + self.a.slack + self.b.slack

    def _place(self, i: int) -> None:
        for part in (self.a, self.b):
            if isinstance(part, Part):
                part.solid.place(self.states.links[part.link, i] @ part.T_link_shape)

    def bound(self, i: int, j: int) -> float:
        """Lower bound of all distances between two states.

        Args:
            i: Index of the one state.
            j: Index of the other.

        Returns:
            m.
        """
        way = float(self.travel[j] - self.travel[i])
        return (self.distance(i) + self.distance(j) - way) / 2

    def known(self, i: int, j: int) -> float:
        """Lower bound of all distances between two states, from what was measured around them.

        Args:
            i: Index of the one state.
            j: Index of the other.

        Returns:
            m; -infinity where nothing was measured.
        """
        begin, end = bisect_right(self._order, i), bisect_left(self._order, j)
        before, after = self._order[max(begin - 1, 0) : begin], self._order[end : end + 1]
        bounds = [self.measured[k] - float(self.travel[j] - self.travel[k]) for k in before]
        bounds += [self.measured[k] - float(self.travel[k] - self.travel[i]) for k in after]
        bounds += [self.bound(k, m) for k in before for m in after]
        return max(bounds, default=-np.inf)

    def finer(self, i: int) -> tuple[float, float]:
        """The smallest distance between a state and the next, measured at more states in between.

        Args:
            i: Index of the first state.

        Returns:
            The smallest distance that was measured, and a lower bound of all, m.
        """
        pair = Pair(self.segment, self.a, self.b, self.states.finer(i, FINER), self.reach)
        measured = min(pair.distance(k) for k in range(FINER + 1))
        return measured, min(pair.bound(k, k + 1) for k in range(FINER))


@dataclass(frozen=True)
class Clearance:
    """What the check of the clearance found.

    Attributes:
        minimum: m, proven for all times; at most FAR.
        reasons: Faults.
    """

    minimum: float
    reasons: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class _Occupied:
    """A segment: its states [first, last], and the indices of what moves (P,) and stands (F,) in it."""

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
    opening: frozenset[tuple[str, str]] = frozenset(),
    needed: float = 0.0,
) -> Clearance:
    """Prove that nothing comes near but what is planned to; see the head of this file.

    Args:
        plan: The plan.
        states: The motion's states.
        moving: Parts that move in each segment.
        world: What stands in each segment.
        exempt: Exemptions of each segment.
        opening: Pairs (part, fixture) that are near at the start of a way out, and are followed elsewhere.
        needed: m that all others keep.

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
        near.append(_near(states, solids, _Occupied(k, first, last, own, others), exempt[k], opening))
    return _Search(plan, states, solids, Stretches.joined(near), needed).run()


class _Search:
    """The lowest bound is split until it is known well enough.

    Bounds below ``_below`` m have been tightened and stand in a heap, the others wait.
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
        self._smallest = self._proven = FAR

    def run(self) -> Clearance:
        """The smallest clearance, or reasons."""
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
        """Whether the heap's lowest bound is too low to leave it at that; what waits is tightened before."""
        while True:
            enough = max(self._needed, min(self._proven, self._smallest - RESOLUTION))
            lowest = self._heap[0][0] if self._heap else FAR
            if lowest < min(enough, self._below):
                return True
            if self._below >= enough:
                self._proven = min(self._proven, lowest, self._waiting.bound.min(initial=FAR))
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
        """Ask fcl about both ends of a stretch. False: they are a reason against the plan."""
        needed = self._needed
        low, near = pair.bound(i, j), min(pair.distance(i), pair.distance(j))
        is_last = j <= i + 1
        if is_last and low < needed <= near:
            near, low = self._finer(pair, i)
        self._smallest = min(self._smallest, near)
        if near <= max(0.0, needed - ROUNDING) or (is_last and low <= max(0.0, needed - UNPROVEN)):
            self._reasons[pair.segment, pair.names] = _reason(self._plan, pair, i, j, needed)
            return False
        if is_last:
            self._proven = min(self._proven, low)
        else:
            heapq.heappush(self._heap, (low, next(self._ticket), pair, i, j, True))
        return True

    def _finer(self, pair: Pair, i: int) -> tuple[float, float]:
        """As ``Pair.finer``; fcl is asked only where the gaps between the two do not do."""
        states, solids = self._states.finer(i, FINER), SolidArrays.of((pair.a, pair.b))
        one = np.zeros(FINER + 1, dtype=np.int64)
        gaps = solids.gaps(states, one, one + 1, np.arange(FINER + 1))
        low = float((gaps[:-1] + gaps[1:] - np.diff(states.travel @ pair.reach)).min()) / 2
        return (float(gaps.min()), low) if low >= self._needed else pair.finer(i)


def _reason(plan: Plan, pair: Pair, i: int, j: int, needed: float) -> Reason:
    """Where and how deep, how near, or that the proof does not reach."""
    i = min((i, j), key=pair.distance)
    where = f"segment {pair.segment} ({plan.segments[pair.segment].kind})"
    at = f"{pair.names} at {pair.states.times[i]:.3f} s"
    if pair.b.name in plan.segments[pair.segment].touching and (pair.a.is_cup or pair.a.is_held):
        at += " (named as touched, but not near where the item or the cup is at rest)"
    if pair.distance(i) <= 0.0:
        return Reason("collision", where, f"{at}, {pair.depth(i) * 1e3:.1f} mm deep")
    apart = f"{pair.distance(i) * 1e3:.2f} mm apart"
    if pair.distance(i) < needed:
        return Reason("too close", where, f"{at}, {apart}, {needed * 1e3:.1f} mm are kept")
    return Reason("too close to prove", where, f"{at}, {apart}")


def _near(
    states: States,
    solids: SolidArrays,
    at: _Occupied,
    exempt: Exemptions,
    opening: frozenset[tuple[str, str]],
) -> Stretches:
    """Every stretch of a segment in which a pair that is tested may come nearer than FAR.

    Args:
        states: The motion's.
        solids: The plan's.
        at: The segment.
        exempt: What it does not test.
        opening: Pairs (part, fixture) that are followed elsewhere.
    """

    def is_world_pair_tested(a: Part, b: Part | Fixture) -> bool:
        return (a.name, b.name) not in opening and not exempt.is_world_pair_untested(a, b.name)

    def is_own_pair_tested(a: Part, b: Part | Fixture) -> bool:
        return isinstance(b, Part) and not exempt.is_own_pair_untested(a, b)

    cut = state_intervals(states, at.first, at.last, solids.reach[at.moving].max(axis=0))
    bounds = world_bounds(states, solids, at.moving, at.standing, cut).reshape(len(cut.middle), -1)
    a, b = (index.ravel() for index in np.meshgrid(at.moving, at.standing, indexing="ij"))
    world = near_stretches(bounds, at.index, a, b, cut, FAR)
    a, b = (at.moving[index] for index in np.triu_indices(len(at.moving), 1))
    own = near_stretches(own_bounds(states, solids, at.moving, cut), at.index, a, b, cut, FAR)
    return Stretches.joined(
        [_tested(world, solids, is_world_pair_tested), _tested(own, solids, is_own_pair_tested)]
    )


def _tested(
    stretches: Stretches, solids: SolidArrays, is_tested: Callable[[Part, Part | Fixture], bool]
) -> Stretches:
    """The stretches of pairs that are tested at all; every pair is asked about once."""
    keys, which = np.unique(stretches.a * len(solids.solids) + stretches.b, return_inverse=True)
    pairs = (solids.pair(*divmod(key, len(solids.solids))) for key in keys.tolist())
    return stretches[np.fromiter((is_tested(*pair) for pair in pairs), dtype=bool, count=len(keys))[which]]
