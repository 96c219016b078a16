"""The smallest clearance of the whole motion, proven: branch and bound over pairs and time.

Between two states a and b of a pair whose distances are d_a and d_b, and which moves at most w relative
to each other in between, no distance is below (d_a + d_b - w) / 2 (Piyavskii and Shubert's bound for
Lipschitz functions). The stretch with the lowest bound is always split next, so fcl is asked only where
things are near, and when the lowest bound left is as high as the smallest distance measured, nothing in
the whole motion can be nearer. Where two neighbouring states do not prove the clearance that is kept, more
are looked at in between. First bounds come from balls around the parts, all pairs at once.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.verification.broad_phase import candidates, own_bounds, relative_reach, windows, world_bounds
from pickcli.verification.exemptions import Exemptions
from pickcli.verification.moving_parts import Fixture, Part, farthest
from pickcli.verification.state_sampling import States
from pickcli.verification.static_solids import Standing

FAR = 0.05  # m, clearances beyond it are not told apart
RESOLUTION = 2e-4  # m, how far below the smallest measured clearance the proven one may lie
FINER = 16  # parts into which a stretch between two states is cut where they do not prove the clearance
ROUNDING = 1e-5  # m by which a measured distance may fall short of the clearance
UNPROVEN = 1e-4  # m by which a bound between two of the finer states may
MAX_REASONS = 20


@dataclass(eq=False)
class Pair:
    """Two solids, at least one of which moves, over the states of one segment."""

    segment: int
    a: Part
    b: Part | Fixture
    states: States
    reach: Array  # (n,) m per unit of each joint, of one relative to the other
    measured: dict[int, float] = field(default_factory=dict)

    @cached_property
    def travel(self) -> Array:
        """(N,) m, an upper bound of how far the two moved relative to each other up to each state."""
        return np.asarray(self.states.travel @ self.reach)

    @property
    def names(self) -> str:
        """Both names, for people."""
        return f"{self.a.name} and {self.b.name}"

    def distance(self, i: int) -> float:
        """Exact distance in m at state i; 0 where they touch or overlap."""
        if i not in self.measured:
            self._place(i)
            slack = self.a.slack + self.b.slack
            self.measured[i] = max(0.0, self.a.solid.distance(self.b.solid) - slack)
        return self.measured[i]

    def depth(self, i: int) -> float:
        """Depth of overlap in m at state i."""
        self._place(i)
        inside = self.a.solid.depth(self.b.solid) or -self.a.solid.distance(self.b.solid)
        return inside + self.a.slack + self.b.slack

    def _place(self, i: int) -> None:
        for part in (self.a, self.b):
            if isinstance(part, Part):
                part.solid.place(self.states.links[part.link, i] @ part.T_link_shape)

    def bound(self, i: int, j: int) -> float:
        """No distance between states i and j is below this."""
        way = float(self.travel[j] - self.travel[i])
        return (self.distance(i) + self.distance(j) - way) / 2

    def finer(self, i: int) -> tuple[float, float]:
        """The smallest distance between states i and i + 1, measured at more states, and a bound of it."""
        pair = Pair(self.segment, self.a, self.b, self.states.finer(i, FINER), self.reach)
        measured = min(pair.distance(k) for k in range(FINER + 1))
        return measured, min(pair.bound(k, k + 1) for k in range(FINER))


@dataclass(frozen=True)
class Clearance:
    """What was found. minimum: m, proven for all times; at most FAR."""

    minimum: float
    n_distances: int
    reasons: tuple[Reason, ...]


def check_clearance(
    plan: Plan,
    states: States,
    moving: Sequence[tuple[Part, ...]],
    world: Standing,
    exempt: Sequence[Exemptions],
    opening: frozenset[tuple[str, str]] = frozenset(),
    needed: float = 0.0,
) -> Clearance:
    """Prove that nothing comes near but what is planned to; see the head of this file.

    exempt: of every segment
    opening: pairs (part, fixture) that are near at the start of a way out, and are followed elsewhere
    needed: m that all others keep
    """
    queue: list[tuple[float, int, Pair, int, int, bool]] = []
    ticket = count()
    for k in range(len(plan.segments)):
        for bound, pair, i, j in _near(plan, states, moving[k], world.of(k), k, exempt[k], opening):
            queue.append((bound, next(ticket), pair, i, j, False))
    heapq.heapify(queue)
    return _search(plan, queue, ticket, needed)


def _search(
    plan: Plan,
    queue: list[tuple[float, int, Pair, int, int, bool]],
    ticket: Iterator[int],
    needed: float,
) -> Clearance:
    """Split the lowest bound until it is known well enough."""
    smallest, proven = FAR, FAR
    reasons: dict[tuple[int, str], Reason] = {}
    n_distances = 0
    while queue and len(reasons) < MAX_REASONS:
        bound, _, pair, i, j, is_measured = heapq.heappop(queue)
        if bound >= max(needed, min(proven, smallest - RESOLUTION)):
            proven = min(proven, bound)
            break
        if (pair.segment, pair.names) in reasons:
            continue
        stretches = ((i, (i + j) // 2), ((i + j) // 2, j)) if is_measured and j > i + 1 else ((i, j),)
        for start, end in stretches:
            n_distances += (start not in pair.measured) + (end not in pair.measured)
            low = pair.bound(start, end)
            near = min(pair.distance(start), pair.distance(end))
            is_last = end <= start + 1
            if is_last and low < needed <= near:
                near, low = pair.finer(start)
            smallest = min(smallest, near)
            if near <= max(0.0, needed - ROUNDING) or (is_last and low <= max(0.0, needed - UNPROVEN)):
                reasons[pair.segment, pair.names] = _reason(plan, pair, start, end, needed)
                break
            if is_last:
                proven = min(proven, low)
            else:
                heapq.heappush(queue, (low, next(ticket), pair, start, end, True))
    return Clearance(min(proven, smallest), n_distances, tuple(reasons.values()))


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
    plan: Plan,
    states: States,
    moving: tuple[Part, ...],
    standing: tuple[Fixture, ...],
    k: int,
    exempt: Exemptions,
    opening: frozenset[tuple[str, str]],
) -> Iterator[tuple[float, Pair, int, int]]:
    """(bound, pair, i, j) of every pair and stretch of states of segment k that may come nearer than FAR."""
    segment = plan.segments[k]
    at = windows(states, *states.between(segment.t_start, segment.t_end), farthest(moving))
    tested = np.array(
        [
            [
                (p.name, f.name) not in opening and not exempt.is_world_pair_untested(p, f.name)
                for f in standing
            ]
            for p in moving
        ]
    )
    bounds = world_bounds(states, moving, standing, at)
    yield from _pairs(k, states, moving, standing, candidates(bounds, tested, at, FAR))
    tested = np.array([[not exempt.is_own_pair_untested(a, b) for b in moving] for a in moving])
    bounds = own_bounds(states, moving, at)
    yield from _pairs(k, states, moving, moving, candidates(bounds, np.triu(tested), at, FAR))


def _pairs(
    k: int,
    states: States,
    moving: Sequence[Part],
    others: Sequence[Part | Fixture],
    found: Iterator[tuple[float, int, int, int, int]],
) -> Iterator[tuple[float, Pair, int, int]]:
    pairs: dict[tuple[int, int], Pair] = {}
    for bound, a, b, i, j in found:
        if (a, b) not in pairs:
            one, other = moving[a], others[b]
            reach = relative_reach(one, other) if isinstance(other, Part) else one.reach
            pairs[a, b] = Pair(k, one, other, states, reach)
        yield bound, pairs[a, b], i, j
