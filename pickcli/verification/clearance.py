"""The smallest clearance of the whole motion, proven: branch and bound over pairs and time.

Between two states a and b of a pair whose distances are d_a and d_b, and which moves at most w relative
to each other in between, no distance is below (d_a + d_b - w) / 2 (Piyavskii and Shubert's bound for
Lipschitz functions). The stretch with the lowest bound is always split next, so fcl is asked only where
things are near, and when the lowest bound left is as high as the smallest distance measured, nothing in
the whole motion can be nearer. First bounds come from balls around the parts, all pairs at once.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count

import numpy as np

from pickcli.cell.scene import Scene
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.verification.contacts import exemptions
from pickcli.verification.parts import Fixture, Part, farthest
from pickcli.verification.sieve import candidates, own_bounds, relative_reach, windows, world_bounds
from pickcli.verification.standing import Standing
from pickcli.verification.states import States

FAR = 0.05  # m, clearances beyond it are not told apart
RESOLUTION = 2e-4  # m, how far below the smallest measured clearance the proven one may lie
MAX_REASONS = 20


@dataclass(eq=False)
class Pair:
    """Two solids, at least one of which moves, over the states of one segment."""

    segment: int
    a: Part
    b: Part | Fixture
    states: States
    travel: Array  # (N,) m, an upper bound of how far the two moved relative to each other so far
    measured: dict[int, float] = field(default_factory=dict)

    @property
    def names(self) -> str:
        """Both names, for people."""
        return f"{self.a.name} and {self.b.name}"

    def distance(self, i: int) -> float:
        """Exact distance in m at state i; 0 where they touch or overlap."""
        if i not in self.measured:
            self._place(i)
            slack = self.a.slack + (self.b.slack if isinstance(self.b, Part) else 0.0)
            self.measured[i] = max(0.0, self.a.solid.distance(self.b.solid) - slack)
        return self.measured[i]

    def depth(self, i: int) -> float:
        """Depth of overlap in m at state i."""
        self._place(i)
        return self.a.solid.depth(self.b.solid)

    def _place(self, i: int) -> None:
        for part in (self.a, self.b):
            if isinstance(part, Part):
                part.solid.place(self.states.links[part.link, i] @ part.T_link_shape)

    def bound(self, i: int, j: int) -> float:
        """No distance between states i and j is below this."""
        way = float(self.travel[j] - self.travel[i])
        return (self.distance(i) + self.distance(j) - way) / 2


@dataclass(frozen=True)
class Clearance:
    """What was found. minimum: m, proven for all times; at most FAR."""

    minimum: float
    n_distances: int
    reasons: tuple[Reason, ...]


def check_clearance(
    plan: Plan,
    scene: Scene,
    states: States,
    moving: Sequence[tuple[Part, ...]],
    world: Standing,
    opening: frozenset[tuple[str, str]] = frozenset(),
) -> Clearance:
    """Prove that nothing touches but what is planned to; see the head of this file.

    opening: pairs (part, fixture) that are near at the start of a way out, and are followed elsewhere
    """
    queue: list[tuple[float, int, Pair, int, int, bool]] = []
    ticket = count()
    for k in range(len(plan.segments)):
        for bound, pair, i, j in _near(plan, scene, states, moving[k], world.of(k), k, opening):
            queue.append((bound, next(ticket), pair, i, j, False))
    heapq.heapify(queue)
    return _search(plan, queue, ticket)


def _search(
    plan: Plan, queue: list[tuple[float, int, Pair, int, int, bool]], ticket: Iterator[int]
) -> Clearance:
    """Split the lowest bound until it is known well enough."""
    smallest, proven = FAR, FAR
    reasons: dict[tuple[int, str], Reason] = {}
    n_distances = 0
    while queue and len(reasons) < MAX_REASONS:
        bound, _, pair, i, j, is_measured = heapq.heappop(queue)
        if bound >= min(proven, smallest - RESOLUTION):
            proven = min(proven, bound)
            break
        if (pair.segment, pair.names) in reasons:
            continue
        stretches = ((i, (i + j) // 2), ((i + j) // 2, j)) if is_measured and j > i + 1 else ((i, j),)
        for start, end in stretches:
            n_distances += (start not in pair.measured) + (end not in pair.measured)
            low = pair.bound(start, end)
            near = min(pair.distance(start), pair.distance(end))
            smallest = min(smallest, near)
            if near <= 0.0 or (low <= 0.0 and end <= start + 1):
                reasons[pair.segment, pair.names] = _reason(plan, pair, start, end)
                break
            if end <= start + 1:
                proven = min(proven, low)
            else:
                heapq.heappush(queue, (low, next(ticket), pair, start, end, True))
    return Clearance(min(proven, smallest), n_distances, tuple(reasons.values()))


def _reason(plan: Plan, pair: Pair, i: int, j: int) -> Reason:
    """Where and how deep, or that the proof does not reach."""
    i = min((i, j), key=pair.distance)
    where = f"segment {pair.segment} ({plan.segments[pair.segment].kind})"
    at = f"{pair.names} at {pair.states.times[i]:.3f} s"
    if pair.distance(i) <= 0.0:
        return Reason("collision", where, f"{at}, {pair.depth(i) * 1e3:.1f} mm deep")
    return Reason("too close to prove", where, f"{at}, {pair.distance(i) * 1e3:.2f} mm apart")


def _near(
    plan: Plan,
    scene: Scene,
    states: States,
    moving: tuple[Part, ...],
    standing: tuple[Fixture, ...],
    k: int,
    opening: frozenset[tuple[str, str]],
) -> Iterator[tuple[float, Pair, int, int]]:
    """(bound, pair, i, j) of every pair and stretch of states of segment k that may come nearer than FAR."""
    segment = plan.segments[k]
    exempt = exemptions(plan, scene, k)
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
            pairs[a, b] = Pair(k, one, other, states, states.travel @ reach)
        yield bound, pairs[a, b], i, j
