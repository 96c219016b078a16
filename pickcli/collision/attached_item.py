"""An item in the cup, and the volume that it passes through while the cup turns."""

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
        item: What is held.
        T_tip_item: (4, 4) item frame in the tool frame.
        inflate: m, how far any of its points may be from where that pose says.
        id: Id of the item in its scene, "" of one that only stands for many.
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
    """Spheres around all that an attached item passes through while the cup turns.

    Cached by identity of the model and the attached item.

    Args:
        model: The collision model of the cell.
        attached: The item in the cup.

    Returns:
        The spheres, in the cup's frame.
    """
    T_last_item = model.robot.tool.T_last_tip @ attached.T_tip_item
    return model.swept(cover_shape(attached.item.shape).inflated(attached.inflate).moved(T_last_item))
