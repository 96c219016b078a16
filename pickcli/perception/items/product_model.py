"""What is known of an item before it is seen: its shape and its colours."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.sensors.material import Material
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.kernel import SolidKind
from pickcli.perception.items.colour_model import item_colours, label_shares, own_labels

MODEL_TEXTURES = 0  # seed of the prints that models are made from
SOLID_KINDS = {
    ShapeKind.BOX: SolidKind.BOX,
    ShapeKind.CYLINDER: SolidKind.CYLINDER,
    ShapeKind.SPHERE: SolidKind.SPHERE,
}


@dataclass(frozen=True, eq=False)
class ProductModel:
    """Model of an item.

    Attributes:
        item: The item.
        kind: Kind of its shape in the kernel.
        half_extents: (3,) m; of a cylinder (r, r, half length), of a sphere (r, r, r).
        label_shares: How often each label of colour is seen on it.
        own_labels: Which of them it shows itself.
    """

    item: Item
    kind: SolidKind
    half_extents: Array
    label_shares: Array
    own_labels: NDArray[np.bool_]


@lru_cache(maxsize=256)
def product_model(item: Item, texture_seed: int = MODEL_TEXTURES) -> ProductModel:
    """Make the model of an item; cached.

    Args:
        item: The item.
        texture_seed: Seed of the prints on the copy of the item that the model is made from.

    Returns:
        The model.

    Raises:
        InputError: Its shape has no analytic distance.
    """
    kind = SOLID_KINDS.get(item.shape.kind)
    if kind is None:
        raise InputError(
            f"{item.name}: has no model: its shape is a {item.shape.kind}, models are boxes, cylinders and "
            "spheres"
        )
    colours = item_colours(item, texture_seed)
    own = own_labels(colours, item.material in (Material.SHINY, Material.CLEAR))
    return ProductModel(item, kind, np.asarray(item.shape.extents / 2), label_shares(colours), own)
