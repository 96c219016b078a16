"""Plays grasps and judges them by what the world shows: what was lifted, how it lies in the hand, why not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

from pickcli.geometry import Array
from pickcli.hand.belt_hand import BeltHand, GraspObject
from pickcli.hand.grasp_world import GraspWorld, Standing, WorldDeviation
from pickcli.hand.guarded_grasp import GuardedGrasp
from pickcli.hand.hand_urdf import HINGES
from pickcli.hand.staged_execution import GraspStage, HandWorld, StageName

LOOK_STEPS = 10  # steps between looks at objects in the hand
LIFTED = 0.5  # share of the lift by which an object must have risen
ENVELOPED = 0.8  # share of an object's width, that the gap between the tips is at most


class WatchedWorld(HandWorld, Protocol):
    """A world with a hand, of which is seen what the controller does not know."""

    def contacts(self, name: str) -> dict[str, list[Array]]:
        """Return where an object is touched, (3,) m in the frame of the hand.

        Args:
            name: Its name.

        Returns:
            Points by link of the hand or name of another body.
        """

    def middle_in_hand(self, name: str) -> Array:
        """Return where an object's centre of mass is, (3,) m in the frame of the hand.

        Args:
            name: Its name.

        Returns:
            (3,) m.
        """


class GraspEnd(StrEnum):
    """What a grasp came to."""

    LIFTED = "lifted"
    TWO_OBJECTS = "two objects taken"
    HINGE = "stuck on a hinge"
    DROPPED = "dropped in the lift"
    NOTHING = "nothing between the fingers"
    STOPPED = "stopped by a torque beyond its threshold"


@dataclass(frozen=True, eq=False)
class PreGrasp:
    """A grasp to be played.

    Attributes:
        stand: Where objects stand.
        start: (6,) m and rad of the wrist at the start: x, y, z, yaw, pitch, roll.
        goal: (6,) m and rad before the fingers close.
        deviation: By what the world deviates from the file.
        seconds: s of the approach.
    """

    stand: Sequence[Standing]
    start: Array
    goal: Array
    deviation: WorldDeviation
    seconds: float


@dataclass(frozen=True, eq=False)
class GraspTrial:
    """A grasp that was played.

    Attributes:
        pre_grasp: What was played.
        end: What it came to.
        is_enveloping: Whether the fingers lie around one lifted object: both touch it, and the gap between
            their tips, which lie before its middle, is less than 0.8 of its width.
        stages: The stages.
        held: Names of lifted objects.
        most_force: N, largest force of an object on a pad.
    """

    pre_grasp: PreGrasp
    end: GraspEnd
    is_enveloping: bool
    stages: tuple[GraspStage, ...]
    held: tuple[str, ...]
    most_force: float

    @property
    def approach_time(self) -> float:
        """Duration of the approach, s."""
        return self.stages[0].end - self.stages[0].start

    @property
    def execution_time(self) -> float:
        """From the begin of closing to the end of the firm grasp, s."""
        during = [s for s in self.stages if s.name not in (StageName.APPROACH, StageName.LIFT)]
        return during[-1].end - during[0].start if during else 0.0


def play_grasp(hand: BeltHand, kind: GraspObject, pre_grasp: PreGrasp) -> GraspTrial:
    """Play a grasp.

    Args:
        hand: The hand.
        kind: What is grasped.
        pre_grasp: Where.

    Returns:
        What it came to.
    """
    world = GraspWorld(hand, kind, pre_grasp.stand, pre_grasp.start, pre_grasp.deviation)
    watch = HandWatch(world)
    execution = GuardedGrasp(world, kind, watch)
    before = {name: float(world.pose(name)[2, 3]) for name in world.names}
    execution.run(pre_grasp.goal, pre_grasp.seconds)
    rise = LIFTED * hand.control.lift
    held = tuple(name for name in world.names if float(world.pose(name)[2, 3]) - before[name] > rise)
    is_enveloping = len(held) == 1 and is_enveloped(world, kind, held[0])
    end = GraspEnd.STOPPED if execution.is_stopped else judged(held, watch)
    return GraspTrial(pre_grasp, end, is_enveloping, tuple(execution.stages), held, watch.most_force)


class HandWatch:
    """What is seen of objects in the hand while it grasps, every 20 ms.

    Attributes:
        most_force: N, largest force of an object on a pad.
        was_between: Whether both fingers touched one object.
        was_on_hinge: Whether such an object lay on a hinge when that was looked at last.

    Args:
        world: The world.
    """

    def __init__(self, world: WatchedWorld) -> None:
        self._world = world
        self.most_force = 0.0
        self.was_between = self.was_on_hinge = False
        self._n_steps = 0

    def __call__(self) -> None:
        """Look, after a step."""
        self._n_steps += 1
        if self._n_steps % LOOK_STEPS:
            return
        hand = self._world.hand
        pressed = [(link, name, force) for link in hand.drives for name, force in hand.pressing(link).items()]
        self.most_force = max([self.most_force, *(force for _, _, force in pressed)])
        if hand.wrist.is_level_soft:
            self._look_between(pressed)

    def _look_between(self, pressed: list[tuple[str, str, float]]) -> None:
        """Note which objects both fingers touch, and whether one of these lies on a hinge."""
        sides: dict[str, set[str]] = {}
        for link, name, _ in pressed:
            sides.setdefault(name, set()).add(link.split("_")[0])
        between = [name for name, of in sides.items() if len(of) == 2]
        self.was_between |= bool(between)
        if between:
            self.was_on_hinge = any(set(HINGES) & self._world.contacts(name).keys() for name in between)


def judged(held: tuple[str, ...], watch: HandWatch) -> GraspEnd:
    """Tell what a grasp came to that was not stopped.

    Args:
        held: Names of the objects that were lifted.
        watch: What was seen.

    Returns:
        The end.
    """
    if held:
        return GraspEnd.LIFTED if len(held) == 1 else GraspEnd.TWO_OBJECTS
    if not watch.was_between:
        return GraspEnd.NOTHING
    return GraspEnd.HINGE if watch.was_on_hinge else GraspEnd.DROPPED


def is_enveloped(world: WatchedWorld, kind: GraspObject, name: str) -> bool:
    """Tell whether both fingers touch an object, and their tips before it leave no gap through which it fits.

    Args:
        world: The world.
        kind: The object.
        name: Its name in the world.

    Returns:
        Whether they lie around it.
    """
    tips, middle = world.hand.tips, world.middle_in_hand(name)[0]
    touching = {link.split("_")[0] for link in world.contacts(name)}
    gap = -float(tips[:, 1].sum())
    return {"left", "right"} <= touching and bool(tips[:, 0].min() > middle) and gap < ENVELOPED * kind.width
