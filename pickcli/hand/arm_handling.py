"""Takes an object with the hand at an arm and sets it down elsewhere: plans and stages in one world.

Plans lead the arm to before the grasp, over the place and home; in between it holds the hand compliantly, and
the hand's controller closes, pulls in and lifts, or sets down.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.shapes import Body, Shape
from pickcli.geometry import Array, pose, rotation_from_vector
from pickcli.grasping.envelope import Envelope
from pickcli.hand.arm_impedance import wrist_position
from pickcli.hand.arm_motions import (
    CLUSTER_BACK,
    HELD_MARGIN,
    RAISED,
    ArmMotion,
    HandLoad,
    HeldObject,
    is_free,
    plan_home,
    plan_to_cluster,
    plan_to_place,
    plan_to_pre_grasp,
)
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.belt_hand import GraspObject
from pickcli.hand.cluster import Cluster
from pickcli.hand.grasp_trial import LIFTED, GraspEnd, HandWatch, is_enveloped, judged
from pickcli.hand.guarded_grasp import GuardedGrasp
from pickcli.hand.mounted_hand import open_fingers
from pickcli.hand.place_execution import PlaceExecution
from pickcli.hand.pre_grasp_envelope import aperture
from pickcli.hand.pre_grasps import APPROACH_SPEED
from pickcli.hand.staged_execution import GraspStage, StagedExecution
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.plan_record import PlanRecord
from pickcli.simulation.plan_run import PlanRun

OVER = 0.03  # m over the others of a cluster, to which one of it is lifted
REACHING_DOWN = 0.025  # m that what is held is lowered beyond where it should stand
STAYING = 2.0  # A of the closing motor, with which open fingers stay where they are while the arm moves


class HandStoppedError(Exception):
    """A motion or a stage was stopped, and the arm is to be brought home by hand."""


@dataclass(frozen=True, eq=False)
class ArmGrasp:
    """A grasp that was played.

    Attributes:
        end: What it came to.
        held: Ids of the lifted items.
        is_enveloping: Whether the fingers lie around the one that is held.
        stages: Stages of the hand.
        most_force: N, largest force of an item on a pad.
    """

    end: GraspEnd
    held: tuple[str, ...]
    is_enveloping: bool
    stages: tuple[GraspStage, ...]
    most_force: float


class ArmHandling:
    """The arm with its hand in a world.

    Attributes:
        world: The world.
        motions: Certified motions that were executed, in order.
        records: How each went.
        stages: Stages of the hand, in order.

    Args:
        world: The world.
        home: (n,) rad, where the arm rests between items.
        noise: Bounds of the errors with which poses in the hand are seen.
        recorder: Notes executions of plans.
        seed: Seed of all planning and of these errors.
    """

    def __init__(
        self, world: ArmWorld, home: Array, noise: PoseNoise, recorder: MotionRecorder, seed: int
    ) -> None:
        self.world, self.home, self.noise, self.seed = world, home, noise, seed
        self.recorder = recorder
        self.motions: list[ArmMotion] = []
        self.records: list[PlanRecord] = []
        self.stages: list[GraspStage] = []
        self._lifted = 0.0  # m by the last grasp
        world.hand.motor.set_point = STAYING

    def approach(self, seen: Scene, envelopes: Sequence[Envelope], T_world_object: Array) -> None:
        """Move the open hand into an envelope.

        Args:
            seen: The scene as perceived.
            envelopes: Of which any will do.
            T_world_object: (4, 4) of their frame.

        Raises:
            NoPlanError: There is no certified motion.
            HandStoppedError: It was stopped on the way.
        """
        self._run(
            plan_to_pre_grasp(
                seen, self._carried(), self.world.q, envelopes, T_world_object, self._next_seed()
            )
        )

    def grasp(self, kind: GraspObject, reached_for: Sequence[str]) -> ArmGrasp:
        """Close, pull in and lift.

        Args:
            kind: The object for which currents are set.
            reached_for: Ids of the items that the hand may touch.

        Returns:
            What it came to.
        """
        return self._grasped(kind, reached_for, self.world.hand.hand.control.lift, GuardedGrasp.grasp)

    def _grasped(
        self, kind: GraspObject, reached_for: Sequence[str], lift: float, act: Callable[[GuardedGrasp], None]
    ) -> ArmGrasp:
        """Let the hand act while it may touch some items, and judge what it lifted."""
        world = self.world
        world.reach_for(frozenset(reached_for))
        before = {name: float(world.pose(name)[2, 3]) for name in reached_for}
        world.arm.comply()
        watch = HandWatch(world)
        execution = GuardedGrasp(world, kind, watch, lift)
        act(execution)
        rise, self._lifted = LIFTED * lift, lift
        held = tuple(name for name in reached_for if float(world.pose(name)[2, 3]) - before[name] > rise)
        world.arm.follow()
        if not execution.is_stopped:
            world.reach_for(frozenset(held) or frozenset(reached_for))
        self.stages += execution.stages
        end = GraspEnd.STOPPED if execution.is_stopped else judged(held, watch)
        around = len(held) == 1 and is_enveloped(world, kind, held[0])
        return ArmGrasp(end, held, around, tuple(execution.stages), watch.most_force)

    def grasp_cluster(self, seen: Scene, cluster: Cluster, kind: GraspObject) -> ArmGrasp:
        """Open wide, come in until something of a cluster is met, close on one of it, and lift it out.

        Args:
            seen: The scene as perceived.
            cluster: The cluster.
            kind: The object for which currents are set.

        Returns:
            What it came to.

        Raises:
            NoPlanError: There is no certified motion to before the cluster.
            HandStoppedError: It was stopped on the way.
        """
        self._open_to(-self.world.hand.hand.fingers.widest)
        carried, lift = self._carried(), cluster.height + OVER
        motion, approach = plan_to_cluster(seen, carried, self.world.q, cluster, lift, self._next_seed())
        self._run(motion)
        goal = wrist_position(approach.T_world_hand)
        seconds = CLUSTER_BACK / APPROACH_SPEED
        return self._grasped(kind, cluster.names, lift, lambda execution: execution.run(goal, seconds))

    def transfer(self, seen: Scene, names: Sequence[str], T_world_item: Array) -> None:
        """Bring what is held to just over a place.

        Args:
            seen: The scene as perceived.
            names: Ids of what is held; the first one goes to the place.
            T_world_item: (4, 4) where that is to stand.

        Raises:
            NoPlanError: There is no certified motion.
            HandStoppedError: It was stopped on the way.
        """
        world = self.world
        items = [world.scene.find(name).item for name in names]
        poses = [self._seen_in_hand(name) for name in names]
        solids = tuple(
            Body(name, item.shape.inflated(HELD_MARGIN), T)
            for name, item, T in zip(names, items, poses, strict=True)
        )
        carried = replace(self._carried(), held=solids, mass=sum(item.mass for item in items))
        others = replace(seen, items=tuple(each for each in seen.items if each.id not in names))
        held = HeldObject(poses[0], T_world_item, len(items[0].shape.size) == 2)
        self._run(plan_to_place(others, carried, world.q, held, self._next_seed()))

    def set_down(self) -> None:
        """Lower what is held onto its place, let go and back off. Raises HandStoppedError."""
        self._place(RAISED + REACHING_DOWN)

    def put_back(self) -> None:
        """Lower what is held to where it was lifted from, let go and back off. Raises HandStoppedError."""
        self._place(self._lifted + REACHING_DOWN)

    def _place(self, deepest: float) -> None:
        execution = PlaceExecution(self.world)
        self._carry_out(execution, lambda: execution.place(deepest))
        self.world.reach_for(frozenset())

    def go_home(self, seen: Scene) -> None:
        """Move home by a certified plan.

        Args:
            seen: The scene as perceived.

        Raises:
            NoPlanError: There is no certified motion.
            HandStoppedError: It was stopped on the way.
        """
        self._run(plan_home(seen, self._carried(), self.world.q, self.home, self._next_seed()))

    def leave(self) -> None:
        """Open the hand and back off from where a grasp failed. Raises HandStoppedError."""
        execution = PlaceExecution(self.world)
        self._carry_out(execution, execution.leave)
        self.world.reach_for(frozenset())

    def rise(self) -> None:
        """Rise a bit where it is, with the empty hand. Raises HandStoppedError."""
        execution = PlaceExecution(self.world)
        self._carry_out(execution, execution.rise)

    def has_room_to_open(self, seen: Scene) -> bool:
        """Tell whether the hand may open as far as it goes where it is.

        Args:
            seen: The scene as perceived.

        Returns:
            Whether it is free then.
        """
        hand = self.world.hand.hand
        return is_free(seen, HandLoad(hand, open_fingers(hand)), self.world.q)

    def prepare(self, shape: Shape) -> None:
        """Open the hand where it is to the aperture for an object. Raises HandStoppedError.

        Args:
            shape: Shape of the object.
        """
        self._open_to(aperture(self.world.hand.hand, shape))

    def _open_to(self, angle: float) -> None:
        execution = PlaceExecution(self.world)
        self._carry_out(execution, lambda: execution.open_to(angle))

    def _seen_in_hand(self, name: str) -> Array:
        """Return the pose (4, 4) of an item in the hand as the palm's camera sees it, with errors."""
        rng, noise = derived_rng("seen in hand", self.seed, name, len(self.motions)), self.noise
        off = rng.uniform(-1.0, 1.0, (2, 3)) / np.sqrt(3.0)
        error = pose(noise.position * off[0], R=rotation_from_vector(noise.angle * off[1]))
        return np.asarray(self.world.pose_in_hand(name) @ error)

    def _carried(self) -> HandLoad:
        return HandLoad(self.world.hand.hand, self.world.hand.fingers.copy())

    def _next_seed(self) -> int:
        return derived_seed("arm with a hand", self.seed, len(self.motions))

    def _run(self, motion: ArmMotion) -> None:
        noted = self.recorder.begin(motion.plan, self.world)
        run = PlanRun(motion.plan, self.world, on_progress=lambda progress: noted.note(self.world, progress))
        run.play()
        noted.t_end = self.world.t
        self.motions.append(motion)
        self.records.append(run.record())
        if run.stop is not None:
            raise HandStoppedError(f"{motion.plan.query}: {run.stop}")

    def _carry_out(self, execution: StagedExecution, act: Callable[[], None]) -> None:
        """Carry stages out while the arm is compliant. Raises HandStoppedError."""
        self.world.arm.comply()
        act()
        self.stages += execution.stages
        self.world.arm.follow()
        if execution.is_stopped:
            raise HandStoppedError(f"{execution.stages[-1].name.value}: a torque beyond its threshold")
