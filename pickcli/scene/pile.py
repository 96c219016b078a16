"""Height map of the items in a place that is open above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.scene.scene import Scene

STEADY = 0.01  # m from the edge of a crown, within which an item's centre may turn out to be beyond it


@dataclass(frozen=True, eq=False)
class Pile:
    """Items of a place as boxes along the place's axes, and the room around them.

    In m, in a frame with the origin of the world and the axes of the place.

    Attributes:
        centres: (K, 2) centres of the items.
        half: (K, 2) half extents of their boxes.
        ridges: (K, 2) unit directions of their crowns, which are the areas at the height of their tops.
        crowns: (K, 2) half extents of the crowns, along and across the ridges.
        tops: (K,) heights.
        items: Ids of the items.
        middle: (2,) centre of the room.
        half_room: (2,) half extents of the room.
        floor: Height of the floor.
        rim: Height of the rim around the mouth.
    """

    centres: Array
    half: Array
    ridges: Array
    crowns: Array
    tops: Array
    items: tuple[str, ...]
    middle: Array
    half_room: Array
    floor: float
    rim: float

    @classmethod
    def of(cls, scene: Scene, place: Place) -> Pile:
        """Build the height map of a place.

        Args:
            scene: Poses as perceived.
            place: A place that is open above.

        Returns:
            The pile, with items grown by the bounds of their pose errors.
        """
        placed = scene.in_location(place.name)
        room, T_world_place = place.room, scene.T_world_place(place)
        R_place_world = T_world_place[:3, :3].T
        R = [R_place_world @ i.T_world_item[:3, :3] for i in placed]
        reach = [i.item.shape.reach(R_item) + scene.bound(i) for i, R_item in zip(placed, R, strict=True)]
        at = np.array([R_place_world @ i.T_world_item[:3, 3] for i in placed]).reshape(-1, 3)
        half = np.array(reach).reshape(-1, 3)
        origin = (T_world_place @ [*(room.low + room.high)[:2] / 2, 0.0, 1.0])[:3]
        middle = (R_place_world @ origin)[:2]
        floor = float(T_world_place[2, 3]) + room.floor_back
        rim = float(T_world_place[2, 3] + place.access.T_place_mouth[2, 3])
        tops = at[:, 2] + half[:, 2]
        crowned = [_crown(i.item.shape, R_item) for i, R_item in zip(placed, R, strict=True)]
        ridges, crowns = np.array(crowned).reshape(-1, 2, 2).swapaxes(0, 1)
        items, half_room = tuple(i.id for i in placed), room.size[:2] / 2
        return cls(at[:, :2], half[:, :2], ridges, crowns, tops, items, middle, half_room, floor, rim)

    def heights(self, centres: Array, half: Array) -> Array:
        """Compute the height of the pile under footprints.

        Args:
            centres: (..., 2) centres of the footprints.
            half: (..., 2) half extents of the footprints.

        Returns:
            (...) height in the world of the highest item under each footprint, else of the floor.
        """
        return np.asarray(self._under(centres, half).max(axis=-1, initial=self.floor))

    def levers(self, centres: Array, half: Array) -> Array:
        """Compute how far off its centre an item would be supported if it were set down.

        Args:
            centres: (..., 2) centres of the footprints.
            half: (..., 2) half extents of the footprints.

        Returns:
            (...) m from the centre of each footprint to the crown of the highest item under it.
        """
        if not self.items:
            return np.zeros(centres.shape[:-1])
        apart, crowns, _ = self._beside_crowns(centres, half)
        beside = np.linalg.norm(np.maximum(apart - crowns, 0.0), axis=-1)
        return np.where(self.heights(centres, half) > self.floor, beside, 0.0)

    def turn_ups(self, centres: Array, half: Array) -> Array:
        """Compute how far an end of an item can rise above its top if it turns over where it lands.

        An item whose centre is not well over the crown of the highest item under it turns about the edge of
        that crown, or about a ridge, until its lower end meets the floor. Its other end, at the distance b
        from that edge and d thick, rises by b sin(t) - d (1 - cos(t)) at the angle t: the most where tan(t)
        is b / d.

        Args:
            centres: (..., 2) centres of the footprints.
            half: (..., 3) half extents of the boxes around the item, along the axes of the place.

        Returns:
            (...) m over the item's top as it lands; 0 where it comes to rest on a wide crown or the floor.
        """
        if not self.items:
            return np.zeros(centres.shape[:-1])
        apart, crowns, axes = self._beside_crowns(centres, half[..., :2])
        lever = np.maximum(apart - crowns, 0.0)
        reach = (np.abs(axes) * half[..., None, :2]).sum(axis=-1)
        rising, falling = np.maximum(reach - lever, 0.0), reach + lever
        thick = 2.0 * half[..., 2:]
        top = self.heights(centres, half[..., :2])
        sine = np.minimum((top - self.floor)[..., None] / falling, rising / np.hypot(rising, thick))
        rise = rising * sine - thick * (1.0 - np.sqrt(1.0 - sine**2))
        return np.asarray(np.where(crowns - apart < STEADY, rise, 0.0).max(axis=-1))

    def covered(self, centres: Array, half: Array, names: frozenset[str]) -> Array:
        """Count the items whose centre lies under footprints.

        Args:
            centres: (..., 2) centres of the footprints.
            half: (..., 2) half extents of the footprints.
            names: Ids of the items that count.

        Returns:
            (...) number of these items under each footprint.
        """
        counts = np.array([name in names for name in self.items], dtype=bool)
        apart = np.abs(centres[..., None, :] - self.centres[counts])
        return np.asarray((apart <= half[..., None, :]).all(axis=-1).sum(axis=-1))

    def highest(self, centre: Array, half: Array) -> str:
        """Return the id of the highest item under a footprint.

        Args:
            centre: (2,) centre of the footprint.
            half: (2,) half extents of the footprint.

        Returns:
            Its id, "" if there is none.
        """
        tops = self._under(centre, half)
        return self.items[int(np.argmax(tops))] if tops.max(initial=self.floor) > self.floor else ""

    def _beside_crowns(self, centres: Array, half: Array) -> tuple[Array, Array, Array]:
        """Return where centres are from the middle of the crown of the highest item under each footprint.

        Returns:
            (..., 2) m along and across its ridge, (..., 2) half extents of the crown, (..., 2, 2) these axes.
        """
        first = self._under(centres, half).argmax(axis=-1)
        along = self.ridges[first]
        axes = np.stack([along, along[..., ::-1] * (-1.0, 1.0)], axis=-2)
        apart = np.abs((axes * (centres - self.centres[first])[..., None, :]).sum(axis=-1))
        return apart, self.crowns[first], axes

    def _under(self, centres: Array, half: Array) -> Array:
        """Top of each item under each footprint (..., K); the floor for items that are not under it."""
        apart = np.abs(self.centres - centres[..., None, :])
        return np.where((apart < self.half + half[..., None, :]).all(axis=-1), self.tops, self.floor)


def _crown(shape: Shape, R: Array) -> Array:
    """Direction (2,) and half extents (2,) of the area at top height of an item with orientation R (3, 3).

    For a lying cylinder it is the ridge, for a sphere a point, else the whole footprint.
    """
    if shape.kind is ShapeKind.SPHERE:
        return np.array([[1.0, 0.0], [0.0, 0.0]])
    lies = float(np.linalg.norm(R[:2, 2]))
    if shape.kind is ShapeKind.CYLINDER and lies > np.sqrt(0.5):
        return np.array([R[:2, 2] / lies, [lies * shape.size[1] / 2, 0.0]])
    return np.array([[1.0, 0.0], shape.reach(R)[:2]])
