"""Arrays of many solids, by which distances of thousands of pairs are bounded at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.separation import half_width_terms, widest_gaps
from pickcli.verification.state_sampling import States

Indices: TypeAlias = NDArray[np.int64]

BATCH = 1024  # pairs per batch of gaps: intermediate results stay in the cache


@dataclass(frozen=True, eq=False)
class SolidArrays:
    """S solids that move with a link or are static; n is the number of joints.

    Attributes:
        solids: The S solids themselves.
        link: (S,) index of the link that carries each, -1 if static.
        T: (S, 4, 4) pose of each in its link, or in the world.
        terms: (S, 5) of each shape's half width, see ``half_width_terms``.
        half: (S, 3) half extents in m of the box around each, in its own frame.
        slack: (S,) m that any point may be outside of the shape.
        reach: (S, n) m that any point moves per unit of each joint, at most.
    """

    solids: tuple[Part | Fixture, ...]
    link: Indices
    T: Array
    terms: Array
    half: Array
    slack: Array
    reach: Array

    @classmethod
    def of(cls, solids: Iterable[Part | Fixture]) -> SolidArrays:
        """Build the arrays of solids.

        Args:
            solids: The solids, at least one of which moves.

        Returns:
            The arrays.
        """
        found = tuple(solids)
        still = next(np.zeros_like(solid.reach) for solid in found if isinstance(solid, Part))
        return cls(
            found,
            np.array([solid.link if isinstance(solid, Part) else -1 for solid in found]),
            np.stack(
                [solid.T_link_shape if isinstance(solid, Part) else solid.T_world_shape for solid in found]
            ),
            np.stack([half_width_terms(solid.shape) for solid in found]),
            np.stack([solid.shape.extents / 2 for solid in found]),
            np.array([solid.slack for solid in found]),
            np.stack([solid.reach if isinstance(solid, Part) else still for solid in found]),
        )

    def pair(self, a: int, b: int) -> tuple[Part, Part | Fixture]:
        """Return the solids of two indices.

        Args:
            a: Index of a moving solid.
            b: Index of the other solid.

        Returns:
            Both.
        """
        one = self.solids[a]
        assert isinstance(one, Part)
        return one, self.solids[b]

    def radii(self, which: Indices) -> Array:
        """Return radii of spheres about the solids' centres that contain them, slack included.

        Args:
            which: (M,) indices of solids.

        Returns:
            (M,) m.
        """
        terms = self.terms[which]
        return np.asarray(np.linalg.norm(terms[:, :4], axis=1) + terms[:, 4] + self.slack[which])

    def T_world(self, states: States, which: Indices, at: Indices) -> Array:
        """Return poses of solids in the world.

        Args:
            states: The motion's states.
            which: (M,) indices of solids.
            at: (M,) indices of states.

        Returns:
            (M, 4, 4).
        """
        T, link = self.T[which], self.link[which]
        moves = link >= 0
        T[moves] = states.links[link[moves], at[moves]] @ T[moves]
        return np.asarray(T)

    def relative_reach(self, a: Indices, b: Indices) -> Array:
        """Bound how far two solids move relative to each other per unit of each joint.

        Only joints between the two count: those that move the one farther from the base but not the other.

        Args:
            a: (M,) indices of solids.
            b: (M,) indices of solids.

        Returns:
            (M, n) m.
        """
        is_a_nearer = (self.link[a] <= self.link[b])[:, None]
        near = np.where(is_a_nearer, self.reach[a], self.reach[b])
        far = np.where(is_a_nearer, self.reach[b], self.reach[a])
        return np.where(near > 0.0, 0.0, far)

    def gaps(self, states: States, a: Indices, b: Indices, at: Indices) -> Array:
        """Return lower bounds of the distances of pairs, less their slack.

        Args:
            states: The motion's states.
            a: (M,) indices of solids.
            b: (M,) indices of solids.
            at: (M,) indices of states.

        Returns:
            (M,) m.
        """
        found = [
            widest_gaps(
                self.terms[a[k]], self.T_world(states, a[k], at[k]),
                self.terms[b[k]], self.T_world(states, b[k], at[k]),
            )
            for k in (slice(first, first + BATCH) for first in range(0, len(a), BATCH))
        ]  # fmt: skip
        return np.asarray(np.concatenate(found) - self.slack[a] - self.slack[b])
