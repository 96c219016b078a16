"""A cell in which cartons are stacked: where they come, where they go, and which of them it can stack."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.device import pump_flow
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.schemas.items_file import HEAVIEST
from pickcli.collision.free_flyer import LINE_FOLLOWING_RESERVE
from pickcli.errors import InputError
from pickcli.geometry import inverse, pose
from pickcli.grasping.method_choice import grasp_method
from pickcli.palletizing.carton_item import TOP, carton_item
from pickcli.palletizing.pallet_order import ROUNDED, Carton
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.planning.pick_problem import StatedPlace
from pickcli.planning.pick_settings import DEFAULTS
from pickcli.planning.stages.floor_placements import HOVER
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_checks import taken_by

PALLET, INFEED = "pallet", "infeed"  # places of such a cell
ITEM_NAME = re.compile(r"[a-z0-9_]+")
SET_DOWN_OFF = 0.002  # m by which cartons are set down beside their places, at worst about
NOMINAL = StatedPlace(0.0, 0.0, 0.0)
POINTING_DOWN = np.diag([1.0, -1.0, -1.0])  # (3, 3) of the tool frame


@dataclass(frozen=True, eq=False)
class PalletStation:
    """A cell with a pallet and an infeed. Make it with ``of``.

    Attributes:
        cell: The cell, whose items are the cartons.
        items: The cartons as items, by id, with the seals that the cell's pump keeps.
    """

    cell: Cell
    items: dict[str, Item]

    @classmethod
    def of(cls, cell: Cell, stack: StackedPallet) -> PalletStation:
        """Build the station of a stack.

        Args:
            cell: The cell.
            stack: What is to be stacked there.

        Returns:
            The station.

        Raises:
            InputError: The cell has no pallet or infeed, or another pallet than the stack; or it cannot take
                some of the cartons: with every one of them, and why.
        """
        _refuse_without_places(cell)
        _refuse_other_pallet(cell, stack)
        flow = pump_flow(cell.devices.values())
        items = {p.carton.id: carton_item(p.carton).under_pump(flow) for p in stack.placements}
        of_each = [[*_faults(cell, p.carton, items[p.carton.id])] for p in stack.placements]
        if n_bad := sum(map(bool, of_each)):
            faults = "; ".join(chain.from_iterable(of_each))
            raise InputError(
                f"{cell.name} cannot stack {n_bad} of {len(items)} cartons: {faults}; leave "
                "them out of the order"
            )
        known = {(item.name, item.year): item for item in items.values()}
        return cls(replace(cell, items=cell.items | known), items)

    @staticmethod
    def stated(placement: Placement) -> StatedPlace:
        """Return the planned place of a carton, in the frame of the pallet.

        Args:
            placement: Its placement in the stack.

        Returns:
            The place.
        """
        x, y, z = placement.centre.tolist()
        return StatedPlace(x, y, z, np.pi / 2 if placement.is_turned else 0.0)

    @property
    def pallet(self) -> Place:
        """The place of the stack, in whose frame its placements are stated."""
        return self.cell.places[PALLET]

    def empty(self, seed: int) -> Scene:
        """Return the scene without cartons.

        Args:
            seed: Seed that the scene states.

        Returns:
            The scene.
        """
        return Scene(self.cell, self.cell.T_world_pod, (), PoseNoise(), seed)

    def presented(self, carton: Carton, off: StatedPlace = NOMINAL) -> PlacedItem:
        """Return a carton as it comes: on the middle of the infeed, its length along the x of that.

        Args:
            carton: The carton.
            off: By how much it is beside the middle of the infeed, and turned.

        Returns:
            The carton as it stands there.
        """
        infeed = self.cell.places[INFEED]
        at = replace(off, z=carton.size[2] / 2)
        T = self.cell.T_world_place(infeed) @ at.T_place_item
        return PlacedItem(carton.id, self.items[carton.id], INFEED, T)

    def shortfalls(self, stack: StackedPallet, noise: PoseNoise) -> tuple[str, ...]:
        """Say by what a stack may be too tight for the arm, so that some of its cartons are left.

        Args:
            stack: The stack.
            noise: Bounds of the errors of perceived poses.

        Returns:
            For each key of its order that is less than the arm may need: name, value and need, in mm.
        """
        bound = max((noise.bound(item) for item in self.items.values()), default=0.0)
        needed = {
            "clearance": (
                stack.clearance,
                self.cell.clearance + LINE_FOLLOWING_RESERVE + 2 * bound + SET_DOWN_OFF,
            ),
            "pallet.edge": (stack.pallet.edge, SET_DOWN_OFF),
            "fall": (stack.fall, HOVER + 2 * bound),
        }
        return tuple(
            f"{name} is {1e3 * has:.3g} mm, {1e3 * need:.2g} may be needed"
            for name, (has, need) in needed.items()
            if has < need
        )


def side_of_arm(cell: Cell) -> str:
    """Return the side of the pallet beside which the arm of a cell stands.

    Args:
        cell: The cell.

    Returns:
        One of -x, +x, -y and +y, in the frame of the pallet.

    Raises:
        InputError: The cell has no pallet or infeed.
    """
    _refuse_without_places(cell)
    place = cell.places[PALLET]
    shoulder = (inverse(cell.T_world_place(place)) @ [*cell.robot.shoulder, 1.0])[:2] / place.room.size[:2]
    axis = int(np.argmax(np.abs(shoulder)))
    return ("-" if shoulder[axis] < 0.0 else "+") + "xy"[axis]


def _refuse_without_places(cell: Cell) -> None:
    """Raise InputError if a cell has no pallet or no infeed."""
    for name in (PALLET, INFEED):
        if name not in cell.places:
            raise InputError(
                f"{cell.path / 'cell.yaml'}: has no place called {name}; name a cell that stacks pallets "
                "with --cell, such as pallet_sia20 (docs/formats/cell.md)"
            )


def _refuse_other_pallet(cell: Cell, stack: StackedPallet) -> None:
    """Raise InputError if a stack is for another pallet than the cell's."""
    room, pallet = cell.places[PALLET].room, stack.pallet
    own, other = (" x ".join(f"{side:g}" for side in size) for size in (room.size[:2], pallet.size))
    where = f"cell {cell.name}"
    if np.abs(room.size[:2] - pallet.size).max() > ROUNDED:
        raise InputError(
            f"the stack is for a pallet of {other} m, that of {where} is {own} m; plan it for that one"
        )
    if pallet.walls:
        raise InputError(f"the stack is for a pallet with walls, that of {where} has none; plan it without")
    height = stack.top - pallet.deck
    if height > room.size[2] + ROUNDED:
        raise InputError(
            f"the stack is {height:g} m high over the deck, {where} stacks up to {room.size[2]:g} m; plan it "
            f"with a lower pallet.height, {pallet.deck + room.size[2]:g} m over the floor"
        )


def _faults(cell: Cell, carton: Carton, item: Item) -> Iterator[str]:
    """Yield why a cell cannot take a carton."""
    infeed, tool = cell.places[INFEED].room.size, cell.robot.tool
    method, (length, width, height) = grasp_method(tool), carton.size
    if not ITEM_NAME.fullmatch(carton.id):
        yield f"{carton.id} is no name of an item, which has small letters, digits and _"
    if (kind := taken_by(carton.id, cell)) is not None:
        yield f"{carton.id} is the name of {kind}"
    if carton.mass > HEAVIEST:
        yield f"{carton.id} weighs {carton.mass:g} kg, items weigh up to {HEAVIEST:g} kg"
    if (carton.size > infeed + ROUNDED).any():
        own, room = (" x ".join(f"{side:g}" for side in size) for size in (carton.size, infeed))
        yield f"{carton.id}, {own} m, is larger than the infeed, {room} m"
    if not method.may_hold(item):
        yield f"the top of {carton.id}, {length:g} x {width:g} m, is too narrow for the {tool.grip.holder}"
        return
    load = method.hold(item, TOP, pose((0.0, 0.0, height / 2), R=POINTING_DOWN), PoseNoise())
    ratio = load.at_rest(POINTING_DOWN[None]).ratio
    if ratio > DEFAULTS.load_ratio:
        share = (
            f"{ratio:.0%} of what the {tool.grip.holder} bears, at most {DEFAULTS.load_ratio:.0%} are used"
        )
        yield f"{carton.id} may weigh {item.heaviest:g} kg, {share}"
