"""An item attached to the tool, and the volume that it sweeps while the cup turns."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from pickcli.cell.item import Item
from pickcli.collision.robot_model import CollisionModel
from pickcli.collision.sphere_cover import Cover, cover_shape
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class AttachedItem:
    """An item in the cup (MoveIt: an attached body).

    Attributes:
        item: The held item.
        T_tip_item: (4, 4) item frame in the tool frame.
        inflate: m, bound of the error of that pose, for any point of the item.
        id: Id of the item in its scene, "" for a stand-in of many items.
    """

    item: Item
    T_tip_item: Array
    inflate: float = 0.0
    id: str = ""

    @property
    def name(self) -> str:
        """Name of the held item in explanations."""
        return f"held {self.item.name}"


@lru_cache(maxsize=32)
def swept_cover(model: CollisionModel, attached: AttachedItem) -> Cover:
    """Return spheres around the volume that an attached item sweeps while the cup turns.

    Cached by identity of the model and the attached item.

    Args:
        model: The collision model of the cell.
        attached: The attached item.

    Returns:
        The spheres, in the cup's frame.
    """
    T_last_item = model.robot.tool.T_last_tip @ attached.T_tip_item
    return model.swept(cover_shape(attached.item.shape).inflated(attached.inflate).moved(T_last_item))
