"""What is known to be in a place before a picture of it is looked at."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.item import Item

MEAN_DEPTH = 0.3  # of the deformation, in which the surface of a deformed look is in the mean


@dataclass(frozen=True)
class ListedItem:
    """An item that is known to be in a place.

    Attributes:
        id: Id of the instance.
        item: The item.
        deformation: m by which its surface may be inside of its shape; 0 if it is known to look like that.
    """

    id: str
    item: Item
    deformation: float = 0.0

    @classmethod
    def of(cls, item_id: str, item: Item, may_deform: bool) -> ListedItem:
        """List an item.

        Args:
            item_id: Id of the instance.
            item: The item.
            may_deform: Whether cloth, bags and plush may look other than their boxes, as their files say.

        Returns:
            The listed item.
        """
        return cls(item_id, item, item.deformation if may_deform else 0.0)

    @property
    def seen_as(self) -> Item:
        """The item with the shape that its surface has in the mean."""
        if not self.deformation:
            return self.item
        return replace(self.item, shape=self.item.shape.inflated(-MEAN_DEPTH * self.deformation))
