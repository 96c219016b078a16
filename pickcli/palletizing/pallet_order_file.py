"""Reads and writes orders of pallets. See docs/formats/pallet.md."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.schemas.pose_schema import Name
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import PALLET
from pickcli.files.schema import FileModel, Size, Text, validate
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import suggestion
from pickcli.palletizing.pallet_order import CLEARANCE, CONTAINERS, ROUNDED, Carton, Pallet, PalletOrder

MOST_CARTONS = 200
MOST_BORNE = 1e5  # kg
Mass = Annotated[float, Field(ge=0.01, le=1000)]
Bears = Annotated[float, Field(gt=0, le=MOST_BORNE)]
Side = Annotated[float, Field(ge=0.01, le=10)]  # m: the engine takes a millimetre off
Edge = Annotated[float, Field(ge=0, le=0.1)]  # m
Fall = Annotated[float, Field(ge=0, le=0.02)]  # m


class PalletModel(FileModel):
    """What cartons are stacked on. What is not stated is as of the container, or of a EUR pallet."""

    container: Text | None = Field(None, description="eur_pallet, half_pallet or roll_container")
    size: Annotated[tuple[Size, ...], Len(2, 2)] | None = Field(
        None, description="m, length and width of the deck; needed without a container"
    )
    deck: Annotated[float, Field(ge=0, le=2)] | None = Field(None, description="m, height of the deck")
    height: Size | None = Field(None, description="m over the floor that nothing exceeds")
    bears: Bears | None = Field(None, description="kg of all cartons")
    walls: Annotated[tuple[Literal["-x", "+x", "-y", "+y"], ...], Len(0, 4)] | None = Field(
        None, description="sides with a wall, up to the height"
    )
    edge: Edge | None = Field(None, description="m to edges without a wall")

    def pallet(self, source: Source) -> Pallet:
        """Return the pallet.

        Args:
            source: The file, for messages.

        Returns:
            The pallet.

        Raises:
            InputError: The container is unknown, or neither it nor a size is stated.
        """
        name = self.container or "eur_pallet"
        if name not in CONTAINERS:
            source.add(
                ("pallet", "container"), f"unknown container {name!r}; {suggestion(name, tuple(CONTAINERS))}"
            )
        elif self.container is None and self.size is None:
            source.add(("pallet",), f"size is missing; state it, or a container: {', '.join(CONTAINERS)}")
        source.check()
        stated = {key: value for key, value in self if key != "container" and value is not None}
        return replace(CONTAINERS[name], **stated)


class CartonModel(FileModel):
    """Cartons that are alike."""

    id: Name = Field(description="name; several of a count are name_1, name_2, ...")
    size: Annotated[tuple[Side, ...], Len(3, 3)] = Field(description="m, length, width and height")
    mass: Mass = Field(description="kg")
    bears: Annotated[float, Field(ge=0, le=MOST_BORNE)] | None = Field(
        None, description="kg that may stand on it; by default as many of its kind as have room over it"
    )
    count: Annotated[int, Field(ge=1, le=MOST_CARTONS)] = Field(1, description="how many there are")

    def cartons(self, pallet: Pallet) -> tuple[Carton, ...]:
        """Return each of them.

        Args:
            pallet: What they are stacked on. Cartons are made to bear what is like them: if nothing is
                stated, each bears a column of its own kind up to the height of the pallet.

        Returns:
            The cartons.
        """
        names = [self.id] if self.count == 1 else [f"{self.id}_{k + 1}" for k in range(self.count)]
        length, width, height = self.size
        column = self.mass * max((pallet.height - pallet.deck) / height - 1.0, 0.0)
        bears = column if self.bears is None else self.bears
        return tuple(Carton(name, (length, width, height), self.mass, bears) for name in names)


class PalletOrderModel(FileModel):
    """A whole file."""

    format: Literal["apc pallet"] = Field(description="'apc pallet'")
    version: Literal[1] = Field(description="1, the only version there is")
    pallet: PalletModel = Field(description="the pallet")
    clearance: Annotated[float, Field(ge=0, le=0.1)] = Field(
        CLEARANCE, description="m between cartons beside each other"
    )
    fall: Fall = Field(0.0, description="m that a carton may fall onto others as it is let go")
    cartons: Annotated[list[CartonModel], Field(min_length=1, max_length=MOST_CARTONS)] = Field(
        description="what is to be stacked, in the sequence in which it comes"
    )


def read_pallet_order(path: Path) -> PalletOrder:
    """Read the order of a pallet.

    Args:
        path: The file.

    Returns:
        The order.

    Raises:
        InputError: With every mistake and its position: an unknown container, a carton that fits on the
            pallet in no orientation or weighs more than it bears, two of the same name, and all that the
            format forbids.
    """
    source = read_yaml(path, PALLET)
    model = validate(source, PalletOrderModel)
    pallet = model.pallet.pallet(source)
    n_cartons = sum(each.count for each in model.cartons)
    if n_cartons > MOST_CARTONS:
        source.add(
            ("cartons",), f"{n_cartons} cartons, at most {MOST_CARTONS} are stacked; make several orders"
        )
        source.check()
    cartons = tuple(carton for each in model.cartons for carton in each.cartons(pallet))
    for k, each in enumerate(model.cartons):
        _note(source, ("cartons", k), each, pallet, model.clearance)
    for name, n in Counter(carton.id for carton in cartons).items():
        if n > 1:
            source.add(("cartons",), f"{n} cartons are called {name}; give each a name of its own")
    source.check()
    return PalletOrder(pallet, cartons, model.clearance, model.fall)


def write_pallet_order(path: Path, order: PalletOrder, replace: bool = True) -> None:
    """Write the order of a pallet as JSON.

    Args:
        path: The file.
        order: The order.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    cartons = [
        {"id": c.id, "size": list(c.size), "mass": c.mass, "bears": min(c.bears, MOST_BORNE)}
        for c in order.cartons
    ]
    told = {
        "format": "apc pallet",
        "version": 1,
        "pallet": asdict(order.pallet),
        "clearance": order.clearance,
        "fall": order.fall,
        "cartons": cartons,
    }
    write_text(path, json.dumps(told, indent=1) + "\n", replace)


def _note(source: Source, at: Key, carton: CartonModel, pallet: Pallet, clearance: float) -> None:
    low, high = pallet.room(clearance)
    room = np.sort(high - low) + ROUNDED
    short, long = sorted(carton.size[:2])
    if short > room[0] or long > room[1]:
        deck = " x ".join(f"{side:g}" for side in pallet.size)
        walled = f" with {clearance:g} m to its walls" if pallet.walls else ""
        walled += f" with {pallet.edge:g} m to its edges" if pallet.edge else ""
        source.add(
            (*at, "size"), f"{carton.id} is {long:g} x {short:g} m, larger than the pallet, {deck} m{walled}"
        )
    if carton.size[2] + pallet.deck > pallet.height + ROUNDED:
        over = pallet.height - pallet.deck
        source.add((*at, "size"), f"{carton.id} is {carton.size[2]:g} m high, {over:g} m are over the deck")
    if carton.mass > pallet.bears:
        source.add((*at, "mass"), f"{carton.id} weighs {carton.mass:g} kg, the pallet bears {pallet.bears:g}")
