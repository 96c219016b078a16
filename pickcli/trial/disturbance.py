"""What else moved: items that nobody meant to move, and how they lie since.

A neighbour that is carried along on a target, toppled by it or pushed aside costs nothing by the rules as
long as it stays in its bin; it is named all the same: what moved unplanned once may fall the next time.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pickcli.geometry import rotation_angle
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.places import bounds

MOVED = 0.005  # m of an item's centre; less is how items settle again when their support goes
TURNED = np.radians(5.0)
TOPPLED = np.radians(45.0)  # by which what pointed up points elsewhere
CARRIED = 0.10  # m


class DisturbanceKind(StrEnum):
    """What became of an item, the worst that applies."""

    FELL = "fell"
    CARRIED = "carried along"
    TOPPLED = "toppled"
    PUSHED = "pushed"


@dataclass(frozen=True)
class Disturbance:
    """One item that lies otherwise than before a motion that was not about it.

    Attributes:
        item: Its id.
        kind: What became of it.
        moved: How far its centre went, m.
        turned: How far it turned, rad.
        fell: How much lower its lowest point is, m; 0 if it is not lower.
        out_of: Place where it was.
        into: Place where it is.
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
    """Find items that moved from one true scene to the other, without those that were meant to.

    An item that is in one of the scenes only is held in the other.

    Args:
        before: The true scene before.
        after: The true scene after.
        meant: Ids of the items that were picked or let go.
        drop_limit: m, from which on going down is a fall by the rules.

    Returns:
        What became of them, sorted by id.
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
    if moved <= MOVED and turned <= TURNED and a.location == b.location:
        return None
    if a.location == b.location and a.location in boxes:
        return None  # what is let go over others pushes them
    fell = max(0.0, float(bounds(a.item.shape, T_a)[0][2] - bounds(b.item.shape, T_b)[0][2]))
    kind = DisturbanceKind.PUSHED
    if fell > drop_limit:
        kind = DisturbanceKind.FELL
    elif moved > CARRIED or a.location != b.location:
        kind = DisturbanceKind.CARRIED
    elif R[2, 2] < np.cos(TOPPLED):
        kind = DisturbanceKind.TOPPLED
    return Disturbance(a.id, kind, moved, turned, fell, a.location, b.location)
