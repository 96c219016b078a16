"""A pick: the query, and the planning problem that it poses."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace
from functools import cached_property, wraps
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np

from pickcli.cell.place import Place
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.stage_contacts import PickContacts
from pickcli.errors import UnknownNameError
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.holding import Hold
from pickcli.motion.plan import Grasp, GraspKind
from pickcli.planning.pick_settings import Neighbours, PickSettings
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.statics.pushing import mass_above, pushable, pushed_height
from pickcli.statics.supports import supports_of

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Shift:
    """A displacement of an item within its place.

    Attributes:
        x: m along x of the place's frame, into the place.
        y: m along its y, to the left.
        turn: rad about its z, to the left.
    """

    x: float
    y: float
    turn: float = 0.0

    def __str__(self) -> str:
        """Return the shift as it is written in queries: "30,-20 mm", or "30,-20 mm and 15 deg"."""
        way = f"{1e3 * self.x:.0f},{1e3 * self.y:.0f} mm"
        return f"{way} and {np.degrees(self.turn):.0f} deg" if self.turn != 0.0 else way


@dataclass(frozen=True)
class StatedPlace:
    """Where an item is to stand in its destination, with the side up that is up before.

    Attributes:
        x: m, of its middle in the frame of the destination.
        y: m.
        z: m, as it stands; it is released a little higher.
        yaw: rad about the destination's z, to the left.
    """

    x: float
    y: float
    z: float
    yaw: float = 0.0

    @property
    def T_place_item(self) -> Array:
        """(4, 4) pose of the item in the frame of the destination."""
        return pose((self.x, self.y, self.z), R=rotation_axis_angle((0.0, 0.0, 1.0), self.yaw))

    def __str__(self) -> str:
        """Return the place as it is written in queries: "100.0,-50.5,125.0 mm and 90.0 deg"."""
        at = ",".join(f"{1e3 * each:.1f}" for each in (self.x, self.y, self.z))
        return f"{at} mm and {np.degrees(self.yaw):.1f} deg"


@dataclass(frozen=True)
class PickQuery:
    """A requested pick.

    Attributes:
        out_of: Place that is picked from.
        item: Instance id or name of the target.
        into: Place that the item is brought to.
        exclude: Grasps that failed before, or kinds of them.
        neighbours: How motions inside the place treat other items.
        by: Shift of the item within its place, which is then ``into``, too; None to take it out.
        at: Where it is to stand in ``into``, which is no open box; None for a free place that is searched.
    """

    out_of: str
    item: str
    into: str = TOTE
    exclude: tuple[Grasp | GraspKind, ...] = ()
    neighbours: Neighbours = Neighbours.AVOID
    by: Shift | None = None
    at: StatedPlace | None = None


@dataclass(frozen=True, eq=False)
class ShiftCorridor:
    """Way of an item that is moved within its place: up, aside, and down.

    Displacements have m along the axes of the entry frame, and rad about its z, then its y, then its x axis.

    Attributes:
        by: The requested shift.
        lifted: (6,) displacement at the end of the lift, until which item and support may touch.
        over: (6,) displacement from which the item is put down; ``lifted`` itself on a short way.
        placed: The item at the release.
    """

    by: Shift
    lifted: Array
    over: Array
    placed: PlacedItem


@dataclass(frozen=True, eq=False)
class PickProblem:
    """The problem of moving one target from its place to another.

    Attributes:
        context: The cell, its models and its precomputed files.
        scene: Poses as perceived; their noise bounds inflate the shapes.
        place: Place of the target.
        target: The item that is picked.
        destination: Place that the target is brought to.
        neighbours: How motions inside the place treat other items.
        seed: Seed of all random choices.
        shift: Way of the target, if it is moved within its place.
        by_named: Whether the arm takes the target only as inverse kinematics leads there from the
            configurations that the cell names for the place, and not from others, too.
        over_rim: Whether the target is dropped from over the rim of its destination where that is not too
            high, instead of from between the walls.
        at: Where the target is to stand in its destination; None for a free place that is searched.
        rise: m by which ways out of a place that is open above lead on upwards, over what stands beside.
        level_with: Ids of the items whose upper sides are level with the lower side of the target, as that
            is set down on them or close to their edges: it may touch them.
    """

    context: PlanningContext
    scene: Scene
    place: Place
    target: PlacedItem
    destination: Place
    neighbours: Neighbours = Neighbours.AVOID
    seed: int = 0
    shift: ShiftCorridor | None = None
    by_named: bool = False
    over_rim: bool = False
    at: StatedPlace | None = None
    rise: float = 0.0
    level_with: frozenset[str] = frozenset()

    @classmethod
    def of(cls, context: PlanningContext, scene: Scene, query: PickQuery, seed: int) -> PickProblem:
        """Build the problem of a query.

        Args:
            context: The cell, its models and its precomputed files.
            scene: Poses as perceived.
            query: The requested pick.
            seed: Seed of all random choices.

        Returns:
            The problem, with the places and the target named by the query.

        Raises:
            UnknownNameError: If a place or the item does not exist.
        """
        places = context.cell.places
        for name in (query.out_of, query.into):
            if name not in places:
                raise UnknownNameError("place", name, list(places))
        target = scene.find(query.item, query.out_of)
        place, destination = places[query.out_of], places[query.into]
        return cls(context, scene, place, target, destination, query.neighbours, seed, at=query.at)

    def back_from(
        self, placed: PlacedItem, rise: float = 0.0, level_with: frozenset[str] = frozenset()
    ) -> PickProblem:
        """Return the pick that would undo this one.

        Args:
            placed: The target as set down at the destination.
            rise: m by which its ways out lead on upwards, over what stands beside.
            level_with: Ids of the items that it is set down on, or close to.

        Returns:
            The pick of the target from there back to its current place.
        """
        moved = self.scene.moved(placed)
        # What is set down pushes nothing: there is no way to know how far the items below give way.
        neighbours = Neighbours.AVOID if self.neighbours is Neighbours.PUSH else self.neighbours
        return replace(
            self, scene=moved, place=self.destination, target=placed, destination=self.place,
            neighbours=neighbours, shift=None, at=None, rise=rise, level_with=level_with,
        )  # fmt: skip

    @property
    def label(self) -> str:
        """Name in plans and messages: "pick ITEM from PLACE", "into PLACE" if not the tote; or of a shift.

        Followed by "at X,Y,Z mm and N deg" if it is stated where the item is to stand.
        """
        if self.shift is not None:
            return shift_label(self.target, self.shift.by)
        name = f"pick {self.target.id} from {self.place.name}"
        if self.at is not None:
            return f"{name} into {self.destination.name} at {self.at}"
        return name if self.destination.name == TOTE else f"{name} into {self.destination.name}"

    @property
    def max_tilt(self) -> float | None:
        """Most tilt (rad) of the target while it is held: as asked, or less as its item file states."""
        stated = (self.context.settings.upright, self.target.item.max_tilt)
        return min((each for each in stated if each is not None), default=None)

    @cached_property
    def T_world_entry(self) -> Array:
        """(4, 4) frame of the way into the place at its actual pose; x points inwards."""
        return np.asarray(self.scene.T_world_place(self.place) @ self.place.T_place_entry)

    @cached_property
    def T_entry_item(self) -> Array:
        """(4, 4) pose of the target in the entry frame."""
        return np.asarray(inverse(self.T_world_entry) @ self.target.T_world_item)

    @cached_property
    def grasp_target(self) -> GraspTarget:
        """The target as grasps are searched for it."""
        noise = self.scene.noise_of(self.target)
        return GraspTarget(self.target.id, self.target.item, self.T_entry_item, self.place, noise)

    def hold(self, face: str, T_tip_item: Array) -> Hold:
        """Describe the target in the tool, and what that bears with every error of the target's pose.

        Args:
            face: The name of the face under the cup, or of the pinched faces.
            T_tip_item: (4, 4) pose of the target in the tool frame.

        Returns:
            The hold.
        """
        noise = self.scene.noise_of(self.target)
        return self.context.method.hold(self.target.item, face, T_tip_item, noise)

    def tool_checker(self, mode: Mode) -> FreeToolChecker:
        """Return the checker of the tool without the arm, level about the axes of the way into the place.

        Args:
            mode: State of the tool, and what it may touch.

        Returns:
            The checker.
        """
        axes = self.T_world_entry[:3, :3]
        return self.context.checkers.tool(self.scene, mode.tool_state, axes, mode.contacts)

    @property
    def uncertainty(self) -> float:
        """Upper bound of the distance of any point of the target from its stated position, m."""
        return self.scene.bound(self.target)

    @property
    def ignored(self) -> frozenset[str]:
        """Ids of the neighbours that are ignored."""
        if self.neighbours is not Neighbours.IGNORE:
            return frozenset()
        here = self.scene.in_location(self.place.name)
        return frozenset(placed.id for placed in here if placed.id != self.target.id)

    @cached_property
    def pushed(self) -> frozenset[str]:
        """Ids of the neighbours that the held target may push aside; none outside of an open box.

        None either in one in which something is that nobody recognised.
        """
        if self.neighbours is not Neighbours.PUSH or self.scene.unrecognised_in(self.place.name):
            return frozenset()  # what is not recognised would be pushed along, who knows where
        return pushable(supports_of(self.scene), self.target.id)

    @cached_property
    def settings(self) -> PickSettings:
        """Settings of the pick: those of the context, unless the target may push others aside."""
        return self.context.settings.while_pushing if self.pushed else self.context.settings

    @cached_property
    def mass_on_target(self) -> float:
        """Mass (kg) that the lifted target may have to bear as it slides off; 0 if nothing is pushed."""
        return mass_above(supports_of(self.scene), self.target.id) if self.pushed else 0.0

    @cached_property
    def above_pushed(self) -> float:
        """Height (m) over the rim that what may be pushed reaches or rears up to; the retreat ends above."""
        if not self.pushed:
            return -np.inf
        rim = float((self.scene.T_world_place(self.place) @ self.place.access.T_place_mouth)[2, 3])
        return pushed_height(supports_of(self.scene), self.target.id) - rim

    @cached_property
    def contacts(self) -> PickContacts:
        """The allowed contacts of each stage."""
        floor, first_stretch = frozenset(self.place.support), self.context.settings.first_stretch
        return PickContacts(self.scene, self.target, floor, self.ignored, first_stretch, self.pushed)

    @cached_property
    def _results(self) -> dict[Hashable, Any]:
        """Results of ``once_per_problem`` functions, by function and arguments."""
        return {}


def shift_label(target: PlacedItem, by: Shift) -> str:
    """Return the name of a shift in plans and messages.

    Args:
        target: The item in its place.
        by: The shift.

    Returns:
        "shift ITEM in PLACE by X,Y mm", "and N deg" if it is turned.
    """
    return f"shift {target.id} in {target.location} by {by}"


def once_per_problem(
    stage: Callable[Concatenate[PickProblem, Arguments], Result],
) -> Callable[Concatenate[PickProblem, Arguments], Result]:
    """Decorate a function whose result is the same for many grasps of a target, so that it runs only once.

    Args:
        stage: A pure function of the problem and of hashable arguments.

    Returns:
        The function; the problem keeps its results.
    """

    @wraps(stage)
    def kept(problem: PickProblem, /, *args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
        key = (stage, args, *kwargs.items())
        if key not in problem._results:
            problem._results[key] = stage(problem, *args, **kwargs)
        result: Result = problem._results[key]
        return result

    return kept
