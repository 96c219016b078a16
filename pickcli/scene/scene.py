"""Scenes: the cell as it stands now, with items and where they lie."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.cell.station import Pod
from pickcli.cell.tote import TOTE as TOTE
from pickcli.geometry import Array, inverse
from pickcli.scene.cloud import Cloud


@dataclass(frozen=True, eq=False)
class PlacedItem:
    """One instance of an item.

    Attributes:
        id: Unique in the scene: the item's name, or name#2 for a second copy.
        item: What it is.
        location: Name of a place.
        T_world_item: (4, 4) pose.
    """

    id: str
    item: Item
    location: str
    T_world_item: Array

    @property
    def can_roll(self) -> bool:
        """Whether the item rolls as it lies when it is pushed."""
        return self.item.can_roll(self.T_world_item[:3, :3])


@dataclass(frozen=True, eq=False)
class HeldItem:
    """What is in the cup.

    Attributes:
        id: May also stand among the scene's items: that is where it was seen.
        item: What it is.
        T_tip_item: (4, 4) pose in the tool frame, as it hangs.
    """

    id: str
    item: Item
    T_tip_item: Array


@dataclass(frozen=True, eq=False)
class PoseNoise:
    """Bounds of the error of every item pose: the true pose lies within them.

    Attributes:
        position: m, norm of the translation error, for each item.
        angle: rad, rotation error.
    """

    position: float = 0.0
    angle: float = 0.0

    def bound(self, item: Item) -> float:
        """How far any point of an item can be from where its pose says.

        Args:
            item: The item.

        Returns:
            m.
        """
        radius = float((item.shape.extents**2).sum() ** 0.5) / 2
        return self.position + self.angle * radius


@dataclass(frozen=True, eq=False)
class Scene:
    """The cell, where the pod stands now, items with their poses, and what the cup holds.

    Attributes:
        cell: The cell.
        T_world_pod: (4, 4) pose of the pod now.
        items: Items in their places.
        noise: Bounds of the error of the item poses in this scene.
        seed: Seed that the scene was made with.
        pod_error: How far the pod may stand from ``T_world_pod``.
        held: What the cup holds, None if nothing.
        cloud: What a sensor saw besides all this, None if nothing.
    """

    cell: Cell
    T_world_pod: Array
    items: tuple[PlacedItem, ...]
    noise: PoseNoise
    seed: int = 0
    pod_error: Displacement = UNMOVED
    held: HeldItem | None = None
    cloud: Cloud | None = None

    @cached_property
    def pod_bodies(self) -> tuple[Body, ...]:
        """The pod's bodies in its frame, each grown to wherever the error of the pod's pose may put it."""
        return _swept(self.cell.pod, self.pod_error)

    @property
    def standing(self) -> tuple[tuple[Body, Array], ...]:
        """Everything that stands in the cell, with the pose (4, 4) in the world of what it is part of.

        The pod's bodies first, in their order.
        """
        cell = self.cell
        return (
            *((body, self.T_world_pod) for body in cell.pod.bodies),
            *((body, np.eye(4)) for body in (*cell.tote_bodies, *cell.obstacles.bodies)),
        )

    @property
    def T_nominal_pod(self) -> Array:
        """(4, 4) pose of the pod, seen from its nominal place."""
        return np.asarray(inverse(self.cell.T_world_pod) @ self.T_world_pod)

    @property
    def is_pod_within_bounds(self) -> bool:
        """Whether the pod stands where the cell says that it may: what holds for any such pod holds here."""
        return self.cell.pod.displacement.allows(self.T_nominal_pod)

    def T_world_place(self, place: Place) -> Array:
        """Pose of a place's frame as the pod stands now.

        Args:
            place: A bin or the tote.

        Returns:
            (4, 4) in the world.
        """
        return place.in_world(self.T_world_pod)

    def find(self, id_or_name: str, location: str | None = None) -> PlacedItem:
        """Find an item by its id, or else by its name.

        Args:
            id_or_name: Id of an instance, or name of an item: the first with that name.
            location: Name of the place that it must be in; None for any.

        Returns:
            The instance.

        Raises:
            UnknownNameError: If there is none.
        """
        from pickcli.errors import UnknownNameError

        here = [i for i in self.items if location is None or i.location == location]
        for placed in here:
            if placed.id == id_or_name:
                return placed
        for placed in here:
            if placed.item.name == id_or_name:
                return placed
        elsewhere = sorted({i.location for i in self.items if id_or_name in (i.id, i.item.name)})
        hint = f"it is in {' and '.join(elsewhere)}" if elsewhere else ""
        raise UnknownNameError("item", id_or_name, [i.id for i in here], location or "scene", hint)

    def item(self, item_id: str) -> Item:
        """What an instance is, in the cup or not.

        Args:
            item_id: Id of the instance.

        Returns:
            The item.

        Raises:
            UnknownNameError: If there is none.
        """
        if self.held is not None and self.held.id == item_id:
            return self.held.item
        return self.find(item_id).item

    def in_location(self, location: str) -> tuple[PlacedItem, ...]:
        """All items of a bin or of the tote.

        Args:
            location: Name of a place.

        Returns:
            The instances.
        """
        return tuple(i for i in self.items if i.location == location)

    def moved(self, placed: PlacedItem) -> Scene:
        """The scene with one instance replaced.

        Args:
            placed: The instance as it is now; its id tells which one it replaces.

        Returns:
            The changed scene.
        """
        return replace(self, items=tuple(placed if i.id == placed.id else i for i in self.items))

    def without(self, item_id: str) -> Scene:
        """The scene without one instance.

        Args:
            item_id: Id of the instance.

        Returns:
            The changed scene.
        """
        return replace(self, items=tuple(i for i in self.items if i.id != item_id))


@lru_cache(maxsize=8)
def _swept(pod: Pod, error: Displacement) -> tuple[Body, ...]:
    """A pod's bodies, each grown to wherever an error of its pose may put it: the same in every look."""
    return tuple(map(error.swept, pod.bodies)) if error != UNMOVED else tuple(pod.bodies)
