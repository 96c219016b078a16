"""Reads and writes orders of pallets. See docs/formats/pallet.md."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

from annotated_types import Len
from pydantic import Field

from pickcli.cell.schemas.pose_schema import Name
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import PALLET
from pickcli.files.schema import FileModel, Size, validate
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.palletizing.pallet_order import CLEARANCE, ROUNDED, Carton, Pallet, PalletOrder

MOST_CARTONS = 200
Mass = Annotated[float, Field(ge=0.01, le=1000)]
Side = Annotated[float, Field(ge=0.01, le=10)]  # m: the engine takes a millimetre off


class PalletModel(FileModel):
    """What cartons are stacked on."""

    size: Annotated[tuple[Size, ...], Len(2, 2)] = Field(description="m, length and width of the deck")
    deck: Annotated[float, Field(ge=0, le=2)] = Field(Pallet.deck, description="m, height of the deck")
    height: Size = Field(Pallet.height, description="m over the floor that nothing exceeds")
    bears: Annotated[float, Field(gt=0, le=1e5)] = Field(Pallet.bears, description="kg of all cartons")


class CartonModel(FileModel):
    """Cartons that are alike."""

    id: Name = Field(description="name; several of a count are name_1, name_2, ...")
    size: Annotated[tuple[Side, ...], Len(3, 3)] = Field(description="m, length, width and height")
    mass: Mass = Field(description="kg")
    bears: Annotated[float, Field(ge=0, le=1e5)] | None = Field(
        None, description="kg that may stand on it; any if it is left out"
    )
    count: Annotated[int, Field(ge=1, le=MOST_CARTONS)] = Field(1, description="how many there are")

    @property
    def cartons(self) -> tuple[Carton, ...]:
        """Each of them."""
        names = [self.id] if self.count == 1 else [f"{self.id}_{k + 1}" for k in range(self.count)]
        length, width, height = self.size
        bears = float("inf") if self.bears is None else self.bears
        return tuple(Carton(name, (length, width, height), self.mass, bears) for name in names)


class PalletOrderModel(FileModel):
    """A whole file."""

    format: Literal["apc pallet"] = Field(description="'apc pallet'")
    version: Literal[1] = Field(description="1, the only version there is")
    pallet: PalletModel = Field(description="the pallet")
    clearance: Annotated[float, Field(ge=0, le=0.1)] = Field(
        CLEARANCE, description="m between cartons beside each other"
    )
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
        InputError: With every mistake and its position: a carton that fits on the pallet in no orientation or
            weighs more than it bears, two of the same name, and all that the format forbids.
    """
    source = read_yaml(path, PALLET)
    model = validate(source, PalletOrderModel)
    length, width = model.pallet.size
    pallet = Pallet((length, width), model.pallet.deck, model.pallet.height, model.pallet.bears)
    n_cartons = sum(each.count for each in model.cartons)
    if n_cartons > MOST_CARTONS:
        source.add(
            ("cartons",), f"{n_cartons} cartons, at most {MOST_CARTONS} are stacked; make several orders"
        )
        source.check()
    cartons = tuple(carton for each in model.cartons for carton in each.cartons)
    for k, each in enumerate(model.cartons):
        _note(source, ("cartons", k), each, pallet)
    for name, n in Counter(carton.id for carton in cartons).items():
        if n > 1:
            source.add(("cartons",), f"{n} cartons are called {name}; give each a name of its own")
    source.check()
    return PalletOrder(pallet, cartons, model.clearance)


def write_pallet_order(path: Path, order: PalletOrder, replace: bool = True) -> None:
    """Write the order of a pallet as JSON.

    Args:
        path: The file.
        order: The order.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    pallet = order.pallet
    cartons = [
        {"id": c.id, "size": list(c.size), "mass": c.mass}
        | ({} if c.bears == float("inf") else {"bears": c.bears})
        for c in order.cartons
    ]
    told = {
        "format": "apc pallet",
        "version": 1,
        "pallet": {
            "size": list(pallet.size), "deck": pallet.deck, "height": pallet.height, "bears": pallet.bears,
        },
        "clearance": order.clearance,
        "cartons": cartons,
    }  # fmt: skip
    write_text(path, json.dumps(told, indent=1) + "\n", replace)


def _note(source: Source, at: Key, carton: CartonModel, pallet: Pallet) -> None:
    long, short = max(carton.size[:2]), min(carton.size[:2])
    if long > max(pallet.size) or short > min(pallet.size):
        deck = " x ".join(f"{side:g}" for side in pallet.size)
        source.add((*at, "size"), f"{carton.id} is {long:g} x {short:g} m, larger than the pallet, {deck} m")
    if carton.size[2] + pallet.deck > pallet.height + ROUNDED:
        room = pallet.height - pallet.deck
        source.add((*at, "size"), f"{carton.id} is {carton.size[2]:g} m high, {room:g} m are over the deck")
    if carton.mass > pallet.bears:
        source.add((*at, "mass"), f"{carton.id} weighs {carton.mass:g} kg, the pallet bears {pallet.bears:g}")
