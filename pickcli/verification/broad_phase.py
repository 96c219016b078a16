"""Broad phase: lower bounds of the distances of all pairs over intervals of states, thousands at a time.

Each step leaves few pairs and short intervals for the next; the rest is measured with the exact shapes.
Solids that are far from a whole segment are left out. The segment is cut into intervals, and the spheres
around all parts are compared with the other solids at the middle of each. Pairs that may be near there are
then bounded by gaps across a few directions; intervals that these bounds do not decide are halved. The last
two steps subtract how far a pair moves from the middle of an interval to its ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.verification.fcl_solids import distances_to_boxes
from pickcli.verification.solid_arrays import Indices, SolidArrays
from pickcli.verification.state_sampling import States

INTERVAL = 0.1  # m that the fastest part moves in one interval


@dataclass(frozen=True, eq=False)
class StateIntervals:
    """W stretches of states and a state in the middle of each.

    Attributes:
        first: (W,) index of the first state.
        middle: (W,) index of the state in the middle.
        last: (W,) index of the last state.
    """

    first: Indices
    middle: Indices
    last: Indices

    def half_way(self, states: States, reach: Array) -> Array:
        """Return how far, at most, the middle of each interval is from any other of its states.

        Args:
            states: The motion's states.
            reach: (K, n) m per unit of each joint.

        Returns:
            (W, K) m.
        """
        back = states.travel[self.middle] - states.travel[self.first]
        ahead = states.travel[self.last] - states.travel[self.middle]
        # No BLAS: it would spread this little work over several threads.
        back, ahead = (np.einsum("wn,kn->wk", way, reach) for way in (back, ahead))
        return np.asarray(np.maximum(back, ahead))


@dataclass(frozen=True, eq=False)
class Stretches:
    """M pairs of solids, each over the states [first, last] of a segment; all arrays are (M,).

    Attributes:
        bound: m, lower bound of the pair's distance in the stretch.
        segment: Index of the segment.
        a: Index of the solid that moves.
        b: Index of the other solid, which may move, too.
        first: Index of the first state.
        last: Index of the last state.
    """

    bound: Array
    segment: Indices
    a: Indices
    b: Indices
    first: Indices
    last: Indices

    def __len__(self) -> int:
        return len(self.bound)

    def __getitem__(self, which: NDArray[np.bool_] | Indices) -> Stretches:
        """Select stretches by a mask or by indices."""
        return Stretches(
            self.bound[which],
            self.segment[which],
            self.a[which],
            self.b[which],
            self.first[which],
            self.last[which],
        )

    @staticmethod
    def joined(several: Sequence[Stretches]) -> Stretches:
        """Concatenate several sets of stretches.

        Args:
            several: At least one.

        Returns:
            The stretches.
        """
        return Stretches(
            np.concatenate([each.bound for each in several]),
            np.concatenate([each.segment for each in several]),
            np.concatenate([each.a for each in several]),
            np.concatenate([each.b for each in several]),
            np.concatenate([each.first for each in several]),
            np.concatenate([each.last for each in several]),
        )

    @property
    def middle(self) -> Indices:
        """Index of the state in the middle of each stretch."""
        return (self.first + self.last) // 2

    def halved(self) -> Stretches:
        """Halve each stretch; both halves keep the bound of the whole.

        Returns:
            The halves.
        """
        return Stretches.joined([replace(self, last=self.middle), replace(self, first=self.middle)])


def state_intervals(states: States, first: int, last: int, reach: Array) -> StateIntervals:
    """Cut the states of a segment into intervals.

    Args:
        states: The motion's states.
        first: Index of the segment's first state.
        last: Index of its last state.
        reach: (n,) m per unit of each joint, of the part that reaches farthest.

    Returns:
        The intervals.
    """
    way = (states.travel[first : last + 1] - states.travel[first]) @ reach
    n = max(1, int(np.ceil(way[-1] / INTERVAL)))
    ends = np.searchsorted(way, np.linspace(0.0, way[-1], n + 1))
    ends[-1] = last - first  # also if the parts come to rest before
    edges = first + np.unique(ends)
    return StateIntervals(edges[:-1], (edges[:-1] + edges[1:]) // 2, edges[1:])


def world_bounds(
    states: States, solids: SolidArrays, moving: Indices, standing: Indices, at: StateIntervals
) -> Array:
    """Return lower bounds of the distances between moving parts and static solids, in each interval.

    Args:
        states: The motion's states.
        solids: All solids of the motion.
        moving: (P,) indices of the parts.
        standing: (F,) indices of the static solids.
        at: W intervals.

    Returns:
        (W, P, F) m.
    """
    centers = _centers(states, solids, moving, at)
    away = distances_to_boxes(centers, solids.T[standing], solids.half[standing])
    own = solids.radii(moving) + at.half_way(states, solids.reach[moving])
    return np.asarray(away - own[:, :, None] - solids.slack[standing])


def standing_near(
    states: States, solids: SolidArrays, moving: Indices, standing: Indices, at: StateIntervals, below: float
) -> Indices:
    """Return the static solids that any part may come nearer to than a threshold, in any of the intervals.

    The box along the axes of the world around all centres of a part, and that around a solid, are compared:
    of thousands of solids, as unknown space has, most are left out without looking at the intervals.

    Args:
        states: The motion's states.
        solids: All solids of the motion.
        moving: (P,) indices of the parts.
        standing: (F,) indices of the static solids.
        at: W intervals.
        below: m, the threshold.

    Returns:
        Those of ``standing`` whose ``world_bounds`` may be below the threshold.
    """
    centers = _centers(states, solids, moving, at)
    own = (solids.radii(moving) + at.half_way(states, solids.reach[moving])).max(axis=0)
    middle = solids.T[standing, :3, 3]
    half = np.einsum("fij,fj->fi", np.abs(solids.T[standing, :3, :3]), solids.half[standing])
    low, high = centers.min(axis=0)[:, None], centers.max(axis=0)[:, None]
    apart = np.maximum(0.0, np.maximum(low - (middle + half), (middle - half) - high))
    bound = np.sqrt(np.square(apart).sum(axis=2)) - own[:, None] - solids.slack[standing]
    return np.asarray(standing[(bound < below).any(axis=0)])


def own_bounds(states: States, solids: SolidArrays, moving: Indices, at: StateIntervals) -> Array:
    """Return lower bounds of the distances between moving parts, in each interval.

    Args:
        states: The motion's states.
        solids: All solids of the motion.
        moving: (P,) indices of the parts.
        at: W intervals.

    Returns:
        (W, Q) m, the Q pairs of np.triu_indices(P, 1).
    """
    i, j = np.triu_indices(len(moving), 1)
    centers, radii = _centers(states, solids, moving, at), solids.radii(moving)
    between = centers[:, i] - centers[:, j]
    away = np.sqrt(np.einsum("wqk,wqk->wq", between, between))
    way = at.half_way(states, solids.relative_reach(moving[i], moving[j]))
    return np.asarray(away - (radii[i] + radii[j]) - way)


def _centers(states: States, solids: SolidArrays, moving: Indices, at: StateIntervals) -> Array:
    """Return the centres (W, P, 3) in the world of the parts at the middle of each interval."""
    links = states.links[solids.link[moving], at.middle[:, None]]
    return np.asarray((links @ solids.T[moving, :, 3, None])[:, :, :3, 0])


def near_stretches(
    bounds: Array, segment: int, a: Indices, b: Indices, at: StateIntervals, below: float
) -> Stretches:
    """Return the pairs and intervals of a segment whose bound is below a threshold.

    Args:
        bounds: (W, Q) m.
        segment: Index of the segment.
        a: (Q,) index of the first solid of each pair.
        b: (Q,) index of the second.
        at: W intervals.
        below: m, the threshold.

    Returns:
        The stretches.
    """
    w, q = np.nonzero(bounds < below)
    return Stretches(bounds[w, q], np.full(len(w), segment), a[q], b[q], at.first[w], at.last[w])


def tightened(
    stretches: Stretches, below: float, floor: float, states: States, solids: SolidArrays
) -> tuple[Stretches, float]:
    """Raise the bounds of stretches that are below ``below``, by cutting these into shorter ones.

    A bound that remains below it belongs to a stretch between neighbouring states, or to one without a gap
    in its middle; only the exact shapes can decide these.

    Args:
        stretches: Stretches of one motion.
        below: m. It is lowered to the smallest gap that is found, because higher bounds are of no use.
        floor: m, the least value that ``below`` is lowered to.
        states: The motion's states.
        solids: Solids of the stretches.

    Returns:
        The stretches, and the final value of ``below``.
    """
    is_low = stretches.bound < below
    done, low = [stretches[~is_low]], stretches[is_low]
    while len(low):
        middle, reach = low.middle, solids.relative_reach(low.a, low.b)
        gaps = solids.gaps(states, low.a, low.b, middle)
        back = states.travel[middle] - states.travel[low.first]
        ahead = states.travel[low.last] - states.travel[middle]
        way = np.maximum(np.einsum("mn,mn->m", back, reach), np.einsum("mn,mn->m", ahead, reach))
        low = replace(low, bound=np.maximum(low.bound, gaps - way))
        below = min(below, max(floor, float(gaps.min())))
        is_split = (low.bound < below) & (low.last > low.first + 1) & (gaps > 0.0)
        done.append(low[~is_split])
        low = low[is_split].halved()
    return Stretches.joined(done), below
