"""Where a truck drives: walls around, boxes inside, a start and a goal, all seen from above."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.cell.shapes import Body, box
from pickcli.driving.forks import Forks
from pickcli.driving.steering_path import posed
from pickcli.driving.tricycle import Tricycle
from pickcli.driving.truck_camera import TruckCamera
from pickcli.geometry import Array
from pickcli.perception.pallets.pallet_shape import PalletShape

WALLS = "the walls"


@dataclass(frozen=True)
class FloorBox:
    """A box that stands on the floor.

    Attributes:
        name: Name in messages.
        centre: (2,) m.
        size: (2,) m along its own x and y.
        yaw: rad.
        height: m, as cameras see it.
    """

    name: str
    centre: tuple[float, float]
    size: tuple[float, float]
    yaw: float = 0.0
    height: float = 1.0

    @property
    def corners(self) -> Array:
        """(4, 2) m: corners, counterclockwise."""
        half = np.array(self.size) / 2
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        corners: Array = (signs * half) @ np.array([[c, s], [-s, c]]) + self.centre
        return corners

    def distance(self, points: Array) -> Array:
        """Return the distance of points from the box.

        Args:
            points: (..., 2) m.

        Returns:
            (...) m, 0 inside.
        """
        c, s = np.cos(self.yaw), np.sin(self.yaw)
        off = points - self.centre
        x = np.abs(c * off[..., 0] + s * off[..., 1]) - self.size[0] / 2
        y = np.abs(c * off[..., 1] - s * off[..., 0]) - self.size[1] / 2
        distance: Array = np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0))
        return distance


@dataclass(frozen=True, eq=False)
class StatedPallet:
    """A pallet on the floor.

    Attributes:
        shape: Its shape.
        pose: (3,) m, m, rad: of its middle, x out of the side into which the forks go.
        load: m, height of its load, which covers all of the deck; 0 for none.
        tolerance: (3,) m, m, rad that the real one may be off, either way along its own axes.
        off: (3,) m, m, rad that the real one is off, in simulated pictures.
        is_there: Whether there is a real one.
    """

    shape: PalletShape
    pose: Array
    load: float
    tolerance: Array
    off: Array = field(default_factory=lambda: np.zeros(3))
    is_there: bool = True

    @property
    def real(self) -> tuple[StatedPallet, ...]:
        """The pallet where it really is in simulation, or none."""
        real = replace(self, pose=posed(self.pose, self.off), off=np.zeros(3))
        return (real,) if self.is_there else ()

    @property
    def bodies(self) -> tuple[Body, ...]:
        """Boards, blocks and load in its frame."""
        if not self.load:
            return self.shape.bodies
        half, side, deck = self.shape.length / 2, self.shape.width / 2, self.shape.height
        return (*self.shape.bodies, box("load", (-half, -side, deck), (half, side, deck + self.load)))

    @property
    def footprint(self) -> FloorBox:
        """What it covers of the floor."""
        (x, y, yaw), size = self.pose, (self.shape.length, self.shape.width)
        return FloorBox("the pallet", (float(x), float(y)), size, float(yaw), self.shape.height + self.load)


@dataclass(frozen=True, eq=False)
class DrivingArea:
    """What a drive is planned for.

    Attributes:
        low: (2,) m: lower corner of the rectangle that the truck stays in.
        high: (2,) m: upper corner.
        boxes: What stands in it.
        start: (3,) m, m, rad: pose of the truck.
        goal: (3,) m, m, rad.
        straight: m of the last part of the drive, straight into the goal; negative: backwards, 0: any end.
        margin: m that a plan keeps from walls and boxes, for errors of the controller.
        truck: The truck.
        forks: Its forks.
        camera: Its camera, None for none.
        pallet: A pallet that is expected in it, None for none.
        enters: Whether the drive ends in that pallet, where the goal is.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    boxes: tuple[FloorBox, ...]
    start: Array
    goal: Array
    straight: float = 0.0
    margin: float = 0.05
    truck: Tricycle = field(default_factory=Tricycle)
    forks: Forks = field(default_factory=Forks)
    camera: TruckCamera | None = None
    pallet: StatedPallet | None = None
    enters: bool = False

    def wall_distance(self, points: Array) -> Array:
        """Return the distance of points from the walls around.

        Args:
            points: (..., 2) m.

        Returns:
            (...) m, negative outside.
        """
        inside = np.minimum(points - np.array(self.low), np.array(self.high) - points)
        distance: Array = inside.min(axis=-1)
        return distance
