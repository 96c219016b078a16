"""Colours for pictures: fixed ones for stationary bodies, one per name for items."""

from __future__ import annotations

import colorsys
import zlib
from typing import TypeAlias

from pickcli.cell.item import Item

Colour: TypeAlias = tuple[float, float, float, float]  # red, green, blue and opacity, 0 to 1

STATIC_COLOURS: dict[str, Colour] = {
    "pod": (0.93, 0.82, 0.42, 1.0),  # the yellow fabric of a Kiva pod
    "tote": (0.30, 0.45, 0.70, 1.0),
    "cloud": (0.80, 0.35, 0.20, 1.0),
    "obstacle": (0.60, 0.62, 0.65, 1.0),
    "unknown": (0.25, 0.25, 0.30, 1.0),
}
_OWN: Colour = (0.45, 0.62, 0.48, 1.0)


def static_colour(carrier: str) -> Colour:
    """Return the colour of a stationary body.

    Args:
        carrier: Name of its carrier, or that of obstacles.

    Returns:
        Red, green, blue and opacity; the same for all user-defined carriers.
    """
    return STATIC_COLOURS.get(carrier, _OWN)


def item_colour(item: Item) -> Colour:
    """Return the colour of an item, which depends only on its name.

    Args:
        item: The item.

    Returns:
        Red, green, blue and opacity.
    """
    number = zlib.crc32(item.name.encode())
    hue, value = (number % 997) / 997, 0.60 + 0.35 * ((number >> 10) % 101) / 100
    red, green, blue = colorsys.hsv_to_rgb(hue, 0.75, value)
    return red, green, blue, 1.0
