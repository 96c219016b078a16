"""Reads commissions. See docs/formats/commission.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.checks.references import refer
from pickcli.cell.item import Item
from pickcli.cell.schemas.items_file import HEAVIEST, ItemName
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.commission.commission import Commission, LoadItem
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.driving_area_file import (
    MOST_BOXES,
    MOST_SIDE,
    FloorBoxModel,
    Point,
    StatedPalletModel,
    TruckPoseModel,
    WallsModel,
)
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import entered_pose, straight_length
from pickcli.driving.truck_camera import TruckCamera
from pickcli.files.file_kind import COMMISSION
from pickcli.files.schema import Angle, FileModel, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.geometry import Array

YEAR = 2100  # in the files of items: of no challenge, so that no other item has it
MOST_ITEMS = 40
SENSOR = "carmine"  # the camera of the truck
Side = Annotated[float, Field(ge=0.01, le=0.5)]  # m


class CommissionProductModel(FileModel):
    """What items are: a box or a cylinder, which stands on the load."""

    box: Annotated[tuple[Side, ...], Len(3, 3)] | None = Field(None, description="m, extents")
    cylinder: Annotated[tuple[Side, ...], Len(2, 2)] | None = Field(None, description="m, radius and length")
    mass: Annotated[float, Field(ge=0.01, le=HEAVIEST)] = Field(description="kg")

    @property
    def shape(self) -> Shape:
        """The shape; of a product that states one."""
        if self.cylinder is not None:
            return Shape(ShapeKind.CYLINDER, (self.cylinder[0], self.cylinder[1]))
        assert self.box is not None
        return Shape(ShapeKind.BOX, (self.box[0], self.box[1], self.box[2]))

    def item(self, name: str) -> Item:
        """Return the product as an item, which only fingers hold.

        Args:
            name: Its name.

        Returns:
            The item.
        """
        shape = self.shape
        return Item(
            name=name, year=YEAR, shape=shape, mass=self.mass, bonus=0,
            seals=dict.fromkeys(shape.face_names, 0.0), seal_source="none is stated in a commission",
            why_not="a commission states no seals", seal_inset=0.0, speed_scale=1.0, folded="",
            source="the commission",
        )  # fmt: skip


class LoadItemModel(FileModel):
    """An item on the load."""

    product: ItemName = Field(description="one of products")
    position: Point = Field(description="m, of its middle in the frame of the load")
    yaw: Angle = Field(0.0, description="rad about the vertical")


class DeckModel(FileModel):
    """A part of the deck of the pallet."""

    low: Point = Field(description="m from the middle of the deck, lower corner")
    high: Point = Field(description="m, upper corner")


class FloorPoseModel(FileModel):
    """A pose on the floor."""

    position: Point = Field(description="m")
    yaw: Angle = Field(description="rad")

    @property
    def pose(self) -> Array:
        """(3,) m, m, rad."""
        return np.array([*self.position, self.yaw])


class CommissionModel(FileModel):
    """A whole file."""

    format: Literal["apc commission"] = Field(description="'apc commission'")
    version: Literal[1] = Field(description="1, the only version there is")
    walls: WallsModel = Field(description="the rectangle that the truck stays in")
    boxes: Annotated[tuple[FloorBoxModel, ...], Len(0, MOST_BOXES)] = Field(
        (), description="what else stands in it"
    )
    margin: Annotated[float, Field(ge=0, le=0.5)] = Field(
        DrivingArea.margin, description="m that drives keep from walls and boxes"
    )
    start: TruckPoseModel = Field(description="pose of the truck at the start")
    pallet: StatedPalletModel = Field(description="the empty pallet, roughly")
    load: FloorPoseModel = Field(description="where the load stands")
    products: Annotated[dict[ItemName, CommissionProductModel], Field(min_length=1)] = Field(
        description="what items are, by name"
    )
    items: Annotated[tuple[LoadItemModel, ...], Len(1, MOST_ITEMS)] = Field(description="items on the load")
    filled: DeckModel | None = Field(None, description="the part of the deck that is filled; all by default")
    apart: Annotated[float, Field(ge=0, le=0.3)] = Field(
        0.06, description="m between items on the pallet, for the fingers"
    )
    delivery: FloorPoseModel = Field(description="pose of the pallet where it is set down")
    end: TruckPoseModel = Field(description="pose of the truck at the end")


def read_commission(path: Path) -> Commission:
    """Read a commission.

    Args:
        path: The file, JSON or YAML.

    Returns:
        The commission.

    Raises:
        InputError: With every mistake and its position: walls without room, a start or end of the truck that
            is not within them or in a box, products without a shape, items of unknown products or that stand
            in each other, a part of the deck that is not on it, and all that the format forbids.
    """
    source = read_yaml(path, COMMISSION)
    model = validate(source, CommissionModel)
    for key, text in _mistakes(model):
        source.add(key, text)
    for k, each in enumerate(model.items):
        if each.product not in model.products:
            refer(source, ("items", k, "product"), "product", each.product, tuple(model.products))
    source.check()
    commission = _commission(model)
    _refuse_overlaps(source, model, commission)
    _refuse_near(source, commission)
    source.check()
    return commission


def _mistakes(model: CommissionModel) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield mistakes of figures, with their keys."""
    sides = np.array(model.walls.high) - np.array(model.walls.low)
    if sides.min() <= 0:
        yield ("walls",), "low is not below high in x and y; exchange them"
    elif sides.max() > MOST_SIDE:
        yield ("walls",), f"{sides.max():g} m from wall to wall, at most {MOST_SIDE:g} m are planned in"
    for name, product in model.products.items():
        if (product.box is None) == (product.cylinder is None):
            yield ("products", name), "expected exactly one of box and cylinder; state one"
    if model.pallet.load:
        yield ("pallet", "load"), "expected an empty pallet; leave its load out"
    if model.filled is not None:
        low, high = np.array(model.filled.low), np.array(model.filled.high)
        shape = model.pallet.pallet.shape
        half = np.array([shape.length, shape.width]) / 2
        if (low >= high).any():
            yield ("filled",), "low is not below high in x and y; exchange them"
        elif (low < -half).any() or (high > half).any():
            deck = f"{-half[0]:g} to {half[0]:g} and {-half[1]:g} to {half[1]:g} m"
            if model.pallet.kind == "half":
                yield ("pallet", "kind"), f"what is filled is not on a half one, from {deck}; state another"
            else:
                yield ("filled",), f"is not on the deck, which is from {deck}; make it smaller"


def _commission(model: CommissionModel) -> Commission:
    low, high = model.walls.low, model.walls.high
    pallet = model.pallet.pallet
    half = (pallet.shape.length / 2, pallet.shape.width / 2)
    filled = model.filled
    area = DrivingArea(
        (low[0], low[1]), (high[0], high[1]), tuple(each.box for each in model.boxes),
        np.array([*model.start.position, model.start.yaw]), np.zeros(3), margin=model.margin,
        camera=TruckCamera(read_sensor(sensor_file(SENSOR))), pallet=pallet, enters=True,
    )  # fmt: skip
    area = replace(area, goal=entered_pose(area, pallet), straight=-straight_length(area, pallet))
    products = {name: product.item(name) for name, product in model.products.items()}
    return Commission(
        area, model.load.pose, tuple(_load_items(model, products)),
        (-half[0], -half[1]) if filled is None else (filled.low[0], filled.low[1]),
        half if filled is None else (filled.high[0], filled.high[1]),
        model.apart, model.delivery.pose, np.array([*model.end.position, model.end.yaw]),
    )  # fmt: skip


def _load_items(model: CommissionModel, products: dict[str, Item]) -> Iterator[LoadItem]:
    """Yield the items; the second of a product is product#2, as in scenes."""
    n_before = Counter[str]()
    for each in model.items:
        n_before[each.product] += 1
        n = n_before[each.product]
        name = each.product if n == 1 else f"{each.product}#{n}"
        yield LoadItem(name, products[each.product], np.array([*each.position, each.yaw]))


def _refuse_overlaps(source: Source, model: CommissionModel, commission: Commission) -> None:
    """Note items that stand in each other, by the circles that are inside of them seen from above."""
    for (j, a), (k, b) in combinations(enumerate(commission.items), 2):
        apart = float(np.hypot(*(a.at - b.at)[:2]))
        inner = sum(float(each.item.shape.extents[:2].min()) / 2 for each in (a, b))
        if apart < inner:
            text = (
                f"{b.id} stands in {a.id} (line {source.place(('items', j))[1]}); put them {inner:g} m apart"
            )
            source.add(("items", k), text)


def _refuse_near(source: Source, commission: Commission) -> None:
    """Note poses of the truck that do not keep the margin from walls, boxes and the pallet."""
    area, pallet = commission.area, commission.pallet
    delivered = replace(pallet, pose=commission.delivery)
    for name, pose, there in (("start", area.start, pallet), ("end", commission.end, delivered)):
        past = replace(area, boxes=(*area.boxes, there.footprint))
        least = float(clearances(past, pose[None])[0].min())
        if least < area.margin:
            text = f"the truck at the {name} is {least:.3f} m from walls, a box or the pallet"
            source.add((name,), f"{text}, {area.margin:g} m are kept; move it")
