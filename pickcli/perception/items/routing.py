"""Which way of recognition each item of a place takes, by what it looks like and by the camera.

The perception server of KTH (paper 000, III-B and Fig. 4) forwards a request by item and sensor: textured
items to SIFT, compared with all views of a model for quick looks (*simtrack*) or view by view for close ones
(*simtect*), untextured ones to colour and shape of what is left; and it is told what else is in the bin, "to
avoid detection conflicts". Here shape and colour are always looked at, and a route says whether a print is
looked for, too. Where items are is still decided for all of a place together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, inverse
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.product_model import product_model
from pickcli.perception.textures.sift_views import SiftRule, SiftViews

LEAST_PIXELS = 24.0  # across the smaller side of an item's largest face, from which on prints are recognised
LIKE_SIZE = 0.004  # m by which the extents of items of like shape differ at most
LIKE_COLOUR = 0.9  # least overlap of the colours of items of like colour (Bhattacharyya's coefficient)
NOT_PRINTED = _PLAIN, _UNSTATED = "it is plain", "its file states no print"
_VIEWS_OF_RULES = {SiftRule.ALL: SiftViews.ALL, SiftRule.EACH: SiftViews.EACH}


@dataclass(frozen=True)
class PrintSearch:
    """Whether and how prints are looked for.

    Attributes:
        rule: For which items.
        texture_seed: Seed of the set of prints that models are made from.
    """

    rule: SiftRule
    texture_seed: int


NO_PRINTS = PrintSearch(SiftRule.NONE, 0)


@dataclass(frozen=True)
class ItemRoute:
    """The way of recognition of one listed item.

    It has no deadline: the work of each recogniser is bounded by counts, so that no clock decides an answer.

    Attributes:
        views: How its print is looked for besides shape and colour; None if it is not.
        why: Why not; "" if it is.
        twins: Names of other items of the place that shape and colour do not tell from it, in order.
    """

    views: SiftViews | None
    why: str = ""
    twins: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """The route in short, as "by shape: it is plain"."""
        way = f"by shape: {self.why}" if self.views is None else f"by print ({self.views}) and shape"
        return f"{way}; like {', '.join(self.twins)}" if self.twins else way


def routes_of(
    listed: Sequence[ListedItem], pixels_per_mm: float, rule: SiftRule = SiftRule.AUTO
) -> tuple[ItemRoute, ...]:
    """Decide which way of recognition each item takes.

    It follows from the arguments alone, and of an item not from where in the list it is. Rules, of which the
    first that holds counts:

    1. What is plain has no print to look for (III-B: "textured" and "untextured").
    2. ``rule``, if it is not ``AUTO``.
    3. What deforms has no print where its model has it.
    4. A print needs pixels: of well seen ones with less than ``LEAST_PIXELS`` across 1 of 163 was recognised
       (docs/perception.md, "Routes").
    5. All other prints are compared with all views at once. KTH compares view by view with its wrist cameras,
       as that finds more; here it is right less often, and takes longer (same place).

    Twins are items of other products whose extents differ by up to ``LIKE_SIZE`` and whose colours overlap by
    ``LIKE_COLOUR``. KTH refuses what is of like colour as another item of the bin; here the shape counts,
    too, and only what no print told apart is refused. In single looks boxes were swapped up to a difference
    of 1 mm, and from an overlap of 0.99 on (``python -m bench.twins``); the limits leave a margin.

    Args:
        listed: What is known to be in the place.
        pixels_per_mm: Of the picture, at the mouth of the place.
        rule: Which prints may be looked for.

    Returns:
        A route for each item, in their order.

    Raises:
        InputError: An item has no model.
    """
    items = sorted({each.item for each in listed}, key=lambda item: (item.name, item.year))
    return tuple(
        ItemRoute(*_views(each, pixels_per_mm, rule), _twins_of(each.item, items)) for each in listed
    )


def pixels_per_mm(camera: PinholeCamera, T_world_camera: Array, place: Place, T_world_place: Array) -> float:
    """Compute how many pixels of a picture a millimetre at the mouth of a place fills.

    Args:
        camera: Intrinsics of the camera.
        T_world_camera: (4, 4) its pose.
        place: The place.
        T_world_place: (4, 4) its pose.

    Returns:
        Pixels of a row, in a plane parallel to the picture's through the middle of the mouth; 0 if that is
        behind the camera.
    """
    T_camera_mouth = inverse(T_world_camera) @ T_world_place @ place.access.T_place_mouth
    depth = float(T_camera_mouth[2, 3])
    return camera.fx / (1e3 * depth) if depth > 0.0 else 0.0


def why_not_printed(item: Item) -> str:
    """Tell why an item has no print that could be looked for.

    Args:
        item: The item.

    Returns:
        One of ``NOT_PRINTED``; "" if it has one.
    """
    if item.is_printed:
        return ""
    return _PLAIN if item.colour is not None else _UNSTATED


def _views(each: ListedItem, pixels_per_mm: float, rule: SiftRule) -> tuple[SiftViews | None, str]:
    """How the print of an item is looked for, and why it is not."""
    if why := why_not_printed(each.item):
        return None, why
    if rule is SiftRule.NONE:
        return None, "prints are left out"
    if rule is not SiftRule.AUTO:
        return _VIEWS_OF_RULES[rule], ""
    if each.deformation:
        return None, "it may be rumpled"
    across = 1e3 * float(np.sort(each.item.shape.extents)[1])  # mm
    if pixels_per_mm * across < LEAST_PIXELS:
        return None, f"{pixels_per_mm:.2f} pixels per mm, its print needs {LEAST_PIXELS / across:.2f}"
    return SiftViews.ALL, ""


def _twins_of(item: Item, items: Sequence[Item]) -> tuple[str, ...]:
    return tuple(other.name for other in items if other != item and _are_alike(item, other))


def _are_alike(one: Item, other: Item) -> bool:
    """Whether shape and colour do not tell two items apart; what is printed on them looks as nobody knows."""
    extents, others = np.sort(one.shape.extents), np.sort(other.shape.extents)
    if one.shape.kind is not other.shape.kind or np.abs(extents - others).max() > LIKE_SIZE:
        return False
    shares, of_other = (product_model(replace(each, is_printed=False)).label_shares for each in (one, other))
    return float(np.sqrt(shares * of_other).sum()) >= LIKE_COLOUR
