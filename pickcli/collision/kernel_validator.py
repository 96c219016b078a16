"""Validation by the kernel of one moving body in one world, with names instead of the kernel's indices.

Robot, item and tool differ in what they enter into the kernel; their queries are the same and are here.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.collision_world import CollisionWorld
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import Checker, ContactKind

_SAMPLES = 17  # of an edge, to find its worst place


@dataclass(frozen=True)
class Contact:
    """The closest pair of a configuration.

    Attributes:
        distance: m between spheres of the robot and the closest solid, negative inside.
        a: Link name or "held <item>".
        b: Body name, item id, link name or "held <item>"; "" if nothing is near.
        kind: Kind of b: name of its carrier, "obstacle", "item", "base", "robot", "cloud", or "".
    """

    distance: float
    a: str
    b: str
    kind: str = ""

    @property
    def item(self) -> str:
        """Id of the item if b is one, else ""."""
        return self.b if self.kind == "item" else ""

    def __str__(self) -> str:
        if not self.b:
            return "nothing near"
        kind = "" if self.kind == "robot" else f"{self.kind} "
        return f"{self.a} against {kind}{self.b}"


@dataclass(frozen=True, eq=False)
class KernelWorld:
    """A kernel checker, and the solids of a world that were entered into it.

    Attributes:
        kernel: The moving body and the solids entered.
        kept: Indices (K,) in the world of the solids, in the kernel's order.
    """

    kernel: Checker
    kept: NDArray[np.intp]


class KernelValidator:
    """Validator by the kernel for one body in one world, which translates its indices to names.

    Args:
        world: Solids of the scene.
        parts: Name of each frame of the body, the held item's last.
        margin: m, kept from the solids entered in ``clear``.
        clearance: m, part of the margin that the cell states.
        clear: Body and solids that keep the margin.
        touch: Body and solids with contacts of limited depth, if any: the body keeps out of these solids,
            which are shifted away.

    Attributes:
        world: Solids of the scene.
        parts: Name of each frame of the body, the held item's last.
        margin: m, kept from everything that may not be touched.
        clearance_stated: m, part of the margin that the cell states.
    """

    def __init__(
        self,
        world: CollisionWorld,
        parts: tuple[str, ...],
        margin: float,
        clearance: float,
        clear: KernelWorld,
        touch: KernelWorld | None,
    ) -> None:
        """Wrap the kernel's checkers."""
        self.world, self.parts, self.margin, self.clearance_stated = world, parts, margin, clearance
        self._clear, self._touch = clear, touch

    @property
    def kernel(self) -> Checker:
        """Kernel checker with the moving body and all solids that it keeps the margin from."""
        return self._clear.kernel

    def is_valid(self, q: Array) -> bool:
        """Whether a configuration keeps more than the margin everywhere.

        Args:
            q: (n,) configuration.

        Returns:
            True if it does.
        """
        is_free = bool(self.kernel.is_free(q, self.margin))
        return is_free and (self._touch is None or bool(self._touch.kernel.is_free(q, 0.0)))

    def are_valid(self, Q: Array) -> NDArray[np.bool_]:
        """Whether each of many configurations keeps more than the margin everywhere.

        Args:
            Q: (N, n) configurations.

        Returns:
            (N,) True for those that do.
        """
        Q = np.ascontiguousarray(Q)
        are_free = np.asarray(self.kernel.are_free(Q, self.margin), dtype=bool)
        if self._touch is not None:
            are_free &= np.asarray(self._touch.kernel.are_free(Q, 0.0), dtype=bool)
        return are_free

    def is_valid_edge(self, q0: Array, q1: Array) -> bool:
        """Whether every point of a straight edge is proven free.

        Args:
            q0: (n,) configuration at the start.
            q1: (n,) configuration at the end.

        Returns:
            True if it is proven.
        """
        is_free = bool(self.kernel.edge_is_free(q0, q1, self.margin))
        return is_free and (self._touch is None or bool(self._touch.kernel.edge_is_free(q0, q1, 0.0)))

    def is_valid_path(self, Q: Array, slack: Array | None = None) -> bool:
        """Whether every point of a polyline is proven free.

        Args:
            Q: (N, n) waypoints.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            True if it is proven.
        """
        return self.first_blocked_edge(Q, slack) < 0

    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int:
        """Find the first edge of a polyline that is not proven free.

        Args:
            Q: (N, n) waypoints.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            Index of the edge, -1 if all are proven.
        """
        Q = np.ascontiguousarray(Q)
        blocked = int(self.kernel.first_blocked_edge(Q, self.margin, slack))
        if blocked == 0 or self._touch is None:
            return blocked
        n_edges = len(Q) - 1 if blocked < 0 else blocked
        earlier = Q[: n_edges + 1], 0.0, None if slack is None else slack[:n_edges]
        too_deep = int(self._touch.kernel.first_blocked_edge(*earlier))
        return blocked if too_deep < 0 else too_deep

    def at_margin(self, margin: float) -> Self:
        """Return a validator for the same body and world with another margin.

        Args:
            margin: m.

        Returns:
            A validator that shares the kernel's checkers.
        """
        wider = copy(self)
        wider.margin = margin
        return wider

    def clearances(self, Q: Array, max_distance: float = 1.0) -> Array:
        """Return the distance to the closest solid that is not a planned contact, at many configurations.

        Args:
            Q: (N, n) configurations.
            max_distance: m, limit of the measurement.

        Returns:
            (N,) m, negative inside the solid.
        """
        return np.asarray(self.kernel.clearances(np.ascontiguousarray(Q), max_distance))

    def clearest(self, Q: Array, n_most: int) -> tuple[NDArray[np.int32], Array]:
        """Find the configurations with the largest clearances.

        Args:
            Q: (N, n) configurations.
            n_most: How many are wanted.

        Returns:
            Indices (K,), K = min(N, n_most), the clearest first, equal ones in their order; and their
            clearances (K,) in m, as from ``clearances``.
        """
        return self.kernel.clearest(np.ascontiguousarray(Q), n_most)

    def clearance(self, q: Array, max_distance: float = 1.0) -> Contact:
        """Return the closest pair that is not a planned contact.

        Args:
            q: (n,) configuration.
            max_distance: m, limit beyond which nothing counts as near.

        Returns:
            The pair and its distance.
        """
        return self._decoded(self._clear, q, max_distance)

    def description(self, contact: Contact, place: str = "") -> str:
        """Describe a pair, its distance, and the distance that is required.

        Args:
            contact: The pair.
            place: Location on a motion, with a leading space.

        Returns:
            Text for a reason.
        """
        millimetres = 1e3 * abs(contact.distance)
        if contact.distance <= 0:
            return f"{contact}, {millimetres:.0f} mm deep{place}"
        needed, stated = (f"{1e3 * value:.3g} mm" for value in (self.margin, self.clearance_stated))
        more = "" if needed == stated else f": planning keeps more than the cell's clearance of {stated}"
        return f"{contact}, {millimetres:.1f} mm apart{place} ({needed} are needed{more})"

    def explain(self, q: Array) -> Reason:
        """Explain why a configuration is not valid.

        Args:
            q: (n,) configuration.

        Returns:
            Part of the body, obstacle and depth.
        """
        is_free = bool(self.kernel.is_free(q, self.margin))
        if is_free and self._touch is not None and not self._touch.kernel.is_free(q, 0.0):
            return self._too_deep(self._touch, q)
        return self._reason(self.clearance(q), is_free, "")

    def explain_path(self, Q: Array, slack: Array | None = None) -> Reason:
        """Explain why a polyline is not free, by its first edge that is not.

        Args:
            Q: (N, n) waypoints, N > 1.
            slack: (N - 1, n) half-width per joint of a tube around each edge that must be free as well.

        Returns:
            Part of the body, obstacle, depth, and location on the edge: the deepest pair of even samples and
            the kernel's witness.
        """
        i = max(0, self.first_blocked_edge(Q, slack))
        q0, q1, loose = Q[i], Q[i + 1], None if slack is None else slack[i]
        result = self.kernel.check_edge(q0, q1, self.margin, loose)
        if result.free and self._touch is not None:
            touch = self._touch.kernel.check_edge(q0, q1, 0.0, loose)
            if not touch.free:
                return self._too_deep(self._touch, (1 - touch.t) * q0 + touch.t * q1)
        t = self._worst(q0, q1, 0.0 if result.free else result.t)
        contact = self.clearance((1 - t) * q0 + t * q1)
        return self._reason(contact, result.free, f" at {100 * t:.0f} % of the edge")

    def _worst(self, q0: Array, q1: Array, witness: float) -> float:
        """Return the fraction of an edge with the least clearance; the witness if all have the margin."""
        fractions = np.append(witness, np.linspace(0.0, 1.0, _SAMPLES))
        Q = np.outer(1 - fractions, q0) + np.outer(fractions, q1)
        # Distances beyond the margin are irrelevant and not measured.
        return float(fractions[np.argmin(self.kernel.clearances(Q, self.margin))])

    def _too_deep(self, touch: KernelWorld, q: Array) -> Reason:
        """Explain what violates the limited depth of a planned contact at q, or near it on an edge."""
        contact = self._decoded(touch, q, 1.0)
        beyond = f"{-1e3 * contact.distance:.1f} mm beyond what poses and bellows explain"
        if contact.distance > 0.0:
            beyond = "not proven to stay within what poses and bellows explain"
        return Reason("planned contact too deep", "", f"{contact}, {beyond}", contact.item)

    def _decoded(self, entered: KernelWorld, q: Array, max_distance: float) -> Contact:
        """Translate the kernel's closest pair to names."""
        distance, frame, kind, index = entered.kernel.clearance(q, max_distance)
        if kind is ContactKind.NONE:
            return Contact(float(distance), "", "")
        if kind is ContactKind.SELF:
            return Contact(float(distance), self.parts[frame], self.parts[index], "robot")
        if kind is ContactKind.CLOUD:
            assert self.world.cloud is not None
            return Contact(float(distance), self.parts[frame], self.world.cloud.name(index), "cloud")
        solid = int(entered.kept[index])
        return Contact(float(distance), self.parts[frame], self.world.names[solid], self.world.kinds[solid])

    def _reason(self, contact: Contact, is_valid: bool, place: str) -> Reason:
        if is_valid:
            return Reason("no collision", "", f"{contact}, {1e3 * contact.distance:.0f} mm apart{place}")
        if contact.distance > self.margin:
            apart = f"{contact}, {1e3 * contact.distance:.1f} mm apart{place}"
            kept = f"{1e3 * self.margin:.3g} mm are not proven for all deviations of the motion"
            return Reason("too close", "", f"{apart}: {kept}", contact.item)
        what = "too close" if contact.distance > 0 else "collision"
        return Reason(what, "", self.description(contact, place), contact.item)
