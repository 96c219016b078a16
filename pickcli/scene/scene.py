"""Planning scenes: the cell with the current poses of carriers and items."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.pod_tolerance import UNMOVED, Displacement, PodPoses
from pickcli.cell.shapes import Body
from pickcli.cell.station import OBSTACLE, POD, UNKNOWN, Carrier
from pickcli.cell.station import TOTE as TOTE
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array, inverse
from pickcli.scene.cloud import Cloud
from pickcli.scene.unknown_space import UnknownSpace


@dataclass(frozen=True)
class PoseNoise:
    """Bounds of the error of an item's pose: the true pose lies within them.

    Attributes:
        position: m, norm of the translation error.
        angle: rad, rotation error.
        displacement: m, by which any point of the surface is off; None where nothing but the other bounds is
            known of it. Errors of position and angle that come together off at different points, so it may
            be far less than both of them make possible.
    """

    position: float = 0.0
    angle: float = 0.0
    displacement: float | None = None

    def at(self, distance: Array) -> Array:
        """Bound the position error of points of the item.

        Args:
            distance: m, (N,) distances from the middle.

        Returns:
            (N,) m.
        """
        off = self.position + self.angle * distance
        return off if self.displacement is None else np.minimum(off, self.displacement)

    def bound(self, item: Item) -> float:
        """Bound the position error of any point of an item.

        Args:
            item: The item.

        Returns:
            m.
        """
        return float(self.at(np.array(item.shape.bounding_radius)))

    def holds(self, error: PoseNoise) -> bool:
        """Tell whether an error is within the bounds.

        Args:
            error: The error of a pose, with its displacement if the bounds have one.

        Returns:
            Whether it is.
        """
        is_held = error.position <= self.position and error.angle <= self.angle
        if self.displacement is None or error.displacement is None:
            return is_held
        return is_held and error.displacement <= self.displacement

    @property
    def figures(self) -> dict[str, float]:
        """All that is stated, by name."""
        return {name: value for name, value in asdict(self).items() if value is not None}


@dataclass(frozen=True, eq=False)
class PlacedItem:
    """One instance of an item.

    Attributes:
        id: Unique in the scene: the item's name, or name#2 for a second copy.
        item: The product.
        location: Name of the place that it is in.
        T_world_item: (4, 4) pose.
        noise: Bounds of the error of this pose; None for those of the scene (``Scene.noise_of``).
    """

    id: str
    item: Item
    location: str
    T_world_item: Array
    noise: PoseNoise | None = None

    @property
    def can_roll(self) -> bool:
        """Whether the item rolls when pushed, in its current orientation."""
        return self.item.can_roll(self.T_world_item[:3, :3])


@dataclass(frozen=True, eq=False)
class HeldItem:
    """An attached item, held by the tool.

    Attributes:
        id: Unique, or the id of one of the scene's items, which then states where it was seen.
        item: The product.
        T_tip_item: (4, 4) pose in the tool frame.
        noise: Bounds of the error of this pose; None for those of the scene.
    """

    id: str
    item: Item
    T_tip_item: Array
    noise: PoseNoise | None = None


@dataclass(frozen=True, eq=False)
class CarrierPose:
    """Current pose of a carrier.

    Attributes:
        T_world_carrier: (4, 4) pose.
        error: Bounds of the error of the pose, in the carrier's frame; of the tote in that of its place.
    """

    T_world_carrier: Array
    error: Displacement = UNMOVED


def tote_pose(cell: Cell, T_world_tote: Array, error: Displacement = UNMOVED) -> CarrierPose:
    """Return the pose of the tote as a carrier, whose nominal frame is the world's.

    Args:
        cell: A cell with a tote.
        T_world_tote: (4, 4) pose of the middle of its inner floor.
        error: Bounds of the error of that pose, in its own frame.

    Returns:
        The pose for ``Scene.carriers``.
    """
    place = cell.places[TOTE]
    return CarrierPose(np.asarray(T_world_tote @ inverse(place.T_carrier_place)), error)


@dataclass(frozen=True, eq=False)
class PosedCarrier:
    """A carrier at its pose in a scene, or the obstacles.

    Attributes:
        name: Name of the carrier; OBSTACLE for bodies of no carrier, UNKNOWN for unknown space.
        T_world_carrier: (4, 4) pose.
        bodies: Its bodies, in its frame.
        error: Bounds of the error of the pose.
    """

    name: str
    T_world_carrier: Array
    bodies: tuple[Body, ...]
    error: Displacement = UNMOVED

    @cached_property
    def grown(self) -> tuple[Body, ...]:
        """The bodies, each replaced by its swept volume within the error of the carrier's pose."""
        return _swept(self.bodies, self.error)

    def uncertainty(self, body: Body) -> float:
        """Bound the position error of any point of a body.

        Args:
            body: One of the bodies.

        Returns:
            m.
        """
        reach = np.linalg.norm(body.T_parent_shape[:2, 3]) + body.shape.bounding_radius
        return self.error.bound(float(reach))


@dataclass(frozen=True, eq=False)
class Scene:
    """The cell with the current poses of its carriers, the items with their poses, and the held item.

    Attributes:
        cell: The cell.
        T_world_pod: (4, 4) current pose of the pod.
        items: Items in their places.
        noise: Bounds of the error of the poses of items that state none of their own.
        seed: Seed that the scene was made with.
        pod_error: Bounds of the error of ``T_world_pod``.
        held: The attached item, or None.
        cloud: Further obstacles seen by a sensor, or None.
        carriers: Poses of tote and user-defined carriers that differ from their nominal poses, by name.
        unknown: Space of places of which nothing is known, which is an obstacle.
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
    unknown: tuple[UnknownSpace, ...] = ()

    @cached_property
    def posed_carriers(self) -> tuple[PosedCarrier, ...]:
        """Pod, tote, user-defined carriers, obstacles and unknown space, at their current poses."""
        found = [_posed(carrier, self.pose_of(carrier)) for carrier in self.cell.carriers.values()]
        found.append(PosedCarrier(OBSTACLE, np.eye(4), self.cell.obstacles.bodies))
        boxes = tuple(body for space in self.unknown for body in space.bodies)
        return (*found, PosedCarrier(UNKNOWN, np.eye(4), boxes)) if boxes else tuple(found)

    def pose_of(self, carrier: Carrier) -> CarrierPose:
        """Return the current pose of a carrier.

        Args:
            carrier: A carrier of the cell.

        Returns:
            Its pose, with the bounds of its error.
        """
        if carrier.name == POD:
            return CarrierPose(self.T_world_pod, self.pod_error)
        return self.carriers.get(carrier.name, CarrierPose(carrier.T_world_carrier))

    @property
    def standing(self) -> tuple[tuple[Body, Array], ...]:
        """All stationary bodies, each with the pose (4, 4) of its carrier in the world."""
        return tuple((body, each.T_world_carrier) for each in self.posed_carriers for body in each.bodies)

    @property
    def grown(self) -> tuple[tuple[Body, Array], ...]:
        """All stationary bodies in the order of ``standing``, as swept volumes within their pose errors."""
        return tuple((body, each.T_world_carrier) for each in self.posed_carriers for body in each.grown)

    @property
    def T_nominal_pod(self) -> Array:
        """(4, 4) pose of the pod in the frame of the nominal pod."""
        return np.asarray(inverse(self.cell.T_world_pod) @ self.T_world_pod)

    @property
    def is_pod_within_bounds(self) -> bool:
        """Whether the pod is within its displacement bounds, so that motions proven for all poses hold."""
        return self.cell.pod.displacement.allows(self.T_nominal_pod)

    def T_world_place(self, place: Place) -> Array:
        """Return the pose of a place's frame for the current pose of its carrier.

        Args:
            place: A place of the cell.

        Returns:
            (4, 4) in the world.
        """
        T_world_carrier = self.pose_of(self.cell.carriers[place.carrier]).T_world_carrier
        return np.asarray(T_world_carrier @ place.T_carrier_place)

    def find(self, id_or_name: str, location: str | None = None) -> PlacedItem:
        """Find an item by its id, else by its name.

        Args:
            id_or_name: Id of an instance, or name of an item: the first with that name.
            location: Name of the place that it must be in; None for any.

        Returns:
            The instance.

        Raises:
            UnknownNameError: No such item is there.
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
            text = f"{id_or_name} is not in {location} but in {' and '.join(elsewhere)}"
            raise UnknownNameError("item", id_or_name, [i.id for i in here], text=f"{text}; name that place")
        raise UnknownNameError("item", id_or_name, [i.id for i in here], location or "scene")

    def instance(self, item_id: str) -> PlacedItem | HeldItem:
        """Return an instance, in its place or attached.

        Args:
            item_id: Id of the instance.

        Returns:
            The instance; the attached one, if it is also stated where it was seen.

        Raises:
            UnknownNameError: No instance has that id.
        """
        return self.held if self.held is not None and self.held.id == item_id else self.find(item_id)

    def item(self, item_id: str) -> Item:
        """Return the product of an instance, in its place or attached.

        Args:
            item_id: Id of the instance.

        Returns:
            The item.

        Raises:
            UnknownNameError: No instance has that id.
        """
        return self.instance(item_id).item

    def noise_of(self, instance: PlacedItem | HeldItem) -> PoseNoise:
        """Return the bounds of the error of an item's pose.

        Args:
            instance: The item in its place or attached.

        Returns:
            Its own bounds, else those of the scene.
        """
        return self.noise if instance.noise is None else instance.noise

    def bound(self, instance: PlacedItem | HeldItem) -> float:
        """Bound the error of the position of any point of an item.

        Args:
            instance: The item in its place or attached.

        Returns:
            m.
        """
        return self.noise_of(instance).bound(instance.item)

    def unrecognised_in(self, place: str) -> tuple[Body, ...]:
        """Return where something is in a place, or may be, that nobody recognised.

        Args:
            place: Name of the place.

        Returns:
            Boxes in the world.
        """
        return tuple(
            body for space in self.unknown if space.place == place for body in space.unrecognised_bodies
        )

    def in_location(self, location: str) -> tuple[PlacedItem, ...]:
        """Return all items in a place.

        Args:
            location: Name of a place.

        Returns:
            The instances.
        """
        return tuple(i for i in self.items if i.location == location)

    def moved(self, placed: PlacedItem) -> Scene:
        """Return the scene with one instance replaced.

        Args:
            placed: The instance that replaces the one with the same id.

        Returns:
            The changed scene.
        """
        return replace(self, items=tuple(placed if i.id == placed.id else i for i in self.items))

    def without(self, item_id: str) -> Scene:
        """Return the scene without one instance.

        Args:
            item_id: Id of the instance.

        Returns:
            The changed scene.
        """
        return replace(self, items=tuple(i for i in self.items if i.id != item_id))


def empty_scene(cell: Cell, pod_poses: PodPoses = PodPoses.NOMINAL) -> Scene:
    """Make a scene of a cell with nothing in its places.

    Args:
        cell: The cell.
        pod_poses: Whether the carriers stand at their nominal poses or, for a proof, at all poses of the
            tolerance.

    Returns:
        The scene.
    """
    if pod_poses is PodPoses.DISPLACED:
        cell = cell.swept()
    return Scene(cell, cell.T_world_pod, (), PoseNoise())


def _posed(carrier: Carrier, at: CarrierPose) -> PosedCarrier:
    """Return a carrier at its pose. If the tote's is uncertain, it turns about the middle of its floor."""
    if carrier.name != TOTE or at.error == UNMOVED:
        return PosedCarrier(carrier.name, at.T_world_carrier, carrier.bodies, at.error)
    T_carrier_tote = carrier.places[TOTE].T_carrier_place
    T_tote_carrier = inverse(T_carrier_tote)
    bodies = tuple(
        replace(body, T_parent_shape=np.asarray(T_tote_carrier @ body.T_parent_shape))
        for body in carrier.bodies
    )
    return PosedCarrier(TOTE, np.asarray(at.T_world_carrier @ T_carrier_tote), bodies, at.error)


@lru_cache(maxsize=64)
def _swept(bodies: tuple[Body, ...], error: Displacement) -> tuple[Body, ...]:
    """Swept volumes of a carrier's bodies within the error of its pose; cached."""
    return tuple(map(error.swept, bodies)) if error != UNMOVED else bodies
