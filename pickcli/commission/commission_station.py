"""A cell that is a truck with an arm, and a commission in it: where the truck drives, and what stands around.

The world of the cell is the frame of the truck where it stands at the load. As the truck stands elsewhere by
the error of its drives, load and pallet are displaced in that frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import Displacement, displaced
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.commission.commission import LOAD, PALLET, Commission, LoadItem
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.free_space_proof import clearances, rectangle_distances
from pickcli.driving.pallet_entry import entered_pose
from pickcli.driving.steering_path import posed, seen_from
from pickcli.driving.truck_camera import floor_pose
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.grasping.method_choice import grasp_method
from pickcli.hand.belt_hand import BeltHand, GraspObject
from pickcli.hand.hand_file import hand_file, read_hand
from pickcli.palletizing.arm_sequence import seen_from as sequence_from
from pickcli.palletizing.pallet_order import Carton, Pallet, PalletOrder
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.stacking import stack_all
from pickcli.planning.pick_problem import StatedPlace
from pickcli.scene.scene import CarrierPose, PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng

HAND = "apple"  # under data/hands, on the bare flange of a cell
SAME_OBJECT = (
    0.1  # share by which a product's sides and mass may differ from those that a hand has currents for
)
SAME_PLACE = 0.005  # m, by which the pallet of the cell may be off where forks take it
CARRIER_ERROR = Displacement(0.003, 0.003, float(np.deg2rad(0.3)))  # of load and pallet as the arm sees them


@dataclass(frozen=True, eq=False)
class CommissionStation:
    """A commission in a cell. Make it with ``of``.

    Attributes:
        commission: The commission.
        cell: The cell, whose items are those of the commission.
        placements: Where each item is put on the pallet, in the sequence in which they are: cartons around
            them, in the frame of the middle of the part that is filled.
    """

    commission: Commission
    cell: Cell
    placements: tuple[Placement, ...]
    hand: BeltHand | None = None

    @classmethod
    def of(cls, cell: Cell, commission: Commission) -> CommissionStation:
        """Build the station of a commission.

        Args:
            cell: The cell.
            commission: The commission.

        Returns:
            The station.

        Raises:
            InputError: The cell has no load, pallet or home, or another pallet than the commission; the truck
                has no room at the load or where it delivers; or its arm cannot take some of the items, or has
                no room for them on the pallet: with every one of them, and why.
        """
        _refuse_without_places(cell)
        _refuse_other_pallet(cell, commission)
        hand = read_hand(hand_file(HAND)) if cell.robot.tool.is_bare else None
        if faults := [fault for each in commission.items for fault in _faults(cell, hand, each)]:
            raise InputError(f"{cell.name} cannot take {'; '.join(faults)}; change the commission")
        known = {(each.item.name, each.item.year): each.item for each in commission.items}
        cell = replace(cell, items=cell.items | known)
        placements = _placements(commission) if hand is None else _equal_places(commission)
        station = cls(commission, cell, placements, hand)
        station._refuse_load_elsewhere()
        station._refuse_without_room()
        return station

    @property
    def load_in_truck(self) -> Array:
        """(3,) m, m, rad: the load in the frame of the truck, where that stands as it should."""
        return planar(self.cell.carriers[LOAD].T_world_carrier)

    @property
    def pallet_in_truck(self) -> Array:
        """(3,) m, m, rad: the pallet on the forks, entered as it should be."""
        return planar(self.cell.carriers[PALLET].T_world_carrier)

    @property
    def at_load(self) -> Array:
        """(3,) m, m, rad: where the truck is to stand at the load."""
        return with_thing_at(self.commission.load, self.load_in_truck)

    @property
    def load_box(self) -> FloorBox:
        """What the load covers of the floor."""
        (body,) = self.cell.carriers[LOAD].bodies
        height = float(self.cell.carriers[LOAD].T_world_carrier[2, 3])
        return self.commission.load_box(np.array([*body.shape.extents[:2], height]))

    def entering(self, start: Array) -> DrivingArea:
        """Return the area of the drive into the pallet.

        Args:
            start: (3,) m, m, rad: where the truck believes to be.

        Returns:
            The area.
        """
        area = self.commission.area
        return replace(area, start=start, boxes=(*area.boxes, self.load_box))

    def loaded(self, start: Array, goal: Array, straight: float) -> DrivingArea:
        """Return the area of a drive with the pallet on the forks.

        Args:
            start: (3,) m, m, rad: where the truck believes to be.
            goal: (3,) m, m, rad.
            straight: m of the last part, straight into the goal, negative backwards.

        Returns:
            The area; the truck is as long and wide as it is with the pallet.
        """
        area, shape = self.commission.area, self.commission.pallet.shape
        back = max(area.truck.back, shape.length / 2 - float(self.pallet_in_truck[0]))
        truck = replace(area.truck, back=back, width=max(area.truck.width, shape.width))
        boxes = (*area.boxes, self.load_box)
        return replace(
            area,
            start=start,
            goal=goal,
            straight=straight,
            boxes=boxes,
            truck=truck,
            pallet=None,
            enters=False,
        )

    def leaving(self, start: Array) -> DrivingArea:
        """Return the area of the drive out of the pallet that was set down, to where the truck ends.

        Args:
            start: (3,) m, m, rad: where the truck believes to be.

        Returns:
            The area, without the pallet.
        """
        area, boxes = self.commission.area, (*self.commission.area.boxes, self.load_box)
        return replace(
            area, start=start, goal=self.commission.end, straight=0.0, boxes=boxes, pallet=None, enters=False
        )

    def stated(self, placement: Placement) -> StatedPlace:
        """Return the place of an item on the pallet.

        Args:
            placement: Its placement.

        Returns:
            The place, in the frame of the pallet's deck.
        """
        low, high = self.commission.filled_low, self.commission.filled_high
        x, y = (placement.centre[:2] + (np.array(low) + np.array(high)) / 2).tolist()
        yaw = np.pi / 2 if placement.is_turned else 0.0
        return StatedPlace(x, y, float(placement.centre[2]), yaw)

    def scene(self, truck: Array, pallet_in_truck: Array) -> Scene:
        """Return what truly stands around the arm, with all items on the load.

        Args:
            truck: (3,) m, m, rad: where the truck truly stands.
            pallet_in_truck: (3,) m, m, rad: where the pallet truly is on the forks.

        Returns:
            The scene.
        """
        where = {LOAD: seen_from(truck, self.commission.load), PALLET: pallet_in_truck}
        carriers = {name: CarrierPose(self._standing(name, at)) for name, at in where.items()}
        T_load = carriers[LOAD].T_world_carrier
        items = tuple(self._placed(each, T_load) for each in self.commission.items)
        return Scene(self.cell, self.cell.T_world_pod, items, PoseNoise(), carriers=carriers)

    def off_bounds(self, scene: Scene) -> str:
        """Say whether load or pallet stand farther off than the cell allows.

        Args:
            scene: The scene.

        Returns:
            Which, and by how much; "" if both are within the bounds.
        """
        for name in (LOAD, PALLET):
            carrier = self.cell.carriers[name]
            off = inverse(carrier.T_world_carrier) @ scene.pose_of(carrier).T_world_carrier
            if not carrier.displacement.allows(off):
                x, y, yaw = planar(off)
                far = f"{1e3 * x:.0f} and {1e3 * y:.0f} mm and {np.degrees(yaw):.1f} degrees"
                return f"the {name} stands {far} off, farther than the cell allows"
        return ""

    def seen(self, looked: Scene, seed: int, look: int) -> Scene:
        """Return a scene with load and pallet where the arm sees them, with errors, and their bounds.

        Args:
            looked: Items as perceived, load and pallet where they are.
            seed: Seed of the trial.
            look: Number of the look.

        Returns:
            The scene.
        """
        carriers = {}
        for name in (LOAD, PALLET):
            error, rng = CARRIER_ERROR, derived_rng("carrier seen", seed, name, look)
            x, y, yaw = rng.uniform(-1.0, 1.0, 3) * [error.x, error.y, error.yaw]
            T = looked.pose_of(self.cell.carriers[name]).T_world_carrier
            # The bounds refer to the pose of the true carrier relative to the one that is seen.
            carriers[name] = CarrierPose(T @ inverse(displaced(np.eye(4), x, y, yaw)), error)
        return replace(looked, carriers=carriers)

    def _standing(self, name: str, at: Array) -> Array:
        """(4, 4) of a carrier at (3,) m, m, rad, at its height in the cell."""
        return pose((0.0, 0.0, float(self.cell.carriers[name].T_world_carrier[2, 3]))) @ floor_pose(at)

    def _placed(self, each: LoadItem, T_load: Array) -> PlacedItem:
        x, y, yaw = each.at.tolist()
        z = float(each.item.shape.extents[2]) / 2
        T = T_load @ pose((x, y, z), R=rotation_axis_angle((0.0, 0.0, 1.0), yaw))
        return PlacedItem(each.id, each.item, LOAD, T)

    def _refuse_load_elsewhere(self) -> None:
        """Raise InputError if the load stands in a wall or a box."""
        area, load = self.commission.area, self.load_box
        if area.wall_distance(load.corners).min() < 0.0:
            raise InputError("the load reaches through the walls; move load")
        for box in area.boxes:
            if rectangle_distances(load.corners[None], box.corners)[0] <= 0.0:
                raise InputError(f"the load stands in {box.name}; move load or the box")

    def _refuse_without_room(self) -> None:
        """Raise InputError if the truck cannot stand where the commission leads it."""
        commission, half = self.commission, self.pallet_in_truck
        entered, delivered = (with_thing_at(at, half) for at in (commission.pallet.pose, commission.delivery))
        stands = (
            (" with its pallet", "where it takes it", "pallet or load", entered, self._standing_loaded),
            (" with its pallet", "at the load", "load", self.at_load, self._standing_loaded),
            (" with its pallet", "where it delivers", "load or delivery", delivered, self._standing_loaded),
            ("", "at its start", "start or load", commission.area.start, self.entering),
            ("", "at its end", "end or load", commission.end, self.leaving),
        )
        for with_it, where, moved, at, area_at in stands:
            area = area_at(at)
            found = clearances(area, at[None])[0]
            nearest = int(found.argmin())
            if found[nearest] < area.margin:
                of = "the walls" if nearest == 0 else area.boxes[nearest - 1].name
                raise InputError(
                    f"the truck{with_it} has no room {where}: {found[nearest]:.3f} m to {of}, "
                    f"{area.margin:g} m are to be kept; move {moved}"
                )

    def _standing_loaded(self, at: Array) -> DrivingArea:
        """Return the area in which the truck stands with the pallet."""
        return self.loaded(at, at, 0.0)


def planar(T: Array) -> Array:
    """Return where something upright stands, seen from above.

    Args:
        T: (4, 4) its pose.

    Returns:
        (3,) m, m, rad.
    """
    return np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])


def with_thing_at(thing: Array, in_truck: Array) -> Array:
    """Return where the truck stands if something has a pose in its frame.

    Args:
        thing: (3,) m, m, rad: where that stands.
        in_truck: (3,) m, m, rad: its pose in the frame of the truck.

    Returns:
        (3,) m, m, rad.
    """
    return posed(thing, seen_from(in_truck, np.zeros(3)))


def _refuse_without_places(cell: Cell) -> None:
    for name in (LOAD, PALLET):
        if name not in cell.places or len(cell.carriers[name].bodies) != 1:
            raise InputError(
                f"{cell.path / 'cell.yaml'}: has no table called {name}; name a cell that commissions with "
                "--cell, such as apple_booth (docs/formats/commission.md)"
            )
    _ = cell.home  # refused before any work if the cell has none


def _refuse_other_pallet(cell: Cell, commission: Commission) -> None:
    """Raise InputError if the cell has another pallet on its forks, or elsewhere than drives take it."""
    shape, (body,) = commission.pallet.shape, cell.carriers[PALLET].bodies
    if np.abs(body.shape.extents[:2] - [shape.length, shape.width]).max() > SAME_PLACE:
        own = " x ".join(f"{side:g}" for side in body.shape.extents[:2])
        raise InputError(
            f"the {shape.name} pallet is {shape.length:g} x {shape.width:g} m, that of cell {cell.name} is "
            f"{own} m; state another kind"
        )
    entered = seen_from(entered_pose(commission.area, commission.pallet), commission.pallet.pose)
    off = float(np.abs(entered[:2] - planar(cell.carriers[PALLET].T_world_carrier)[:2]).max())
    if off > SAME_PLACE:
        raise InputError(
            f"with a margin of {commission.area.margin:g} m forks take the pallet {1e3 * off:.0f} mm from "
            f"where cell {cell.name} has it; state another margin"
        )


def _faults(cell: Cell, hand: BeltHand | None, each: LoadItem) -> Iterator[str]:
    """Yield why the arm cannot take an item."""
    tool, extents = cell.robot.tool, each.item.shape.extents
    half = cell.places[LOAD].room.size[:2] / 2
    turned = rotation_axis_angle((0.0, 0.0, 1.0), float(each.at[2]))
    over = float((np.abs(each.at[:2]) + each.item.shape.reach(turned)[:2] - half).max())
    if over > 0.0:
        yield (
            f"{each.id} at {each.at[0]:g}, {each.at[1]:g}, which stands {1e3 * over:.0f} mm over the edge of "
            f"the load, {2 * half[0]:g} x {2 * half[1]:g} m"
        )
    if hand is not None:
        if each.item.name not in hand.objects:
            names = ", ".join(hand.objects)
            yield f"{each.id}, for which the hand {hand.name} has no currents (it has them for {names})"
        elif _is_other(each.item, known := hand.objects[each.item.name]):
            solids = " and ".join(str(part.shape.kind.value) for part in known.parts)
            size = " x ".join(f"{side:g}" for side in extents)
            yield (
                f"{each.id}, a {each.item.shape.kind.value} of {size} m and {each.item.mass:g} kg, for which "
                f"the hand {hand.name} has the currents of another object, a {solids} {known.width:g} m wide "
                f"and {known.height:g} m high, {known.mass:g} kg"
            )
        return
    if not grasp_method(tool).may_hold(each.item):
        size = " x ".join(f"{side:g}" for side in extents)
        yield f"{each.id}, {size} m and {each.item.mass:g} kg, which the {tool.grip.holder} cannot hold"


def _is_other(item: Item, known: GraspObject) -> bool:
    """Whether an item is not the object that a hand knows by its name."""
    if len(known.parts) == 1 and item.shape.kind is not known.parts[0].shape.kind:
        return True
    deep = max(float(part.shape.extents[1]) for part in known.parts)
    asked = (*item.shape.extents.tolist(), item.mass)
    return not np.allclose(asked, (known.width, deep, known.height, known.mass), rtol=SAME_OBJECT)


def _placements(commission: Commission) -> tuple[Placement, ...]:
    """Where items are put: beside each other, the farthest from the arm first. Raises InputError."""
    size = np.array(commission.filled_high) - np.array(commission.filled_low)
    pallet = Pallet((float(size[0]), float(size[1])))
    cartons = tuple(_carton(each) for each in commission.items)
    room = np.sort(size)
    wide = [c.id for c in cartons if (np.sort(c.size[:2]) > room).any()]
    stack = None if wide else stack_all(PalletOrder(pallet, cartons, commission.apart))
    left = wide if stack is None else list(stack.left)
    if stack is None or left:
        raise InputError(
            f"the part of the deck that is filled, {size[0]:g} x {size[1]:g} m, has no room for "
            f"{', '.join(left)} with {commission.apart:g} m between items; fill more of it"
        )
    return sequence_from(stack, "+x").placements


def _equal_places(commission: Commission) -> tuple[Placement, ...]:
    """Where a hand that grasps from the side puts items: places of one size, the farthest from the arm first.

    They are filled by the items as the hand reaches them, those in front on the load first. Raises
    InputError.
    """
    widest = np.max([each.item.shape.extents[:2].max() for each in commission.items])
    highest = np.max([each.item.shape.extents[2] for each in commission.items])
    largest = Shape(ShapeKind.BOX, (float(widest), float(widest), float(highest)))
    alike = [replace(each, item=replace(each.item, shape=largest)) for each in commission.items]
    places = _placements(replace(commission, items=tuple(alike)))
    reached = sorted(commission.items, key=lambda each: float(each.at[1]))
    return tuple(_taken_by(place, _carton(each)) for place, each in zip(places, reached, strict=True))


def _taken_by(place: Placement, carton: Carton) -> Placement:
    """Return the placement of another carton at the middle of a place on the deck."""
    low = np.array([*place.centre[:2], 0.0]) - np.array([*carton.size[:2], 0.0]) / 2
    return replace(place, carton=carton, low=low, is_turned=False)


def _carton(each: LoadItem) -> Carton:
    length, width, height = each.item.shape.extents.tolist()
    return Carton(each.id, (length, width, height), each.item.mass, 0.0)
