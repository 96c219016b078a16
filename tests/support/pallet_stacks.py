"""A small stack for the arm of pallet_sia20, and that cell."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.pallet_trials.pallet_station import PalletStation
from pickcli.palletizing.arm_sequence import seen_from
from pickcli.palletizing.drop_test import DropTest
from pickcli.palletizing.pallet_order import CONTAINERS, Carton, PalletOrder
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.palletizing.stacking import stack_all

PALLET = replace(CONTAINERS["half_pallet"], height=0.694, edge=0.01)
CARTONS = (
    Carton("milk_1", (0.3, 0.2, 0.2), 5.0, 30.0),
    Carton("milk_2", (0.3, 0.2, 0.2), 5.0, 30.0),
    Carton("crisps", (0.4, 0.3, 0.2), 1.5, 5.0),
)
# Two cover the deck, so that a third stands on one of them.
LOW = tuple(Carton(f"low_{k}", (0.56, 0.36, 0.15), 4.0, 20.0) for k in (1, 2))


@cache
def pallet_cell() -> Cell:
    return load_workcell("pallet_sia20").preferred


def stack_of(*cartons: Carton, pallet: object = PALLET, **changed: float) -> StackedPallet:
    """The stack of cartons with room for the arm, if nothing else is stated."""
    order = PalletOrder(pallet, cartons, 0.015, 0.006)  # type: ignore[arg-type]
    stack = seen_from(stack_all(replace(order, **changed)), "-y")  # type: ignore[arg-type]
    return StackedPallet.of(stack, DropTest(0.0, 0.0, ()))


@cache
def station() -> PalletStation:
    return PalletStation.of(pallet_cell(), stack_of(*CARTONS))
