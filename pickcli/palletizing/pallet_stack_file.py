"""Reads and writes stacks on pallets as JSON. See docs/formats/pallet.md."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Len
from pydantic import Field

from pickcli.cell.schemas.pose_schema import Name
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import STACKED
from pickcli.files.schema import FileModel, validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.palletizing.drop_test import DropTest
from pickcli.palletizing.pallet_order import Carton, Pallet
from pickcli.palletizing.pallet_order_file import MOST_BORNE, MOST_CARTONS, Bears, Edge, Fall, Mass, Side
from pickcli.palletizing.pallet_stack import PalletStack, Placement, loads_on

DECIMALS = 6  # of lengths, in m
MOST_CORNERS = 500  # of a polygon
Length = Annotated[float, Field(ge=-100.0, le=100.0)]


@dataclass(frozen=True, eq=False)
class StackedPallet:
    """What a file says of a stack.

    Attributes:
        pallet: The pallet.
        clearance: m that a carton keeps from others beside it as it comes down.
        placements: The cartons in the sequence in which they are put up.
        loads: kg that stand on each, by id.
        left: Reasons against the cartons that have no place, by id.
        sinking: m, most that a carton moved in height in the engine.
        shift: m, most sideways.
        fall: m that a carton may fall onto others as it is let go.
    """

    pallet: Pallet
    clearance: float
    placements: tuple[Placement, ...]
    loads: Mapping[str, float]
    left: Mapping[str, tuple[str, ...]]
    sinking: float
    shift: float
    fall: float = 0.0

    @classmethod
    def of(cls, stack: PalletStack, tested: DropTest) -> StackedPallet:
        """Return what the file of a stack would say.

        Args:
            stack: The stack.
            tested: What became of it in the engine.

        Returns:
            The content.
        """
        left = {name: tuple(map(str, reasons.reasons)) for name, reasons in stack.left.items()}
        order = stack.order
        return cls(
            order.pallet,
            order.clearance,
            stack.placements,
            loads_on(stack),
            left,
            tested.sinking,
            tested.shift,
            order.fall,
        )

    @property
    def top(self) -> float:
        """Height (m) over the floor of the highest carton; of the deck if there is none."""
        return self.pallet.deck + max(
            (float(placement.high[2]) for placement in self.placements), default=0.0
        )


class _Pallet(FileModel):
    size: Annotated[tuple[Side, ...], Len(2, 2)]
    deck: Length
    height: Length
    bears: Bears
    walls: tuple[Literal["-x", "+x", "-y", "+y"], ...]
    edge: Edge = 0.0

    @property
    def pallet(self) -> Pallet:
        """The pallet."""
        length, width = self.size
        return Pallet((length, width), self.deck, self.height, self.bears, self.walls, self.edge)


class _Placed(FileModel):
    id: Name
    size: Annotated[tuple[Side, ...], Len(3, 3)]
    mass: Mass
    bears: Annotated[float, Field(ge=0.0, le=MOST_BORNE)]
    position: Annotated[tuple[Length, ...], Len(3, 3)]
    yaw_deg: Literal[0, 90]
    rests_on: tuple[Name, ...]
    borne_within: Annotated[tuple[Annotated[tuple[Length, ...], Len(2, 2)], ...], Len(0, MOST_CORNERS)]
    load: Annotated[float, Field(ge=0.0)]
    comes_down_from: Length

    @property
    def placement(self) -> Placement:
        """The placement."""
        x, y, z = self.size
        is_turned = self.yaw_deg == 90
        half = np.array((y, x, z) if is_turned else (x, y, z)) / 2
        carton = Carton(self.id, (x, y, z), self.mass, self.bears)
        polygon = np.array(self.borne_within).reshape(-1, 2)
        above = self.comes_down_from - float(half[2])
        return Placement(carton, np.array(self.position) - half, is_turned, self.rests_on, polygon, above)


class _Left(FileModel):
    id: Name
    reasons: tuple[str, ...]


class _DropTest(FileModel):
    sinking_m: Annotated[float, Field(ge=0.0)]
    shift_m: Annotated[float, Field(ge=0.0)]


class _Stack(FileModel):
    format: Literal["apc stacked pallet"]
    version: Literal[1]
    pallet: _Pallet
    clearance: Annotated[float, Field(ge=0, le=0.1)]
    fall: Fall = 0.0
    placements: Annotated[tuple[_Placed, ...], Len(0, MOST_CARTONS)]
    left: Annotated[tuple[_Left, ...], Len(0, MOST_CARTONS)]
    drop_test: _DropTest


def read_pallet_stack(path: Path) -> StackedPallet:
    """Read a stack.

    Args:
        path: The file.

    Returns:
        What it says.

    Raises:
        InputError: The file cannot be read, is of another kind or has mistakes.
    """
    source = read_yaml(path, STACKED)
    model = validate(source, _Stack)
    _check_names(source, model)
    placements = tuple(each.placement for each in model.placements)
    loads = {each.id: each.load for each in model.placements}
    left = {each.id: each.reasons for each in model.left}
    tested = model.drop_test
    return StackedPallet(
        model.pallet.pallet, model.clearance, placements, loads, left, tested.sinking_m, tested.shift_m,
        model.fall,
    )  # fmt: skip


def _check_names(source: Source, model: _Stack) -> None:
    """Refuse a carton stated twice, or before what bears it, and a stack of none. Raises InputError."""
    if not model.placements and not model.left:
        source.add(("placements",), "no carton is put up, and none is left; plan a stack of at least one")
    there: set[str] = set()
    for k, each in enumerate(model.placements):
        if each.id in there:
            source.add(("placements", k, "id"), f"{each.id} is put up twice; state each carton once")
        for name in sorted(set(each.rests_on) - there):
            source.add(("placements", k, "rests_on"), f"{each.id} rests on {name}, which is not there yet")
        there.add(each.id)
    for k, left in enumerate(model.left):
        if left.id in there:
            source.add(("left", k, "id"), f"{left.id} is put up, too, or left twice; state each carton once")
        there.add(left.id)
    source.check()


def write_pallet_stack(path: Path, stack: PalletStack, tested: DropTest, replace: bool = True) -> None:
    """Write a stack with the result of its drop test.

    Args:
        path: The file.
        stack: The stack.
        tested: What became of it in the engine.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_stacked_pallet(path, StackedPallet.of(stack, tested), replace)


def write_stacked_pallet(path: Path, stack: StackedPallet, replace: bool = True) -> None:
    """Write what the file of a stack says.

    Args:
        path: The file.
        stack: The stack.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, or exists.
    """
    write_text(path, stack_text(stack), replace)


def stack_text(stack: StackedPallet) -> str:
    """Return the text of a file.

    Args:
        stack: The stack.

    Returns:
        JSON.
    """
    return json.dumps(stack_to_dict(stack), indent=1) + "\n"


def stack_to_dict(stack: StackedPallet) -> dict[str, Any]:
    """Return the content of a file.

    Args:
        stack: The stack.

    Returns:
        Plain values.
    """
    return {
        "format": "apc stacked pallet",
        "version": 1,
        "pallet": asdict(stack.pallet),
        "clearance": stack.clearance,
        "fall": stack.fall,
        "placements": [_placement(p, stack.loads[p.carton.id]) for p in stack.placements],
        "left": [{"id": name, "reasons": list(reasons)} for name, reasons in stack.left.items()],
        "drop_test": {
            "sinking_m": round(stack.sinking, DECIMALS),
            "shift_m": round(stack.shift, DECIMALS),
        },
    }


def _placement(placement: Placement, load: float) -> dict[str, Any]:
    return {
        "id": placement.carton.id,
        "size": list(placement.carton.size),
        "mass": placement.carton.mass,
        "bears": min(placement.carton.bears, MOST_BORNE),
        "position": _rounded(placement.centre),
        "yaw_deg": 90 if placement.is_turned else 0,
        "rests_on": list(placement.rests_on),
        "borne_within": [_rounded(corner) for corner in placement.bears_within],
        "load": round(float(load), 3),
        "comes_down_from": round(placement.from_above + float(placement.size[2]) / 2, DECIMALS),
    }


def _rounded(values: Any) -> list[float]:
    return [round(float(value), DECIMALS) for value in values]
