"""Disturbances: items that moved unintentionally.

A neighbour that is carried along with a target, toppled or pushed aside costs no points while it stays in its
bin, but it is reported: an item that moved unplanned once may fall the next time.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pickcli.geometry import rotation_angle
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.places import bounds

MAX_SETTLING = 0.005  # m, displacement of an item's centre; less is settling after the support changed
MAX_SETTLING_ANGLE = np.radians(5.0)  # rad, rotation up to which it is that too
MIN_TOPPLING_ANGLE = np.radians(45.0)  # rad, change of an item's upward direction
MIN_CARRIED_DISTANCE = 0.10  # m, displacement beyond which an item was carried along


class DisturbanceKind(StrEnum):
    """What happened to an item; the worst that applies."""

    FELL = "fell"
    CARRIED = "carried along"
    TOPPLED = "toppled"
    PUSHED = "pushed"


@dataclass(frozen=True)
class Disturbance:
    """One item that moved in a motion that was not meant to move it.

    Attributes:
        item: Id of the item.
        kind: What happened to it.
        moved: Displacement of its centre, m.
        turned: Rotation, rad.
        fell: Descent of its lowest point, m; 0 if it is not lower.
        out_of: Place before.
        into: Place after.
    """

    item: str
    kind: DisturbanceKind
    moved: float
    turned: float
    fell: float
    out_of: str
    into: str


def disturbances(
    before: Scene, after: Scene, meant: Collection[str], drop_limit: float
) -> tuple[Disturbance, ...]:
    """Find items that moved between two true scenes, except intentionally moved ones.

    An item that is in only one of the scenes is held in the other.

    Args:
        before: The true scene before.
        after: The true scene after.
        meant: Ids of the items that were picked or released.
        drop_limit: m, descent that counts as a fall by the rules.

    Returns:
        The disturbances, sorted by id.
    """
    was = {placed.id: placed for placed in before.items}
    boxes = [place.name for place in after.cell.places.values() if place.is_open_box]
    found = (
        _disturbed(was[placed.id], placed, drop_limit, boxes)
        for placed in sorted(after.items, key=lambda placed: placed.id)
        if placed.id in was and placed.id not in meant
    )
    return tuple(d for d in found if d is not None)


def _disturbed(a: PlacedItem, b: PlacedItem, drop_limit: float, boxes: Collection[str]) -> Disturbance | None:
    T_a, T_b = a.T_world_item, b.T_world_item
    moved = float(np.linalg.norm(T_b[:3, 3] - T_a[:3, 3]))
    R = T_b[:3, :3] @ T_a[:3, :3].T
    turned = rotation_angle(R)
    if moved <= MAX_SETTLING and turned <= MAX_SETTLING_ANGLE and a.location == b.location:
        return None
    if a.location == b.location and a.location in boxes:
        return None  # released items push others in a box
    fell = max(0.0, float(bounds(a.item.shape, T_a)[0][2] - bounds(b.item.shape, T_b)[0][2]))
    kind = DisturbanceKind.PUSHED
    if fell > drop_limit:
        kind = DisturbanceKind.FELL
    elif moved > MIN_CARRIED_DISTANCE or a.location != b.location:
        kind = DisturbanceKind.CARRIED
    elif R[2, 2] < np.cos(MIN_TOPPLING_ANGLE):
        kind = DisturbanceKind.TOPPLED
    return Disturbance(a.id, kind, moved, turned, fell, a.location, b.location)
