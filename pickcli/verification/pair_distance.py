"""Distance of two solids over a motion: measured at single states, bounded between them.

Between two states a and b of a pair, with distances d_a and d_b, that moves at most w relative
to each other in between, no distance is below (d_a + d_b - w) / 2 (Piyavskii and Shubert's bound for
Lipschitz functions).
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right, insort
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from pickcli.geometry import Array
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.solid_arrays import SolidArrays
from pickcli.verification.state_sampling import States

FINER = 16  # parts that a step between two states is cut into if they do not prove the clearance


@dataclass(eq=False)
class Pair:
    """Two solids, at least one of which moves, over the states of one segment.

    Attributes:
        segment: Index of the segment.
        a: The solid that moves.
        b: The other solid, which may move, too.
        states: The motion's states.
        reach: (n,) m per unit of each joint, of one solid relative to the other.
        measured: Exact distances in m, by state.
    """

    segment: int
    a: Part
    b: Part | Fixture
    states: States
    reach: Array
    measured: dict[int, float] = field(default_factory=dict)
    _order: list[int] = field(default_factory=list)  # indices of the measured states, sorted

    @cached_property
    def travel(self) -> Array:
        """(N,) m, upper bound of how far the two moved relative to each other up to each state."""
        return np.asarray(self.states.travel @ self.reach)

    @cached_property
    def solids(self) -> SolidArrays:
        """Both solids, a first."""
        return SolidArrays.of((self.a, self.b))

    @property
    def names(self) -> str:
        """Both names, for messages."""
        return f"{self.a.name} and {self.b.name}"

    def distance(self, i: int) -> float:
        """Return the exact distance at a state.

        Args:
            i: Index of the state.

        Returns:
            m; 0 if they touch or overlap.
        """
        if i not in self.measured:
            self._place(i)
            slack = self.a.slack + self.b.slack
            self.measured[i] = max(0.0, self.a.solid.distance(self.b.solid) - slack)
            insort(self._order, i)
        return self.measured[i]

    def depth(self, i: int) -> float:
        """Return the depth of overlap at a state, negative if they are apart.

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
        """Return a lower bound of all distances between two states.

        Args:
            i: Index of one state.
            j: Index of the other.

        Returns:
            m.
        """
        way = float(self.travel[j] - self.travel[i])
        return (self.distance(i) + self.distance(j) - way) / 2

    def known(self, i: int, j: int) -> float:
        """Return a lower bound of all distances between two states, from measurements around them.

        Args:
            i: Index of the one state.
            j: Index of the other.

        Returns:
            m; -infinity if nothing was measured.
        """
        begin, end = bisect_right(self._order, i), bisect_left(self._order, j)
        before, after = self._order[max(begin - 1, 0) : begin], self._order[end : end + 1]
        bounds = [self.measured[k] - float(self.travel[j] - self.travel[k]) for k in before]
        bounds += [self.measured[k] - float(self.travel[k] - self.travel[i]) for k in after]
        bounds += [self.bound(k, m) for k in before for m in after]
        return max(bounds, default=-np.inf)

    def finer(self, i: int) -> tuple[float, float]:
        """Measure the smallest distance between a state and the next, at more states in between.

        Args:
            i: Index of the first state.

        Returns:
            The smallest measured distance, and a lower bound of all distances, m.
        """
        pair = Pair(self.segment, self.a, self.b, self.states.finer(i, FINER), self.reach)
        measured = min(pair.distance(k) for k in range(FINER + 1))
        return measured, min(pair.bound(k, k + 1) for k in range(FINER))
