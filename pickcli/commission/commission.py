"""A commission: a truck takes an empty pallet, fills it with items of a load by its arm, and delivers it.

That is the chain of APPLE (Krug et al., "The Next Step in Robot Commissioning", RA-L 2016, Fig. 7).
"""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.item import Item
from pickcli.driving.driving_area import DrivingArea, FloorBox, StatedPallet
from pickcli.geometry import Array

LOAD, PALLET = "load", "pallet"  # places of a cell that commissions, and names in messages


@dataclass(frozen=True, eq=False)
class LoadItem:
    """An item on the load.

    Attributes:
        id: Its name, unique in the commission.
        item: The product.
        at: (3,) m, m, rad: its middle in the frame of the load, and how it is turned about the vertical.
    """

    id: str
    item: Item
    at: Array


@dataclass(frozen=True, eq=False)
class Commission:
    """What a truck with an arm is to do.

    Attributes:
        area: Where it drives: walls, boxes and start of the truck, its camera, and the pallet that is
            expected, into which the first drive leads.
        load: (3,) m, m, rad: where the load stands, in the frame of its place in the cell.
        items: What is on it, and is to be put on the pallet.
        filled_low: (2,) m, lower corner of the part of the pallet's deck that is filled, from its middle.
        filled_high: (2,) m, upper corner.
        apart: m that items are put up beside each other.
        delivery: (3,) m, m, rad: where the pallet is to be set down, as its pose is stated in areas.
        end: (3,) m, m, rad: where the truck is to stand at the end.
    """

    area: DrivingArea
    load: Array
    items: tuple[LoadItem, ...]
    filled_low: tuple[float, float]
    filled_high: tuple[float, float]
    apart: float
    delivery: Array
    end: Array

    @property
    def pallet(self) -> StatedPallet:
        """The pallet that is expected."""
        assert self.area.pallet is not None
        return self.area.pallet

    def load_box(self, size: Array) -> FloorBox:
        """Return what the load covers of the floor.

        Args:
            size: (3,) m, of its top and its height.

        Returns:
            The box.
        """
        x, y, yaw = (float(each) for each in self.load)
        return FloorBox(f"the {LOAD}", (x, y), (float(size[0]), float(size[1])), yaw, float(size[2]))
