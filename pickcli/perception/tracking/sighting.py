"""What one picture of a conveyor shows."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pickcli.cell.item import Item
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class Detection:
    """One item in a picture.

    Attributes:
        item: The product.
        T_belt_item: (4, 4) measured pose in the frame of the conveyor, which stands still in the hall.
        label: What tells this piece from others of its product, such as a code that was read; "" if nothing.
    """

    item: Item
    T_belt_item: Array
    label: str = ""


@dataclass(frozen=True, eq=False)
class Sighting:
    """All items that one picture shows.

    Attributes:
        stamp: s, when the picture was taken; its detections are known later.
        detections: The items.
        view: m along the belt, between which the picture shows it.
    """

    stamp: float
    detections: tuple[Detection, ...]
    view: tuple[float, float] = (-math.inf, math.inf)


@dataclass(frozen=True)
class SightingNoise:
    """Errors of detections.

    Attributes:
        position: m, standard deviation along each axis, of the part that differs from picture to picture.
        angle: rad, the same of the yaw.
        mount: m, bound of the part that all pictures share: the error of the camera's mount.
    """

    position: float
    angle: float
    mount: float = 0.0
