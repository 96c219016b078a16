"""The support relation of a scene: what falls, rolls or slumps when an item is taken away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from pickcli.scene.balance import Balance
from pickcli.scene.contact_graph import ContactGraph
from pickcli.scene.scene import Scene
from pickcli.scene.solid_contact import SolidContact


@dataclass(frozen=True, eq=False)
class Supports:
    """The support relation of one scene. Make it with ``supports_of``.

    Attributes:
        graph: What touches what, and what rests on what by that.
        balance: Whether contacts that are left keep an item in balance.
    """

    graph: ContactGraph
    balance: Balance

    def falling(self, item_id: str) -> tuple[str, ...]:
        """Items that would fall or roll away if an item were gone.

        Those that lie on it or lean on it, those that lie or lean on these, and those under it that keep
        their balance only by its weight. What can roll on a level floor and is not pushed stays: see
        ``rolling``.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids, what must be moved first at the head.
        """
        below = self.graph.chain(self.graph.carriers, item_id)
        tipping = {name for name in below if self.balance.is_tipping(name, without=item_id)}
        gone, todo = frozenset({item_id, *tipping}), [item_id, *sorted(tipping)]
        while todo:
            for contact in self.graph.touching[todo.pop()]:
                name = contact.b
                if name in self.graph.items and name not in gone and self._falls(name, contact, gone, below):
                    gone |= {name}
                    todo.append(name)
        return tuple(sorted(gone - {item_id}, key=lambda name: (-self._bottom[name], name)))

    def slumping(self, item_id: str) -> tuple[str, ...]:
        """Of the items that would fall without an item, those that only slump and do not keep it in.

        Between the walls of a box that is open above nothing falls far. What is beside the item or under it
        gives way downwards when it is lifted out: a centre of mass that nothing lifts does not rise, and so
        does not get over a rim that it is below. What lies on the item, on all that does, would be lifted.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids, in the order of ``falling``.
        """
        rim = self._rim(item_id)
        if rim is None:
            return ()
        lifted = self.graph.chain(self.graph.lying_on, item_id)
        return tuple(
            name for name in self.falling(item_id) if name not in lifted and self._highest_centre(name) < rim
        )

    def blocking(self, item_id: str) -> tuple[str, ...]:
        """Items that must go before an item: what would fall or roll away without it, and not only slump.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids, what must be moved first at the head.
        """
        slumping = self.slumping(item_id)
        return tuple(name for name in self.falling(item_id) if name not in slumping)

    def rolling(self, item_id: str) -> tuple[str, ...]:
        """Items that stay if an item that they touch is taken away, but roll as soon as they are pushed.

        Args:
            item_id: Id of the item that is taken away.

        Returns:
            Ids.
        """
        gone = frozenset({item_id, *self.falling(item_id)})
        left = [c.b for c in self.graph.touching[item_id] if c.b in self.graph.touching and c.b not in gone]
        return tuple(
            name
            for name in left
            if self.balance.lies_level(name, gone) and not self.balance.stays(name, gone)
        )

    def _falls(self, name: str, contact: SolidContact, gone: frozenset[str], below: frozenset[str]) -> bool:
        """Whether an item comes along with one that it touches.

        contact: of the one that goes, seen from that. below: all that the target rests on
        """
        if contact.flipped.carries:
            return True  # it lies on what goes, be it only in part
        if self.balance.stays(name, gone):
            return False
        if name in below:  # what is lifted off it may be its counterweight, or keep it on a slope
            return self.balance.stays(name) or contact.is_steep
        return not self.balance.lies_level(name, gone)

    def _rim(self, item_id: str) -> float | None:
        """Height in the world of the rim of the open box that an item is in; None where it is in none."""
        scene = self.graph.scene
        place = scene.cell.places.get(self.graph.items[item_id].location)
        if place is None or not place.is_open_box:
            return None
        return float((scene.T_world_place(place) @ place.access.T_place_mouth)[2, 3])

    def _highest_centre(self, name: str) -> float:
        """Height in the world of an item's centre, as high as its pose may be off."""
        placed = self.graph.items[name]
        return float(placed.T_world_item[2, 3] + self.graph.scene.noise.bound(placed.item))

    @cached_property
    def _bottom(self) -> Mapping[str, float]:
        """Lowest point of every item, m."""
        bottoms = self.graph.solids.T[:, 2, 3] - self.graph.solids.upright[:, 2]
        return dict(zip(self.graph.solids.names, bottoms.tolist(), strict=True))


@lru_cache(maxsize=32)
def supports_of(scene: Scene) -> Supports:
    """The support relation of a scene, from the poses and how well they are known. Cached by identity.

    Args:
        scene: Items, the carriers where they really stand, and the bounds of the error of the items' poses.

    Returns:
        The relation.
    """
    graph = ContactGraph.of(scene)
    return Supports(graph, Balance(graph))
