"""Items that ride on a conveyor: poses in the frame of the belt with the time at which they hold."""

from __future__ import annotations

from dataclasses import dataclass, replace

from pickcli.cell.cell import Cell
from pickcli.cell.conveyor import Conveyor
from pickcli.cell.item import Item
from pickcli.cell.station import Carrier
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array, pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

ROUNDING = 1e-6  # m


@dataclass(frozen=True, eq=False)
class RidingItem:
    """One item on a conveyor.

    Attributes:
        id: Unique in the stream.
        item: The product.
        stamp: s, time at which the pose holds.
        T_belt_item: (4, 4) pose in the frame of the conveyor, which stands still in the hall.
        noise: Bounds of the error of the pose; None for those of the stream.
    """

    id: str
    item: Item
    stamp: float
    T_belt_item: Array
    noise: PoseNoise | None = None


@dataclass(frozen=True, eq=False)
class ItemStream:
    """Items that come along a conveyor at one speed, the first one first.

    Attributes:
        cell: The cell with the conveyor.
        conveyor: Name of the conveyor.
        speed: m/s of the belt along its +x, 0 if it stands.
        speed_error: m/s, bound of the error of the speed.
        noise: Bounds of the error of the poses at their stamps.
        items: The items.
        seed: Seed that the stream was made with.
        one_by_one: Whether each item is set on the belt, which stands, when the one before it is gone.
    """

    cell: Cell
    conveyor: str
    speed: float
    speed_error: float
    noise: PoseNoise
    items: tuple[RidingItem, ...]
    seed: int = 0
    one_by_one: bool = False

    @property
    def carrier(self) -> Carrier:
        """The conveyor as a carrier of the cell."""
        return self.cell.carriers[self.conveyor]

    @property
    def belt(self) -> Conveyor:
        """The figures of the conveyor."""
        belt = self.carrier.conveyor
        assert belt is not None
        return belt

    def find(self, item_id: str) -> RidingItem:
        """Find an item by its id.

        Args:
            item_id: The id.

        Returns:
            The item.

        Raises:
            UnknownNameError: There is no such item.
        """
        for riding in self.items:
            if riding.id == item_id:
                return riding
        raise UnknownNameError("item", item_id, [riding.id for riding in self.items], "the stream")

    def presenting(self, item_id: str) -> ItemStream:
        """Return the stream as it is when an item is picked: of one by one, that item alone is on the belt.

        Args:
            item_id: Id of the item.

        Returns:
            The stream.

        Raises:
            UnknownNameError: There is no such item.
        """
        riding = self.find(item_id)
        return replace(self, items=(riding,)) if self.one_by_one else self

    def travel_at(self, riding: RidingItem, t: float) -> float:
        """Compute how far from the infeed the middle of an item is.

        Args:
            riding: An item of the stream.
            t: s.

        Returns:
            m; negative before it is on the belt.
        """
        return float(riding.T_belt_item[0, 3]) + self.speed * (t - riding.stamp)

    def is_on_belt(self, riding: RidingItem, t: float) -> bool:
        """Tell whether an item is on the belt: wholly past the infeed, its middle not past the outfeed.

        Args:
            riding: An item of the stream.
            t: s.

        Returns:
            Whether it is.
        """
        behind = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[0])
        return behind - ROUNDING <= self.travel_at(riding, t) <= self.belt.length

    def is_known(self, riding: RidingItem, t: float) -> bool:
        """Tell whether an item belongs to the scene of a time: it is on the belt, or will come onto it.

        Args:
            riding: An item of the stream.
            t: s.

        Returns:
            Whether any part of it is between ``Conveyor.upstream`` before the infeed and the outfeed.
        """
        reach = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[0])
        at = self.travel_at(riding, t)
        return -self.belt.upstream <= at + reach and at - reach <= self.belt.length

    def scene_at(self, t: float) -> Scene:
        """Return the cell with the items on the belt at a time, and those that come onto it next.

        Args:
            t: s.

        Returns:
            The scene; the bounds of the errors of poses grow with the time since their stamps. Of items that
            are set down one by one, the first is there.
        """
        place = next(iter(self.carrier.places))
        placed = []
        for riding in self.items[: 1 if self.one_by_one else None]:
            if self.is_known(riding, t):
                ahead = pose((self.speed * (t - riding.stamp), 0.0, 0.0))
                T_world_item = self.carrier.T_world_carrier @ ahead @ riding.T_belt_item
                noise = grown(riding.noise or self.noise, self.speed_error * abs(t - riding.stamp))
                placed.append(PlacedItem(riding.id, riding.item, place, T_world_item, noise))
        return Scene(self.cell, self.cell.T_world_pod, tuple(placed), self.noise, self.seed)


def after_travel(scene: Scene, conveyor: str, travel: float, error: float = 0.0) -> Scene:
    """Return a scene in which a belt has carried its items on.

    Args:
        scene: The scene.
        conveyor: Name of the conveyor.
        travel: m along its +x; negative for a time before.
        error: m, bound of the error of the travel, added to that of the items' poses.

    Returns:
        The scene with every item of the conveyor displaced, also where that is beyond its ends.
    """
    carrier = scene.cell.carriers[conveyor]
    ahead = travel * scene.pose_of(carrier).T_world_carrier[:3, 0]
    return replace(
        scene,
        items=tuple(
            _displaced(scene, placed, ahead, error) if placed.location in carrier.places else placed
            for placed in scene.items
        ),
    )


def _displaced(scene: Scene, placed: PlacedItem, by: Array, error: float) -> PlacedItem:
    """Return an item displaced by a vector (3,) in the world."""
    T = placed.T_world_item.copy()
    T[:3, 3] += by
    noise = scene.noise_of(placed)
    return replace(placed, T_world_item=T, noise=grown(noise, error) if error > 0.0 else placed.noise)


def grown(noise: PoseNoise, error: float) -> PoseNoise:
    """Add an error of the position to the bounds of a pose's error.

    Args:
        noise: The bounds.
        error: m.

    Returns:
        The bounds of both errors together.
    """
    off = None if noise.displacement is None else noise.displacement + error
    return PoseNoise(noise.position + error, noise.angle, off)
