"""A cell says before anything moves which cartons it cannot stack, and which pallet is not its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import load_workcell
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.pallet_trials.pallet_result import SetDownDeviation
from pickcli.pallet_trials.pallet_station import PalletStation, side_of_arm
from pickcli.palletizing.pallet_order import CONTAINERS, Carton, Pallet
from pickcli.scene.scene import PoseNoise
from pickcli.trial.standing_items import standing
from support.pallet_stacks import CARTONS, PALLET, pallet_cell, stack_of, station


@pytest.mark.parametrize(
    ("carton", "told"),
    [
        (
            Carton("bricks", (0.3, 0.3, 0.3), 60.0),
            r"bricks weighs 60 kg.*may weigh 66 kg, \d+% of what the cup bears",
        ),
        (Carton("map", (0.5, 0.05, 0.1), 1.0), "the top of map, 0.5 x 0.05 m, is too narrow for the cup"),
        (Carton("plank", (0.7, 0.2, 0.1), 1.0), "plank, 0.7 x 0.2 x 0.1 m, is larger than the infeed"),
        (Carton("iron", (0.3, 0.3, 0.3), 24.0), "iron weighs 24 kg, items weigh up to 20 kg"),
        (Carton("infeed", (0.3, 0.2, 0.2), 1.0), "infeed is the name of a part of the cell"),
        (Carton("link_b", (0.3, 0.2, 0.2), 1.0), "link_b is the name of a link of the robot"),
        (Carton("Milk", (0.3, 0.2, 0.2), 1.0), "Milk is no name of an item"),
    ],
)
def test_cartons_that_a_cell_cannot_stack_are_named_all_at_once(carton: Carton, told: str) -> None:
    with pytest.raises(InputError, match=rf"cannot stack 1 of 2 cartons: {told}.*leave them out"):
        PalletStation.of(pallet_cell(), stack_of(CARTONS[0], carton))


@pytest.mark.parametrize(
    ("pallet", "told"),
    [
        (CONTAINERS["eur_pallet"], "for a pallet of 1.2 x 0.8 m, that of cell pallet_sia20 is 0.8 x 0.6 m"),
        (replace(PALLET, walls=("+x",)), "for a pallet with walls"),
    ],
)
def test_another_pallet_than_the_cells_is_refused(pallet: Pallet, told: str) -> None:
    with pytest.raises(InputError, match=told):
        PalletStation.of(pallet_cell(), stack_of(CARTONS[0], pallet=pallet))


def test_a_stack_that_is_too_high_for_the_cell_is_refused() -> None:
    column = [Carton(f"c_{k}", (0.5, 0.4, 0.35), 1.0, 9.0) for k in range(2)]
    stack = stack_of(*column, pallet=replace(PALLET, height=1.0))
    assert stack.top == pytest.approx(0.844)
    with pytest.raises(InputError, match=r"0\.7 m high over the deck, cell pallet_sia20 stacks up to 0\.55"):
        PalletStation.of(pallet_cell(), stack)


def test_a_cell_without_a_pallet_is_refused() -> None:
    crates = load_workcell("ur5e_crates").preferred
    for ask in (side_of_arm, lambda cell: PalletStation.of(cell, stack_of(CARTONS[0]))):
        with pytest.raises(InputError, match="no place called pallet; name a cell that stacks pallets"):
            ask(crates)


def test_the_arm_stands_beside_a_long_side_of_the_pallet() -> None:
    assert side_of_arm(pallet_cell()) == "-y"


def test_what_is_too_tight_is_told_with_what_may_be_needed() -> None:
    roomy, tight = stack_of(*CARTONS), stack_of(*CARTONS, clearance=0.005, fall=0.0)
    noise = PoseNoise(0.001, 0.0035)
    assert station().shortfalls(roomy, noise) == ()
    told = station().shortfalls(tight, noise)
    assert [text.split()[0] for text in told] == ["clearance", "fall"]
    assert told[0].startswith("clearance is 5 mm, ")
    assert station().shortfalls(stack_of(*CARTONS, fall=0.001), PoseNoise()) == ()


def test_a_carton_comes_on_the_middle_of_the_infeed_and_stands_on_it() -> None:
    cell, carton = pallet_cell(), CARTONS[0]
    placed = station().presented(carton)
    at = placed.T_world_item[:3, 3] - cell.T_world_place(cell.places["infeed"])[:3, 3]
    assert at == pytest.approx([0.0, 0.0, carton.size[2] / 2])


def test_what_is_perceived_is_corrected_by_the_height_at_which_cartons_stand() -> None:
    noise = PoseNoise(0.002, 0.01)
    (placed,) = (station().presented(CARTONS[0]),)
    off = pose((0.001, -0.001, 0.0015), rpy=(0.004, -0.003, 0.005))
    T = placed.T_world_item.copy()
    T[:3, :3], T[:3, 3] = off[:3, :3] @ T[:3, :3], T[:3, 3] + off[:3, 3]
    seen = replace(station().empty(0), items=(replace(placed, T_world_item=T),), noise=noise)
    (corrected,) = standing(seen, {placed.id: 0.1}).items
    moved = corrected.T_world_item[:3, 3] - placed.T_world_item[:3, 3]
    assert moved == pytest.approx([0.001, -0.001, 0.0], abs=1e-9)
    assert corrected.T_world_item[2, :3] == pytest.approx([0.0, 0.0, 1.0])
    assert np.arctan2(*corrected.T_world_item[[1, 0], 0]) == pytest.approx(0.005, abs=1e-4)
    (kept,) = standing(seen, {placed.id: 0.2}).items
    assert (kept.T_world_item == T).all()


def test_a_deviation_is_of_the_middle_and_of_the_turn() -> None:
    placement = stack_of(CARTONS[0]).placements[0]
    T = pose(placement.centre + np.array([0.003, -0.004, -0.002]), rpy=(0.0, 0.0, 0.02))
    off = SetDownDeviation.of(placement, T)
    turned = np.pi / 2 if placement.is_turned else 0.0
    assert (off.aside, off.height) == pytest.approx((0.005, -0.002))
    assert off.turn == pytest.approx(abs(0.02 - turned))
    assert off.is_in_place and not replace(off, aside=0.021).is_in_place
    assert not replace(off, height=-0.011).is_in_place
