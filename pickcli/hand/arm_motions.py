"""Certified motions of an arm with a hand: to before a grasp, with what it holds to a place, away and home.

What the arm carries at that time is part of its last link (``mounted_hand``), so these are plans of an arm
without a tool: proven against everything around it, and judged by the independent verifier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from pickcli.cartesian.line import shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.cell.shapes import Body
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoPlanError, Reason
from pickcli.geometry import Array, inverse, length, levelled, pose, rotation_axis_angle
from pickcli.grasping.envelope import Envelope
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.cluster import Cluster, ClusterApproach
from pickcli.hand.mounted_hand import flange_to_hand, with_hand
from pickcli.hand.place_execution import BACKED, LET_GO, PAST
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.assembly.stitching import stitch_run
from pickcli.planning.coarse_motion import plan_coarse
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.region_query import RegionChecks, RegionProblem, RegionSearch, region_query
from pickcli.scene.scene import Scene
from pickcli.verification.verify import certifier

LINE_SPEED = 0.25  # m/s on it
SEARCHES = (RegionSearch(48, 48), RegionSearch(400, 400))  # poses of each envelope, until some are free
MOST_GOALS = 24  # configurations to which a motion is sought at a time
MOST_PLANS = 6  # that are made until one is certified
FROM_LIMITS = 0.08  # rad that joints keep from their limits where the arm is compliant afterwards
TURNS = 24  # directions of the hand that are tried at a place
# rad by which a box may stand turned where it has no room otherwise
ASKEW = np.array([-0.2, 0.2, -0.4, 0.4, -0.6, 0.6, np.pi / 4])
SEEDS = 6  # of inverse kinematics, for each
MORE_SEEDS = 40  # where none of these leads to a free way down and back
CLUSTER_BACK = 0.12  # m before where the hand closes, from which on it feels its way to a cluster
NEARLY_AS_FREE = (
    0.8  # share of the overhang of the best approach that is free, from which on another is as good
)
HELD_MARGIN = 0.003  # m by which what is held is grown: it may shift in the fingers
GIVING_WAY = 0.002  # m that a compliant arm may be off the lines on which it sets down and backs off
RAISED = 0.015  # m over a place to which what is held is brought by a plan


@dataclass(frozen=True, eq=False)
class HandLoad:
    """What an arm carries while it moves.

    Attributes:
        hand: The hand.
        fingers: (2, 2) rad, how its fingers stand.
        held: Solids that it holds, in its frame.
        mass: kg of these.
    """

    hand: BeltHand
    fingers: Array
    held: tuple[Body, ...] = ()
    mass: float = 0.0


@dataclass(frozen=True, eq=False)
class HeldObject:
    """What is held, and where it goes.

    Attributes:
        T_hand_item: (4, 4) its pose in the hand.
        T_world_item: (4, 4) where it is to stand.
        is_round: Whether it may stand turned by any angle; else by quarter turns.
    """

    T_hand_item: Array
    T_world_item: Array
    is_round: bool


@dataclass(frozen=True, eq=False)
class ArmMotion:
    """A plan with the scene that it was certified in.

    Attributes:
        plan: The plan.
        scene: The scene, whose arm has the hand on its flange.
        end: Which of the ends that were offered to it, it leads to.
    """

    plan: Plan
    scene: Scene
    end: int


def plan_to_pre_grasp(
    scene: Scene, carried: HandLoad, q: Array, envelopes: Sequence[Envelope], T_world_object: Array, seed: int
) -> ArmMotion:
    """Plan into the envelope of poses before a grasp, the last part straight.

    Args:
        scene: The scene as perceived.
        carried: The open hand.
        q: (n,) rad of the arm at rest.
        envelopes: Of which any will do.
        T_world_object: (4, 4) of their frame.
        seed: Seed of all random choices.

    Returns:
        The motion.

    Raises:
        NoPlanError: No pose is reached, or no motion leads there that is certified; with the reasons.
    """
    motion = _Motion.of(scene, carried, q, seed)
    problem = RegionProblem(envelopes, T_world_object, motion.state, q)
    checks = RegionChecks(lambda T: np.ones(len(T), dtype=bool), motion.checker)
    rng, arm = np.random.default_rng(seed), motion.context.arm
    searches = (region_query(arm, problem, checks, rng, search) for search in SEARCHES)
    goals = next((found.Q for found in searches if len(found.Q)), np.empty((0, arm.n)))
    failures, lines = Failures(), list[Array]()
    if not len(goals):
        failures += Reason("no free pose before the grasp", "envelope")
    for goal in goals[:MOST_GOALS]:
        back = motion.line_back(goal)
        why = back if isinstance(back, Failures) else motion.why_near_limits(back)
        if why is None:
            lines.append(np.asarray(back)[::-1])
        else:
            failures += why
    return motion.certified("pre-grasp", lines, SegmentKind.PREAPPROACH, failures)


def plan_to_cluster(
    scene: Scene, carried: HandLoad, q: Array, cluster: Cluster, lift: float, seed: int
) -> tuple[ArmMotion, ClusterApproach]:
    """Plan to before a cluster, from where the level way to it, and up from there, meets nothing else.

    The motion is certified. Of what follows, the way in and up, on which the arm is compliant and pads touch
    items of the cluster, the open hand is proven to be free of everything but these; what it takes along is
    not known before.

    Args:
        scene: The scene as perceived.
        carried: The open hand.
        q: (n,) rad of the arm at rest.
        cluster: The cluster.
        lift: m upwards from where the hand closes.
        seed: Seed of all random choices.

    Returns:
        The motion, and the approach that goes on from its end.

    Raises:
        NoPlanError: No pose before the cluster is reached, or no motion leads there that is certified; with
            the reasons.
    """
    motion = _Motion.of(scene, carried, q, seed)
    others = replace(scene, items=tuple(each for each in scene.items if each.id not in cluster.names))
    through = _Motion.of(others, carried, q, seed)
    failures, starts, found = Failures(), list[Array](), list[ClusterApproach]()
    for approach in cluster.approaches(carried.hand):
        if found and approach.overhang < NEARLY_AS_FREE * found[0].overhang:
            break
        T = approach.T_world_hand
        before = shifted(T, -CLUSTER_BACK * T[:3, 0])
        ways = CLUSTER_BACK * T[:3, 0], np.array([0.0, 0.0, lift])
        for start in motion.configurations([before @ inverse(flange_to_hand(carried.hand))]):
            why = through.why_not_along(start, ways)
            if why is None:
                starts.append(start)
                found.append(approach)
                break
            failures += why
    if not found:
        failures += Reason("no free pose before the cluster", "cluster")
    ends = [start[None] for start in starts[:MOST_GOALS]]
    planned = motion.certified("cluster", ends, SegmentKind.TRANSIT, failures)
    return planned, found[planned.end]


def plan_to_place(scene: Scene, carried: HandLoad, q: Array, held: HeldObject, seed: int) -> ArmMotion:
    """Plan with what is held to just over its place.

    Args:
        scene: The scene as perceived, without what is held.
        carried: The hand with what it holds.
        q: (n,) rad of the arm at rest.
        held: What is held, and where it goes.
        seed: Seed of all random choices.

    Returns:
        The motion.

    Raises:
        NoPlanError: The place is not reached, or no motion leads there that is certified; with the reasons.
    """
    motion = _Motion.of(scene, carried, q, seed)
    away = _Motion.of(scene, HandLoad(carried.hand, np.array([[LET_GO - PAST, 0.0]] * 2)), q, seed)
    away = replace(away, reserve=GIVING_WAY)
    failures, goals = Failures(), list[Array]()
    for n_seeds, turns in product((SEEDS, MORE_SEEDS), _turns(motion, held)):
        for goal in motion.configurations(_poses_at(motion, held, turns), n_seeds):
            why = away.why_not_set_down(goal)
            if why is None:
                goals.append(goal)
            else:
                failures += why
        if goals:
            break
    if not goals:
        failures += Reason("no free pose over the place, from which the hand can back off", "transfer")
    ends = [goal[None] for goal in goals[:MOST_GOALS]]
    return motion.certified("transfer", ends, SegmentKind.TRANSIT, failures)


def plan_home(scene: Scene, carried: HandLoad, q: Array, home: Array, seed: int) -> ArmMotion:
    """Plan a motion home.

    Args:
        scene: The scene as perceived.
        carried: The hand.
        q: (n,) rad of the arm at rest.
        home: (n,) rad.
        seed: Seed of all random choices.

    Returns:
        The motion.

    Raises:
        NoPlanError: No motion leads there that is certified; with the reasons.
    """
    motion = _Motion.of(scene, carried, q, seed)
    return motion.certified("home", [home[None]], SegmentKind.TRANSIT, Failures())


def is_free(scene: Scene, carried: HandLoad, q: Array) -> bool:
    """Tell whether an arm stands free with what it carries.

    Args:
        scene: The scene as perceived.
        carried: The hand.
        q: (n,) rad of the arm.

    Returns:
        Whether it is free.
    """
    return bool(_Motion.of(scene, carried, q, 0).checker.are_valid(q[None])[0])


@dataclass(frozen=True, eq=False)
class _Motion:
    """A motion in planning: the arm with what it carries, in a scene, from where it rests."""

    context: PlanningContext
    scene: Scene
    carried: HandLoad
    q: Array
    seed: int
    reserve: float = 0.0  # m that is kept besides the cell's clearance

    @classmethod
    def of(cls, scene: Scene, carried: HandLoad, q: Array, seed: int) -> _Motion:
        cell = with_hand(scene.cell, carried.hand, carried.fingers, carried.held, carried.mass)
        return cls(PlanningContext(cell), replace(scene, cell=cell), carried, q, seed)

    @property
    def state(self) -> ToolState:
        return self.context.cell.robot.tool.default_state

    @property
    def checker(self) -> SceneChecker:
        return self.context.checker_for(self.scene, Mode(self.state, reserve=self.reserve))

    def line_back(self, q: Array) -> Array | Failures:
        """Return waypoints of the level way against the approach, from a configuration."""
        arm = self.context.arm
        T = arm.tip(q, self.state)
        level = T[:3, 2] * (1.0, 1.0, 0.0)
        there = shifted(T, -BACKED * level / length(level))
        return follow_line(arm, self.checker, T, there, self.state, q, "way back")

    def why_not_set_down(self, q: Array) -> Failures | None:
        """Tell why the way down from a configuration (n,) over a place, or back from there, is not free."""
        arm = self.context.arm
        T = arm.tip(q, self.state)
        below = shifted(T, np.array([0.0, 0.0, -RAISED]))
        down = follow_line(arm, self.checker, T, below, self.state, q, "way down")
        if isinstance(down, Failures):
            return down
        back = self.line_back(down[-1])
        return back if isinstance(back, Failures) else self.why_near_limits(back)

    def why_not_along(self, q: Array, ways: Sequence[Array]) -> Failures | None:
        """Tell why straight ways (3,) m of the hand, one after the other, are not free."""
        arm = self.context.arm
        for way in ways:
            T = arm.tip(q, self.state)
            line = follow_line(arm, self.checker, T, shifted(T, way), self.state, q, "way to the cluster")
            why = line if isinstance(line, Failures) else self.why_near_limits(line)
            if why is not None:
                return why
            q = np.asarray(line)[-1]
        return None

    def why_near_limits(self, Q: Array) -> Failures | None:
        """Tell which joint comes so near to a limit (N, n) that a compliant arm might reach it."""
        limits = self.context.arm.limits
        room = np.minimum(Q - limits.lower, limits.upper - Q).min(axis=0)
        joint = int(room.argmin())
        if room[joint] >= FROM_LIMITS:
            return None
        return Failures.of(
            Reason("joint limit", "way back", f"{self.context.arm.names[joint]} at {room[joint]:.2f}")
        )

    def configurations(self, poses: Sequence[Array], n_seeds: int = SEEDS) -> Array:
        """Return free configurations (K, n) for poses (4, 4) of the flange, the nearest first."""
        arm, rng = self.context.arm, np.random.default_rng(self.seed)
        found = [np.empty((0, arm.n))]
        for T in poses:
            found.append(arm.solve(T, self.state, np.vstack([self.q, arm.random_seeds(rng, n_seeds - 1)])))
        Q = np.concatenate(found)
        Q = Q[self.checker.are_valid(Q)] if len(Q) else Q
        return np.asarray(Q[np.argsort(np.linalg.norm(Q - self.q, axis=1), kind="stable")])

    def certified(self, label: str, ends: list[Array], kind: SegmentKind, failures: Failures) -> ArmMotion:
        """Return a certified coarse motion to any of the ends (N, n), and along it. Raises NoPlanError."""
        limits, mode = SegmentLimits(max_tool_speed=LINE_SPEED), Mode(self.state)
        left = list(range(len(ends)))
        for _ in range(min(MOST_PLANS, len(ends))):
            starts = np.stack([ends[k][0] for k in left])
            coarse = plan_coarse(
                self.context, self.checker, self.q, starts, [0.0] * len(left), self.seed, label
            )
            if isinstance(coarse, Failures):
                failures += coarse
                break
            k = left.pop(coarse.goal)
            end = ends[k]
            last = [MotionSegment(kind, end, limits, mode=mode)] if len(end) > 1 else []
            segments = [coarse.segment(SegmentKind.TRANSIT, mode), *last]
            plan = stitch_run(self.context, self.scene, segments, label, self.seed)
            judged = plan if isinstance(plan, Failures) else certifier(self.scene)(plan)
            if isinstance(judged, Plan):
                return ArmMotion(judged, self.scene, k)
            failures += judged
        raise NoPlanError(label, failures)


def _turns(motion: _Motion, held: HeldObject) -> tuple[Array, ...]:
    """Return rad by which what is held may be turned: as it is to stand, else a bit aside."""
    if held.is_round:
        return (np.arange(TURNS) * 2 * np.pi / TURNS,)
    T_item = _T_world_hand(motion) @ held.T_hand_item
    square = _yaw(held.T_world_item) - _yaw(T_item) + np.arange(4) * np.pi / 2
    return square, (square[:, None] + ASKEW).ravel()


def _poses_at(motion: _Motion, held: HeldObject, turns: Array) -> list[Array]:
    """Return poses (4, 4) of the flange in which what is held is just over its place, upright."""
    T_flange_hand = flange_to_hand(motion.carried.hand)
    T_item = _T_world_hand(motion) @ held.T_hand_item
    above = held.T_world_item[:3, 3] + (0.0, 0.0, RAISED)
    found = []
    for turn in turns.tolist():
        R = rotation_axis_angle((0.0, 0.0, 1.0), turn)
        T_to = pose(above, R=R @ levelled(T_item[:3, :3])) @ inverse(held.T_hand_item)
        found.append(T_to @ inverse(T_flange_hand))
    return found


def _T_world_hand(motion: _Motion) -> Array:
    return motion.context.arm.tip(motion.q, motion.state) @ flange_to_hand(motion.carried.hand)


def _yaw(T: Array) -> float:
    return float(np.arctan2(T[1, 0], T[0, 0]))
