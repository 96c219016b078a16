"""Check the items that a held one may push aside on its way out of an open box: which, how, and the load.

Where they end up is not known. So they must be items that may lie anywhere in their box, nothing may be
carried along, and what holds the item must bear the friction and the weight of what slides off as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Set
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.hold_choice import load_ratios
from pickcli.verification.load_check import GRAVITY, held_wrenches
from pickcli.verification.pile_statics import carriers_of, falling_without, lying_on, may_leave
from pickcli.verification.quintic import positions_at
from pickcli.verification.separation import overlap
from pickcli.verification.static_solids import place_at
from pickcli.verification.straightness_check import SPEED_TOLERANCE, every_millisecond, fastest_tip
from pickcli.verification.tool_change_check import held_tip_poses

HEAVIEST = 0.6  # kg of a pushed item: it resists by its weight, 6 N, a third of a cup's reserve
MOST_SPEED = 0.1  # m/s of the tool: a pushed item comes to rest within 2 mm by its own friction
MOST_LOAD = 0.6  # of what the tool bears, by the item with all that lies on it
MOST_DESCENT = 0.002  # m: what is below would be pressed, not pushed aside
OUTWARDS = (SegmentKind.LIFT, SegmentKind.RETREAT)
N_DIRECTIONS = 360
DIVIDED = 0.003  # m, besides the errors of both poses, by which solids that a plane divides may overlap
UPRIGHT = 0.01  # vertical part of the normal of an upright plane, besides the errors of both angles


def pushed_by(plan: Plan) -> frozenset[str]:
    """Return the items that a plan may push aside in any segment.

    Args:
        plan: The plan.

    Returns:
        Ids.
    """
    return frozenset(name for segment in plan.segments for name in segment.pushing)


def check_push(plan: Plan, scene: Scene, T_tip_item: Array | None) -> tuple[Reason, ...]:
    """Check every condition of pushing items aside.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.

    Returns:
        The faults; () for a plan that pushes nothing.
    """
    if not pushed_by(plan) or plan.grasp is None:
        return ()  # without an item it topples others: ``topple_check``
    reasons = tuple(_wrong_segments(plan))
    if reasons or T_tip_item is None:
        return reasons or (Reason("pushes without an item", "plan", "nothing is held"),)
    taken = _taken(plan, scene, T_tip_item)
    place = scene.cell.places.get(taken.location)
    if place is None or not place.is_open_box:
        at = taken.location or "no place"
        return (Reason("pushes outside of an open box", taken.id, f"it is taken out of {at}"),)
    heap = PushedHeap(
        replace(scene, items=(*(p for p in scene.items if p.id != taken.id), taken)), place, taken
    )
    return (
        *heap.not_pushable(pushed_by(plan)),
        *heap.carried_along(pushed_by(plan)),
        *_too_fast(plan, scene),
        *_descending(plan, scene, T_tip_item),
        *_among_reared(plan, scene, T_tip_item, heap.reared_to(pushed_by(plan))),
        *_without_reserve(plan, scene, T_tip_item, heap.mass_on_it(pushed_by(plan))),
    )


def _wrong_segments(plan: Plan) -> Iterator[Reason]:
    """Yield the segments that push, but are not on the way of a held item out of where it was taken."""
    is_on_its_way = plan.recovery in (None, RecoveryLevel.AS_PLANNED)
    has_lifted = False
    for k, segment in enumerate(plan.segments):
        if segment.held is not None:
            has_lifted = True
            is_on_its_way &= segment.kind in OUTWARDS and segment.tool_state != MOVING
        if segment.pushing and not (is_on_its_way and has_lifted and segment.held is not None):
            names = ", ".join(segment.pushing[:3])
            where = f"segment {k} ({segment.kind})"
            yield Reason("pushing not allowed", where, f"{names}; only a held item on its way out may")


def _taken(plan: Plan, scene: Scene, T_tip_item: Array) -> PlacedItem:
    """Return the item where it is taken; if it is held from the start, in the place that it is in there."""
    assert plan.grasp is not None
    if plan.segments[0].held is None:
        return scene.find(plan.grasp.item)
    robot, q = scene.cell.robot, positions_at(plan.trajectory, 0.0)
    T = tip_poses(robot, link_poses(robot, q), plan.segments[0].tool_state)[0] @ T_tip_item
    place, held = place_at(scene, T), scene.instance(plan.grasp.item)
    return PlacedItem(held.id, held.item, "" if place is None else place.name, T, held.noise)


@dataclass(frozen=True, eq=False)
class PushedHeap:
    """The items in an open box, and the one that is taken out of it.

    Attributes:
        scene: The scene with the taken item where it is taken.
        place: The box.
        taken: The taken item.
    """

    scene: Scene
    place: Place
    taken: PlacedItem

    def not_pushable(self, pushed: frozenset[str]) -> Iterator[Reason]:
        """Find pushed items that are elsewhere, heavy, high, or needed by one that may not be pushed.

        That is what lies on them, and what would fall without all of them, and over the rim.

        None may be pushed where something is that nobody recognised: it would be pushed along.

        Args:
            pushed: Ids of the pushed items.

        Yields:
            Faults.
        """
        here = {placed.id: placed for placed in self.scene.in_location(self.place.name)}
        leaving = {name for name, other in here.items() if may_leave(self.scene, self.place, other)} - pushed
        for body in self.scene.unrecognised_in(self.place.name)[:1]:
            yield _fault(", ".join(sorted(pushed)), f"nobody recognised what is at {body.name}")
        for name in sorted(pushed):
            placed = here.get(name)
            if placed is None or name == self.taken.id:
                yield _fault(name, f"it is no other item in {self.place.name}")
                continue
            if placed.item.heaviest > HEAVIEST:
                yield _fault(name, f"it may have {placed.item.heaviest:.2f} kg, at most {HEAVIEST}")
            if not self._highest(placed) < self._rim:
                over = 1e3 * (self._highest(placed) - self._rim)
                yield _fault(name, f"its middle may be {over:.0f} mm over the rim of {self.place.name}")
            for other in sorted(lying_on(self.scene, name) - pushed - {self.taken.id}):
                yield _fault(name, f"{other} lies on it and may not be pushed")
        for other in sorted(leaving & self._falling(pushed & here.keys())) if leaving else ():
            yield _fault(
                ", ".join(sorted(pushed)), f"{other} would fall without them, and may fall over the rim"
            )

    def carried_along(self, pushed: frozenset[str]) -> Iterator[Reason]:
        """Find the items that lie on or over the taken one with their centre over it.

        Args:
            pushed: Ids of the pushed items.

        Yields:
            Faults.
        """
        for name in sorted(self._higher(pushed)):
            if self._is_over(self.scene.find(name)):
                yield Reason("carries another item along", self.taken.id, f"{name} lies over it", name)

    def mass_on_it(self, pushed: frozenset[str]) -> float:
        """Return the mass of all that lies on the taken item, or that it meets above it.

        Args:
            pushed: Ids of the pushed items.

        Returns:
            kg at most.
        """
        met = self._met(pushed)
        borne = met.union(*(lying_on(self.scene, name) for name in met)) - {self.taken.id}
        return float(sum(self.scene.find(name).item.heaviest for name in sorted(borne)))

    def reared_to(self, pushed: frozenset[str]) -> float:
        """Return how high the items may stand that are lifted by one side as they slide off.

        Args:
            pushed: Ids of the pushed items.

        Returns:
            m in the world: from the lowest point of each over its diagonal; minus infinity without any.
        """
        met = [self.scene.find(name) for name in sorted(self._met(pushed))]
        lowest = [float(p.T_world_item[2, 3] - p.item.shape.reach(p.T_world_item[:3, :3])[2]) for p in met]
        diagonals = (float(np.linalg.norm(placed.item.shape.extents)) for placed in met)
        return max((low + long for low, long in zip(lowest, diagonals, strict=True)), default=-np.inf)

    def _met(self, pushed: frozenset[str]) -> set[str]:
        """Return what lies on the taken item, or is higher and partly over it, and not beside it."""
        lying = lying_on(self.scene, self.taken.id)
        others = [self.scene.find(name) for name in sorted(self._higher(pushed))]
        return {
            each.id
            for each in others
            if each.id in lying or (self._is_over(each, partly=True) and not self._is_beside(each))
        }

    def _is_beside(self, other: PlacedItem) -> bool:
        """Whether the taken item passes another one as it rises, by an upright plane between convex solids.

        The plane may also be under the taken item. Within the errors of poses it counts as dividing them.
        """
        taken, scene = self.taken, self.scene
        deep, way = overlap(taken.item.shape, taken.T_world_item, other.item.shape, other.T_world_item)
        angle = scene.noise_of(taken).angle + scene.noise_of(other).angle
        bounds = self._bound(taken) + self._bound(other)
        return bool(deep <= bounds + DIVIDED and way[2] <= np.sin(angle) + UPRIGHT)

    def _higher(self, pushed: frozenset[str]) -> frozenset[str]:
        """Return what lies on the taken item, and the pushed items whose centre is higher.

        What it lies on is below the plane of their contact, also where its centre is the higher one.
        """
        height = self.taken.T_world_item[2, 3]
        here = self.scene.in_location(self.place.name)
        over = {p.id for p in here if p.id in pushed and p.T_world_item[2, 3] > height}
        over -= carriers_of(self.scene, self.taken.id)
        return (lying_on(self.scene, self.taken.id) | over) - {self.taken.id}

    def _is_over(self, other: PlacedItem, partly: bool = False) -> bool:
        """Whether the centre, or some part, of an item may be vertically over some point of the taken one."""
        turn = 2.0 * np.pi * np.arange(N_DIRECTIONS) / N_DIRECTIONS
        across = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(N_DIRECTIONS)])
        T, T_other = self.taken.T_world_item, other.T_world_item
        reach = self.taken.item.shape.reach(across @ T[:3, :3]) + self._bound(self.taken) + self._bound(other)
        if partly:
            reach = reach + other.item.shape.reach(across @ T_other[:3, :3])
        return bool((across @ (T_other[:3, 3] - T[:3, 3]) <= reach).all())

    def _falling(self, pushed: Set[str]) -> frozenset[str]:
        """Return what falls without the pushed items, and would not without the taken one only."""
        where, taken = self.place.name, frozenset({self.taken.id})
        return falling_without(self.scene, where, pushed | taken) - falling_without(self.scene, where, taken)

    @property
    def _rim(self) -> float:
        return float((self.scene.T_world_place(self.place) @ self.place.access.T_place_mouth)[2, 3])

    def _highest(self, placed: PlacedItem) -> float:
        """Return the largest height in m of an item's middle within the error of its pose."""
        return float(placed.T_world_item[2, 3]) + self._bound(placed)

    def _bound(self, placed: PlacedItem) -> float:
        return self.scene.bound(placed)


def _fault(name: str, why: str) -> Reason:
    return Reason("may not be pushed", name, why)


def _too_fast(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Yield the segments that push at more than the speed that they may."""
    for k, segment in enumerate(plan.segments):
        if segment.pushing:
            speed = fastest_tip(plan, scene.cell.robot, segment.tool_state, segment.t_start, segment.t_end)
            if not speed <= MOST_SPEED * (1.0 + SPEED_TOLERANCE):
                where = f"segment {k} ({segment.kind})"
                yield Reason("pushes too fast", where, f"{speed:.4f} m/s, at most {MOST_SPEED}")


def _descending(plan: Plan, scene: Scene, T_tip_item: Array) -> Iterator[Reason]:
    """Yield the segments that push in which the middle of the held item comes down."""
    robot = scene.cell.robot
    for k, segment in enumerate(plan.segments):
        if segment.pushing:
            times = every_millisecond(segment.t_start, segment.t_end)
            links = link_poses(robot, positions_at(plan.trajectory, times))
            heights = (tip_poses(robot, links, segment.tool_state) @ T_tip_item)[:, 2, 3]
            descent = float((np.maximum.accumulate(heights) - heights).max())
            if descent > MOST_DESCENT:
                where = f"segment {k} ({segment.kind})"
                yield Reason("pushes downwards", where, f"the item comes down by {1e3 * descent:.1f} mm")


def _among_reared(plan: Plan, scene: Scene, T_tip_item: Array, height: float) -> Iterator[Reason]:
    """Yield a fault if the held item, as it pushes no longer, is lower than what may stand beside it.

    height: m in the world, which nothing that rears up beside it exceeds
    """
    k = max(k for k, segment in enumerate(plan.segments) if segment.pushing)
    segment, item = plan.segments[k], scene.item(_held(plan))
    q = positions_at(plan.trajectory, segment.t_end)
    T = tip_poses(scene.cell.robot, link_poses(scene.cell.robot, q), segment.tool_state)[0] @ T_tip_item
    lowest = float(T[2, 3] - item.shape.reach(T[:3, :3])[2])
    if lowest < height:
        detail = f"the item is {1e3 * (height - lowest):.0f} mm lower than what it pushed may stand up"
        yield Reason("pushes no longer", f"segment {k} ({segment.kind})", detail)


def _held(plan: Plan) -> str:
    assert plan.grasp is not None
    return plan.grasp.item


def _without_reserve(plan: Plan, scene: Scene, T_tip_item: Array, on_it: float) -> Iterator[Reason]:
    """Yield the segments that push in which item and what lies on it may load the tool too much.

    on_it: kg that may rest at any corner of the box around the item
    """
    assert plan.grasp is not None
    times, own = held_wrenches(plan, scene, T_tip_item)
    tips = held_tip_poses(plan, scene.cell.robot, times)
    force = on_it * tips[:, :3, :3].swapaxes(1, 2) @ GRAVITY
    loads = load_ratios(plan, scene, own)
    for signs in product((-0.5, 0.5), repeat=3):
        corner = T_tip_item[:3, :3] @ (signs * scene.item(plan.grasp.item).shape.extents) + T_tip_item[:3, 3]
        laden = own + np.hstack([force, np.cross(corner, force)])
        loads = np.maximum(loads, load_ratios(plan, scene, laden))
    for k, segment in enumerate(plan.segments):
        if segment.pushing:
            is_here = (times >= segment.t_start) & (times <= segment.t_end)
            worst = float(loads[is_here].max(initial=0.0))
            if not worst <= MOST_LOAD:
                where = f"segment {k} ({segment.kind})"
                detail = f"{worst:.2f} of what the tool bears with {on_it:.2f} kg on it, at most {MOST_LOAD}"
                yield Reason("no reserve for pushing", where, detail)
