"""How a trial perceives the scene: exactly, with bounded errors, or by the cameras of its cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Protocol

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING
from pickcli.geometry import inverse
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.reality import IDEAL, Reality
from pickcli.trial.pose_noise import perceive

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from pickcli.perception.items.item_observation import ItemObservation
    from pickcli.perception.viewpoints import Viewpoint
    from pickcli.trial.trial_interfaces import ExecutionResult

LOOK_FROM = "look from "  # how queries of motions begin that bring a camera to where it looks from
_AROUND = 0.05  # m around a place in which a tip may disturb what is in it


class PerceptionKind(StrEnum):
    """Sources of the perceived scene."""

    TRUTH = "truth"
    NOISE = "noise"
    CAMERA = "camera"


@dataclass(frozen=True, eq=False)
class Touched:
    """What the robot knows to have touched since the last look, and where it did not get on.

    Attributes:
        places: Names of places that a tip was planned to enter.
        moved: By item id, the places in which it may be besides those in which it was.
        in_doubt: Names of places out of which no plan led for an item: what is unknown in them may be why.
    """

    places: frozenset[str] = frozenset()
    moved: Mapping[str, frozenset[str]] = field(default_factory=dict)
    in_doubt: frozenset[str] = frozenset()

    def also(self, plan: Plan, cell: Cell, scene: Scene, has_left_item: bool = False) -> Touched:
        """Add what a plan touches.

        Args:
            plan: The plan.
            cell: The cell as seen by its arm.
            scene: The perceived scene.
            has_left_item: Whether the tool measured that it did not take the item from where it was.

        Returns:
            All that is touched.
        """
        moved = dict(self.moved)
        if plan.grasp is not None and not has_left_item:
            before = moved.get(plan.grasp.item, frozenset())
            moved[plan.grasp.item] = before | _entered(plan, cell, scene, 0.0)
        return replace(self, places=self.places | _entered(plan, cell, scene, _AROUND), moved=moved)

    def doubting(self, place: str) -> Touched:
        """Add a place out of which no plan led.

        Args:
            place: Its name.

        Returns:
            All of it.
        """
        return replace(self, in_doubt=self.in_doubt | {place})


def _entered(plan: Plan, cell: Cell, scene: Scene, around: float) -> frozenset[str]:
    """The places in whose room, or so many m around it, the tip is at the end of a segment."""
    found = set()
    arm = Arm(cell.robot)
    for segment in plan.segments:
        if segment.tool_state == MOVING:  # the arm rests, where a segment before or after it ends
            continue
        q = plan.trajectory.sample(segment.t_end).reshape(-1)
        tip = arm.tip(q, segment.tool_state)[:3, 3]
        for place in cell.places.values():
            T_place_world = inverse(scene.T_world_place(place))
            p = T_place_world[:3, :3] @ tip + T_place_world[:3, 3]
            if ((p > place.room.low - around) & (p < place.room.high + around)).all():
                found.add(place.name)
    return frozenset(found)


@dataclass(frozen=True, eq=False)
class PerceivedItem:
    """What a look said of an item, and the truth, which is only for the record.

    Attributes:
        place: Name of the place that it was looked for in.
        answer: The answer.
        bound: Bounds of its error with that of the camera's pose; None if it is not believed.
        off: By how much the pose is truly off, symmetries aside; None without a pose.
    """

    place: str
    answer: ItemObservation
    bound: PoseNoise | None
    off: PoseNoise | None

    @property
    def is_believed(self) -> bool:
        """Whether the pose is used: it is an answer, and its error has bounds."""
        return self.bound is not None

    @property
    def is_bound_kept(self) -> bool:
        """Whether the true pose is within the stated bounds; False without any, or if the item is gone."""
        if self.bound is None or self.off is None:
            return False
        return self.bound.holds(self.off)


@dataclass(frozen=True, eq=False)
class LookRecord:
    """One look by cameras.

    Attributes:
        number: Number of the look in its trial, from 1.
        cameras: By place that was looked into, camera and configuration of the arm.
        items: What was said of all items that are listed to be in these places.
        pictures: By place, (h, w, 3) the answers drawn over its picture.
        motions: Records of the motions that brought the cameras there.
    """

    number: int
    cameras: Mapping[str, tuple[str, str]]
    items: tuple[PerceivedItem, ...]
    pictures: Mapping[str, NDArray[np.uint8]] = field(default_factory=dict)
    motions: tuple[ExecutionResult, ...] = ()


@dataclass(frozen=True, eq=False)
class ReachedViews:
    """From where pictures can be taken after the arm went there.

    Attributes:
        viewpoints: Those that were reached, in order of time.
        motions: Records of the motions.
    """

    viewpoints: tuple[Viewpoint, ...]
    motions: tuple[ExecutionResult, ...] = ()

    def has(self, viewpoint: Viewpoint) -> bool:
        """Whether a viewpoint is among them, by its camera and configuration.

        Args:
            viewpoint: The viewpoint.

        Returns:
            True if it is.
        """
        return any(viewpoint.name == each.name for each in self.viewpoints)


class Perception(Protocol):
    """Makes the perceived scene of the true one; the only interface between both."""

    def look(self, true: Scene, number: int, touched: Touched) -> Scene:
        """Perceive what is seen without a motion of the arm.

        Args:
            true: The true scene.
            number: Number of the look, from 1.
            touched: What was touched since the last look.

        Returns:
            The perceived scene, with what was seen before of all else.
        """

    def viewpoints(self) -> tuple[Viewpoint, ...]:
        """Return from where pictures are to be taken next.

        Returns:
            The viewpoints, each once; none if there is nothing more to see.
        """

    def look_from(self, true: Scene, number: int, reached: ReachedViews) -> Scene:
        """Take the pictures of the last ``viewpoints``.

        Args:
            true: The true scene.
            number: Number of the look, from 1.
            reached: Those of the viewpoints at which the arm was.

        Returns:
            The perceived scene.
        """

    def homes(self, first: Scene) -> Mapping[str, str]:
        """Return where items are at the start.

        Args:
            first: The scene as first perceived.

        Returns:
            Places by item id: those perceived, and those that are only known from the order.
        """

    def refusal(self, item: str, home: str) -> str:
        """Return why an item is not perceived although it may be somewhere.

        Args:
            item: Its name.
            home: The place that it was in at the start.

        Returns:
            The reason for one of its copies; "" if none was refused.
        """

    def hiding(self, place: str) -> tuple[str, ...]:
        """Return what hides most of what is not known in a place.

        Args:
            place: Name of the place.

        Returns:
            Ids of perceived items, first that which hides most.
        """

    def claimed(self, scene: Scene) -> Scene:
        """Add items that are not perceived to the places that they must be in.

        Args:
            scene: The scene as last perceived.

        Returns:
            The scene for the output file, which states contents and no poses.
        """

    @property
    def looks(self) -> tuple[LookRecord, ...]:
        """All looks by cameras so far."""


@dataclass(frozen=True)
class BoundedErrors:
    """Perception of all items with errors within bounds.

    Attributes:
        noise: The bounds.
        seed: Seed of the trial.
        reality: Levels of outliers and of the pod's pose error.
    """

    noise: PoseNoise
    seed: int
    reality: Reality = IDEAL

    def look(self, true: Scene, number: int, touched: Touched) -> Scene:
        """Perceive the scene, as ``pose_noise.perceive``.

        Args:
            true: The true scene.
            number: Number of the look, from 1.
            touched: Does not matter.

        Returns:
            The perceived scene.
        """
        return perceive(true, self.noise, self.seed, number, self.reality)

    def viewpoints(self) -> tuple[Viewpoint, ...]:
        """Return nothing: one look is at everything.

        Returns:
            No viewpoints.
        """
        return ()

    def look_from(self, true: Scene, number: int, reached: ReachedViews) -> Scene:
        """Perceive the scene, as ``look``.

        Args:
            true: The true scene.
            number: Number of the look, from 1.
            reached: Does not matter.

        Returns:
            The perceived scene.
        """
        return self.look(true, number, Touched())

    def homes(self, first: Scene) -> Mapping[str, str]:
        """Return where items are perceived.

        Args:
            first: The scene as first perceived.

        Returns:
            Places by item id.
        """
        return {placed.id: placed.location for placed in first.items}

    def refusal(self, item: str, home: str) -> str:
        """Return "": no item is refused.

        Args:
            item: Its name.
            home: The place that it was in at the start.

        Returns:
            "".
        """
        return ""

    def hiding(self, place: str) -> tuple[str, ...]:
        """Return nothing: nothing is hidden.

        Args:
            place: Does not matter.

        Returns:
            No ids.
        """
        return ()

    def claimed(self, scene: Scene) -> Scene:
        """Return the scene: what is not perceived is nowhere.

        Args:
            scene: The scene as last perceived.

        Returns:
            The same.
        """
        return scene

    @property
    def looks(self) -> tuple[LookRecord, ...]:
        """No looks by cameras."""
        return ()


def true_poses(seed: int) -> BoundedErrors:
    """Return a perception that is never wrong.

    Args:
        seed: Seed of the trial.

    Returns:
        The perception: items and pod are exactly where they are.
    """
    return BoundedErrors(PoseNoise(), seed)
