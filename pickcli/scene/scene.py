"""Scenes: the cell as it stands now, with items and where they lie."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.cell.station import OBSTACLE, POD, Carrier
from pickcli.cell.station import TOTE as TOTE
from pickcli.errors import UnknownNameError
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
class CarrierPose:
    """Where a carrier stands now.

    Attributes:
        T_world_carrier: (4, 4) its pose.
        error: How far it may stand from there.
    """

    T_world_carrier: Array
    error: Displacement = UNMOVED


@dataclass(frozen=True, eq=False)
class PosedCarrier:
    """A carrier where it stands in a scene, or the obstacles.

    Attributes:
        name: Of the carrier; OBSTACLE of what is part of none.
        T_world_carrier: (4, 4) its pose.
        bodies: Its bodies, in its frame.
        error: How far it may stand from there.
    """

    name: str
    T_world_carrier: Array
    bodies: tuple[Body, ...]
    error: Displacement = UNMOVED

    @cached_property
    def grown(self) -> tuple[Body, ...]:
        """The bodies, each grown to wherever the error of the carrier's pose may put it."""
        return _swept(self.bodies, self.error)

    def uncertainty(self, body: Body) -> float:
        """How far any point of a body may be from where its pose says.

        Args:
            body: One of the bodies.

        Returns:
            m.
        """
        reach = np.linalg.norm(body.T_parent_shape[:2, 3]) + np.linalg.norm(body.shape.extents) / 2
        return self.error.bound(float(reach))


@dataclass(frozen=True, eq=False)
class Scene:
    """The cell, where its carriers stand now, items with their poses, and what the cup holds.

    Attributes:
        cell: The cell.
        T_world_pod: (4, 4) pose of the pod now.
        items: Items in their places.
        noise: Bounds of the error of the item poses in this scene.
        seed: Seed that the scene was made with.
        pod_error: How far the pod may stand from ``T_world_pod``.
        held: What the cup holds, None if nothing.
        cloud: What a sensor saw besides all this, None if nothing.
        carriers: Where those of the cell's own carriers stand, by name, that do not stand where it says.
    """

    cell: Cell
    T_world_pod: Array
    items: tuple[PlacedItem, ...]
    noise: PoseNoise
    seed: int = 0
    pod_error: Displacement = UNMOVED
    held: HeldItem | None = None
    cloud: Cloud | None = None
    carriers: Mapping[str, CarrierPose] = field(default_factory=dict)

    @cached_property
    def posed_carriers(self) -> tuple[PosedCarrier, ...]:
        """The pod, the tote, the cell's own carriers and the obstacles, as they stand now."""
        found = [
            PosedCarrier(name, at.T_world_carrier, carrier.bodies, at.error)
            for name, carrier in self.cell.carriers.items()
            for at in (self.pose_of(carrier),)
        ]
        return (*found, PosedCarrier(OBSTACLE, np.eye(4), self.cell.obstacles.bodies))

    def pose_of(self, carrier: Carrier) -> CarrierPose:
        """Where a carrier stands.

        Args:
            carrier: One of the cell.

        Returns:
            Its pose, with the bounds of its error.
        """
        if carrier.name == POD:
            return CarrierPose(self.T_world_pod, self.pod_error)
        return self.carriers.get(carrier.name, CarrierPose(carrier.T_world_carrier))

    @property
    def standing(self) -> tuple[tuple[Body, Array], ...]:
        """Everything that stands in the cell, with the pose (4, 4) in the world of what it is part of."""
        return tuple((body, each.T_world_carrier) for each in self.posed_carriers for body in each.bodies)

    @property
    def grown(self) -> tuple[tuple[Body, Array], ...]:
        """Everything that stands, in the order of ``standing``, grown to wherever it may be by its error."""
        return tuple((body, each.T_world_carrier) for each in self.posed_carriers for body in each.grown)

    @property
    def T_nominal_pod(self) -> Array:
        """(4, 4) pose of the pod, seen from its nominal place."""
        return np.asarray(inverse(self.cell.T_world_pod) @ self.T_world_pod)

    @property
    def is_pod_within_bounds(self) -> bool:
        """Whether the pod stands where the cell says that it may: what holds for any such pod holds here."""
        return self.cell.pod.displacement.allows(self.T_nominal_pod)

    def T_world_place(self, place: Place) -> Array:
        """Pose of a place's frame as its carrier stands now.

        Args:
            place: One of the cell.

        Returns:
            (4, 4) in the world.
        """
        T_world_carrier = self.pose_of(self.cell.carriers[place.carrier]).T_world_carrier
        return np.asarray(T_world_carrier @ place.T_carrier_place)

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
        here = [i for i in self.items if location is None or i.location == location]
        for placed in here:
            if placed.id == id_or_name:
                return placed
        for placed in here:
            if placed.item.name == id_or_name:
                return placed
        elsewhere = sorted({i.location for i in self.items if id_or_name in (i.id, i.item.name)})
        if elsewhere:
            told = f"{id_or_name} is not in {location} but in {' and '.join(elsewhere)}"
            raise UnknownNameError("item", id_or_name, [i.id for i in here], told=f"{told}; name that place")
        raise UnknownNameError("item", id_or_name, [i.id for i in here], location or "scene")

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
        """All items of a place.

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


@lru_cache(maxsize=64)
def _swept(bodies: tuple[Body, ...], error: Displacement) -> tuple[Body, ...]:
    """A carrier's bodies, each grown to wherever an error of its pose may put it: the same in every look."""
    return tuple(map(error.swept, bodies)) if error != UNMOVED else bodies
