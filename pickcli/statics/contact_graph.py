"""Contact graph of a scene: pairs of touching solids with contact normals, and support derived from them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.shapes import ShapeKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_distance import separation
from pickcli.scene.solid_overlap import TOUCH, PosedSolid
from pickcli.scene.touching import Gaps, PosedSolids, gaps
from pickcli.statics.solid_contact import SolidContact

_UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class ContactGraph:
    """The contacts of a scene: items and bodies are nodes, actual or possible contacts are edges.

    Attributes:
        scene: Items, carriers at their actual poses, and bounds of the items' pose errors.
        solids: The scene's items in their order, then all stationary bodies.
        gaps: All pairs of an item and a solid that may be in contact.
    """

    scene: Scene
    solids: PosedSolids
    gaps: Gaps

    @classmethod
    def of(cls, scene: Scene) -> ContactGraph:
        """Find all pairs that may be in contact within the pose errors.

        Unknown space is in contact with nothing: it may be empty, and bear nothing.

        Args:
            scene: The scene.

        Returns:
            The contact graph.
        """
        solids = PosedSolids.of(scene, scene.items, scene.standing)
        places = np.array([placed.location for placed in scene.items] + [""] * len(scene.standing))
        a, b = solids.near(len(scene.items), TOUCH)
        is_possible = (places[a] == places[b]) | (places[b] == "")  # a board may touch items of two bins
        is_possible &= ~np.isin(np.array(solids.names)[b], _unknown(scene))
        found = gaps(solids, a[is_possible], b[is_possible])
        close = found.width <= TOUCH + solids.bound[found.a] + solids.bound[found.b]
        return cls(
            scene, solids, Gaps(found.a[close], found.b[close], found.width[close], found.normal[close])
        )

    @cached_property
    def touching(self) -> Mapping[str, tuple[SolidContact, ...]]:
        """All certain or possible contacts by item id, as seen from the item."""
        found: dict[str, list[SolidContact]] = {placed.id: [] for placed in self.scene.items}
        names = self.solids.names
        for a, b, gap, normal in zip(
            self.gaps.a, self.gaps.b, self.gaps.width, self.gaps.normal, strict=True
        ):
            one = SolidContact(names[a], names[b], float(gap), normal)
            found[one.a].append(one)
            if one.b in found:
                found[one.b].append(one.flipped)
        for name in [name for name, contacts in found.items() if not any(c.carries for c in contacts)]:
            for below in self._below(name):
                found[name].append(below)
                if below.b in found:
                    found[below.b].append(below.flipped)
        return {name: tuple(contacts) for name, contacts in found.items()}

    def carriers(self, item_id: str) -> tuple[str, ...]:
        """Return what an item rests on; a single carrier bears all of it.

        Args:
            item_id: Id of the item.

        Returns:
            Ids of items and names of bodies.
        """
        return tuple(c.b for c in self.touching[item_id] if c.carries)

    def lying_on(self, item_id: str) -> tuple[str, ...]:
        """Return the items that rest on an item, entirely or in part.

        Args:
            item_id: Id of the item.

        Returns:
            Ids of items.
        """
        contacts = self.touching[item_id]
        return tuple(c.b for c in contacts if c.b in self.items and c.flipped.carries)

    def near(
        self, item_id: str, reach: float, also: frozenset[str] = frozenset()
    ) -> tuple[SolidContact, ...]:
        """Find all solids whose distance from an item may be below a threshold within the pose errors.

        Bodies of carriers are grown by the errors of their poses. Distances are exact, within
        ``solid_distance.TOLERANCE``: the verifier refuses contacts with what it measures to be farther.

        Args:
            item_id: Id of the item.
            reach: m, the threshold.
            also: Names of solids that are reported at any distance.

        Returns:
            Contacts, seen from the item.
        """
        solids, k = self._grown, self.index[item_id]
        where = self.items[item_id].location
        is_here = [name not in self.items or self.items[name].location == where for name in solids.names]
        apart = np.linalg.norm(solids.T[:, :3, 3] - solids.T[k, :3, 3], axis=1)
        balls = np.linalg.norm(solids.half, axis=1) + solids.bound
        is_requested = np.array([name in also for name in solids.names])
        b = np.flatnonzero(is_requested | (np.array(is_here) & (apart <= balls + balls[k] + reach)))
        b = b[b != k]
        found, limit = gaps(solids, np.full(len(b), k), b), reach + solids.bound[k] + solids.bound[b]
        contacts = []
        for i in np.flatnonzero(is_requested[b] | (found.width < limit)):
            gap, normal = float(found.width[i]), found.normal[i]
            pair = [PosedSolid(solids.shapes[j], solids.T[j]) for j in (k, b[i])]
            # A lower bound of the distance; that of boxes is positive whenever they are apart.
            if gap > 0.0 or any(solid.shape.kind is not ShapeKind.BOX for solid in pair):
                exact, across = separation(pair[0], pair[1], normal)
                gap, normal = (exact, across) if exact > max(gap, 0.0) else (gap, normal)
            if is_requested[b[i]] or gap < limit[i]:
                contacts.append(SolidContact(item_id, solids.names[b[i]], gap, normal))
        return tuple(contacts)

    def chain(self, following: Callable[[str], Iterable[str]], name: str) -> frozenset[str]:
        """Collect the items reachable from an item by a relation: all on it, or all under it.

        Args:
            following: ``carriers`` or ``lying_on``.
            name: Id of the item.

        Returns:
            Ids, without the item's own.
        """
        found: set[str] = set()
        todo = [name]
        while todo:
            more = (set(following(todo.pop())) & self.items.keys()) - found - {name}
            found |= more
            todo += more
        return frozenset(found)

    @cached_property
    def items(self) -> Mapping[str, PlacedItem]:
        """The items by id."""
        return {placed.id: placed for placed in self.scene.items}

    @cached_property
    def index(self) -> Mapping[str, int]:
        """Index in ``solids`` by item id or body name."""
        return {name: k for k, name in enumerate(self.solids.names)}

    @cached_property
    def _grown(self) -> PosedSolids:
        """All solids in the order of ``solids``, with carrier bodies grown by the errors of their poses."""
        return PosedSolids.of(self.scene, self.scene.items, self.scene.grown)

    def _below(self, name: str) -> Iterator[SolidContact]:
        """Contact of an item without support with the nearest solid below: one of the two poses is off."""
        solids, k = self.solids, self.index[name]
        half = solids.upright
        apart = np.abs(solids.T[:, :2, 3] - solids.T[k, :2, 3]) < half[:, :2] + half[k, :2]
        tops = solids.T[:, 2, 3] + half[:, 2]
        fall = solids.T[k, 2, 3] - half[k, 2] - tops
        under = apart.all(axis=1) & (solids.T[:, 2, 3] < solids.T[k, 2, 3]) & (np.arange(len(half)) != k)
        for other in self.scene.items:
            under[self.index[other.id]] &= other.location == self.items[name].location
        under &= ~np.isin(np.array(solids.names), _unknown(self.scene))
        if under.any():
            nearest = int(np.argmin(np.where(under, fall, np.inf)))
            yield SolidContact(name, solids.names[nearest], float(fall[nearest]), -_UP)


def _unknown(scene: Scene) -> list[str]:
    """Names of the boxes of unknown space."""
    return [body.name for space in scene.unknown for body in space.bodies]
