"""Support relation of a scene: which items fall, roll or slump when an item is removed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

from pickcli.scene.scene import Scene
from pickcli.statics.balance import Balance
from pickcli.statics.contact_graph import ContactGraph
from pickcli.statics.solid_contact import SolidContact

HEAVIEST_SLUMP = 0.6  # kg: what is heavier, and falls on one end of another item, may throw that out


@dataclass(frozen=True, eq=False)
class Supports:
    """The support relation of a scene. Create it with ``supports_of``.

    Attributes:
        graph: The contacts of the scene.
        balance: Statics of single items with their remaining contacts.
    """

    graph: ContactGraph
    balance: Balance

    def falling(self, item_id: str) -> tuple[str, ...]:
        """Return the items that would fall or roll away if an item were removed.

        These are items that lie or lean on it, directly or indirectly, and items below it that are balanced
        only by its weight. An item that can roll but lies on a level floor and is not pushed stays: see
        ``rolling``.

        Args:
            item_id: Id of the removed item.

        Returns:
            Ids, in the order in which they must be moved away.
        """
        below = self.graph.chain(self.graph.carriers, item_id)
        tipping = {name for name in below if self.balance.is_tipping(name, without=item_id)}
        gone, todo = frozenset({item_id, *tipping}), [item_id, *sorted(tipping)]
        while todo:
            for contact in self.graph.touching[todo.pop()]:
                name = contact.b
                if (
                    name in self.graph.items
                    and name not in gone
                    and self._falls(item_id, contact, gone, below)
                ):
                    gone |= {name}
                    todo.append(name)
        return tuple(sorted(gone - {item_id}, key=lambda name: (-self._bottom[name], name)))

    def slumping(self, item_id: str) -> tuple[str, ...]:
        """Return those of the falling items that only slump, and so do not block the removed item.

        Between the walls of an open box nothing falls far. Items beside or below the removed one give way
        downwards: a centre of mass that is not lifted does not rise, so it does not get over the rim. Items
        that lie on the removed one, directly or indirectly, would be lifted and are not included, nor is what
        is heavy: it could throw others out.

        Args:
            item_id: Id of the removed item.

        Returns:
            Ids, in the order of ``falling``.
        """
        rim = self.rim(item_id)
        if rim is None:
            return ()
        lifted = self.graph.chain(self.graph.lying_on, item_id)
        return tuple(
            name
            for name in self.falling(item_id)
            if name not in lifted
            and self.graph.items[name].item.heaviest <= HEAVIEST_SLUMP
            and not self.may_leave_over(rim, name)
        )

    def blocking(self, item_id: str) -> tuple[str, ...]:
        """Return the items that must be removed before an item: those that would fall or roll.

        Args:
            item_id: Id of the removed item.

        Returns:
            Ids, in the order in which they must be moved away.
        """
        slumping = self.slumping(item_id)
        return tuple(name for name in self.falling(item_id) if name not in slumping)

    def rolling(self, item_id: str) -> tuple[str, ...]:
        """Return the items that stay when an item in contact with them is removed, but roll if pushed.

        Args:
            item_id: Id of the removed item.

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

    def rim(self, item_id: str) -> float | None:
        """Return the height in the world of the rim of the open box that contains an item.

        Args:
            item_id: Id of the item.

        Returns:
            m; None if the item is not in an open box.
        """
        scene = self.graph.scene
        place = scene.cell.places.get(self.graph.items[item_id].location)
        if place is None or not place.is_open_box:
            return None
        return float((scene.T_world_place(place) @ place.access.T_place_mouth)[2, 3])

    def highest_centre(self, name: str) -> float:
        """Return the largest height in the world of an item's centre within its pose error.

        Args:
            name: Id of the item.

        Returns:
            m.
        """
        placed = self.graph.items[name]
        return float(placed.T_world_item[2, 3] + self.graph.scene.bound(placed))

    def barrier(self, rim: float, name: str) -> float:
        """Return the height below which the centre of an item stays inside of its open box.

        As its centre passes straight above the rim, the rim is outside of the item, so at least half of its
        thickness below the centre.

        Args:
            rim: m, height of the rim in the world.
            name: Id of the item.

        Returns:
            m in the world.
        """
        return rim + float(self.graph.items[name].item.shape.extents.min()) / 2

    def may_leave_over(self, rim: float, name: str) -> bool:
        """Whether an item that falls may get over the rim of its open box; its centre does not rise.

        Args:
            rim: m, height of the rim in the world.
            name: Id of the item.

        Returns:
            Whether its centre may be over the barrier, within its pose error.
        """
        return self.highest_centre(name) >= self.barrier(rim, name)

    def _falls(self, taken: str, contact: SolidContact, gone: frozenset[str], below: frozenset[str]) -> bool:
        """Whether an item falls together with another that it touches.

        taken: id of the target. contact: as seen from the item that falls or is taken. below: all items that
        the target rests on
        """
        name = contact.b
        if contact.flipped.carries:
            return True  # it rests on the falling item, at least in part
        if self.balance.stays(name, gone):
            return False
        is_level = self.balance.lies_level(name, gone)
        if name not in below or (is_level and contact.a == taken):
            return not is_level
        # The removed item may have been its counterweight or chock, or push it as it falls.
        return self.balance.stays(name) or contact.is_steep

    @cached_property
    def _bottom(self) -> Mapping[str, float]:
        """Lowest point of every item, m."""
        bottoms = self.graph.solids.T[:, 2, 3] - self.graph.solids.upright[:, 2]
        return dict(zip(self.graph.solids.names, bottoms.tolist(), strict=True))


@lru_cache(maxsize=32)
def supports_of(scene: Scene) -> Supports:
    """Return the support relation of a scene from its poses and their uncertainty. Cached by identity.

    Args:
        scene: Items, carriers at their actual poses, and bounds of the items' pose errors.

    Returns:
        The relation.
    """
    graph = ContactGraph.of(scene)
    return Supports(graph, Balance(graph))
