"""Clusters: objects of one product that stand so close that the open hand has no room between them.

The hand does not single one out: it comes in along a level direction to the closest point of the cluster, and
closes on whatever is there. Source: Krug et al., RA-L 2016, section III-A, Fig. 3c.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.hand.belt_hand import BeltHand
from pickcli.scene.scene import PlacedItem, Scene

ROOM = 0.03  # m between two objects, of which a finger and its way to close need more
DIRECTIONS = 48  # that are looked from
BESIDE = 0.1  # m to either side, seen along a direction: what stands there is met by the open fingers


@dataclass(frozen=True, eq=False)
class ClusterApproach:
    """An approach to the closest point of a cluster.

    Attributes:
        T_world_hand: (4, 4) of the hand where it is to close; it comes along its x axis.
        overhang: m by which the closest object overhangs the next one that the open fingers meet: the larger
            it is, the more of it stands between them; infinite if there is no other one.
    """

    T_world_hand: Array
    overhang: float


@dataclass(frozen=True, eq=False)
class Cluster:
    """Objects of one product that stand close together.

    Attributes:
        names: Ids of the items.
        middles: (N, 3) m in the world.
        height: m of each.
    """

    names: tuple[str, ...]
    middles: Array
    height: float

    @classmethod
    def around(cls, scene: Scene, name: str) -> Cluster:
        """Return the cluster that an item belongs to.

        Args:
            scene: The scene as perceived.
            name: Id of the item.

        Returns:
            The cluster; of the item alone if none of its product stands close.
        """
        first = scene.find(name)
        kind = first.item.name, first.location
        alike = [each for each in scene.items if (each.item.name, each.location) == kind]
        found = [first]
        for each in found:
            found += [other for other in alike if other not in found and _gap(each, other) < ROOM]
        middles = np.array([each.T_world_item[:3, 3] for each in found])
        return cls(tuple(each.id for each in found), middles, float(first.item.shape.extents[2]))

    def approaches(self, hand: BeltHand) -> list[ClusterApproach]:
        """Return approaches to the closest point from all around, those with the largest overhang first.

        Args:
            hand: The hand.

        Returns:
            The approaches.
        """
        found: list[ClusterApproach] = []
        for yaw in (np.arange(DIRECTIONS) * 2 * np.pi / DIRECTIONS).tolist():
            R = rotation_axis_angle((0.0, 0.0, 1.0), yaw)
            along, aside, _ = (self.middles @ R).T
            nearest = int(along.argmin())
            beside = (np.abs(aside - aside[nearest]) < BESIDE) & (np.arange(len(along)) != nearest)
            overhang = float((along[beside] - along[nearest]).min(initial=np.inf))
            at = self.middles[nearest] - hand.control.cluster_reach * R[:, 0]
            found.append(ClusterApproach(pose(at, R=R), overhang))
        return sorted(found, key=lambda each: -each.overhang)


def _gap(a: PlacedItem, b: PlacedItem) -> float:
    """Least distance (m) of two upright items, seen from above: the widest gap along any of some directions.

    These are from middle to middle and across the sides of boxes, so that two corners may be farther apart.
    """
    between = (b.T_world_item - a.T_world_item)[:2, 3]
    sides = [each.T_world_item[:2, :2].T for each in (a, b) if _is_box(each)]
    along = np.vstack([between[None], *sides])
    along /= np.linalg.norm(along, axis=1, keepdims=True).clip(1e-9)  # middles may fall together
    return float((np.abs(along @ between) - _half_width(a, along) - _half_width(b, along)).max())


def _is_box(each: PlacedItem) -> bool:
    return len(each.item.shape.size) == 3


def _half_width(each: PlacedItem, along: Array) -> Array:
    """Half the width (N,) m of an upright item along level directions (N, 2)."""
    half = each.item.shape.extents[:2] / 2
    if _is_box(each):
        return np.asarray(np.abs(along @ each.T_world_item[:2, :2]) @ half)
    return np.full(len(along), float(half.max()))
