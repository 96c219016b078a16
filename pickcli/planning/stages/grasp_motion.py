"""Motion inside a place for one grasp: key waypoints are checked first, then every line is proven.

Delft, section 2.2: (1) the grasp and the key waypoints are checked one after the other, (2) then each
linear segment; the first thing that fails discards the candidate.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeVar

import numpy as np

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import PickPoses
from pickcli.cartesian.line_following import follow_line
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment, at_rest
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.grasp_method import GraspModes
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_motion import GraspMotion, ToolLines
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.pick_settings import SLOWER_THAN_ALLOWED, PickSettings
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene

N_SEEDS, N_ALONG = 12, 4  # of inverse kinematics at the contact, and how many of these vary along the rails
_Poses = TypeVar("_Poses")


def plan_grasp_motion(
    problem: PickProblem, ways: ToolLines, contact_speed: float, seeds: Array
) -> GraspMotion | Failures:
    """Find the first feasible motion for one grasp, over the branches and redundancy of the arm.

    Args:
        problem: The pick.
        ways: Tool motions of the grasp, planned without the arm.
        contact_speed: m/s, highest speed at which the tool may meet the target.
        seeds: (K, n) from which inverse kinematics begins (``arm_seeds``).

    Returns:
        The motion in the place, or every reason for failure.
    """
    context, grasp, contact, where = problem.context, ways.grasp, ways.contact, str(ways.grasp)
    solutions = context.arm.solve(contact, grasp.tool_state, seeds)
    if len(solutions) == 0:
        return Failures.of(Reason("no inverse-kinematics solution", f"{where}, contact", _place(contact)))
    lines = _Lines.of(problem, ways, contact_speed)
    failures, pressed = Failures(), lines.checker(lines.modes.taking)
    for q_contact in solutions[: context.settings.solutions_per_grasp]:
        if not pressed.is_valid(q_contact):
            failures += _invalid(pressed, q_contact, f"{where}, contact")
            continue
        inward = _first(ways.inward, lines.inward, q_contact)
        if isinstance(inward, Failures):
            failures += inward
            continue
        outward = _first(ways.outward, lines.outward, q_contact)
        if isinstance(outward, Failures):
            failures += outward
            continue
        return GraspMotion(grasp, lines.attached, inward, outward)
    return failures


def plan_motion_down(back: PickProblem, ways: ToolLines, T_over: Array, q: Array) -> GraspMotion | Failures:
    """Follow the straight line on which a held item is put down, and the way of the empty tool from there.

    Args:
        back: The pick of the item from where it is put down.
        ways: Tool motions of that pick, planned without the arm.
        T_over: (4, 4) pose of the tool in the world at the start of the line.
        q: (n,) configuration there.

    Returns:
        The motion that picks the item up again, to be reversed; or every reason for failure.
    """
    lines = _Lines.of(back, ways, back.context.cell.robot.tool.contact_speed)
    down = lines.down(T_over, q)
    if isinstance(down, Failures):
        return down
    inward = _first(ways.inward, lines.inward, down.end)
    if isinstance(inward, Failures):
        return inward
    return GraspMotion(ways.grasp, lines.attached, inward, (down.backwards(SegmentKind.LIFT),))


def arm_seeds(problem: PickProblem, rng: np.random.Generator) -> Array:
    """Return where inverse kinematics begins: in front of the place, also moved along the rails; at random.

    Args:
        problem: The pick. It may want those alone that the cell names.
        rng: Source of the random ones.

    Returns:
        (K, n) configurations.
    """
    arm, fronts = problem.context.arm, problem.context.configurations_at(problem.place)
    if not fronts:  # then all are random
        return arm.random_seeds(rng, N_SEEDS)
    if problem.by_named:
        return np.array(fronts)
    elsewhere = arm.along_rails(fronts[0], N_ALONG)
    return np.vstack([fronts, elsewhere, arm.random_seeds(rng, N_SEEDS - 1 - len(elsewhere))])


@dataclass(frozen=True, eq=False)
class _Line:
    """A straight line for the tool to follow: segment kind, mode, end poses and speed."""

    kind: SegmentKind
    mode: Mode
    T_a: Array  # (4, 4) in the world
    T_b: Array  # (4, 4)
    speed: float  # m/s at the tip


@dataclass(frozen=True, eq=False)
class _Lines:
    """Follows the lines of one grasp, each in its mode.

    Attributes:
        context: Context with the checkers that prove them.
        scene: The planning scene.
        contact: (4, 4) pose of the tool in the world at the grasp.
        where: Name of the grasp in reasons.
        attached: The target, attached to the tool.
        modes: Modes of the segments, with the target attached once it is held.
        contact_speed: m/s at which the tool may meet the target.
        settings: Speeds of the lines.
    """

    context: PlanningContext
    scene: Scene
    contact: Array
    where: str
    attached: AttachedItem
    modes: GraspModes
    contact_speed: float
    settings: PickSettings

    @classmethod
    def of(cls, problem: PickProblem, ways: ToolLines, contact_speed: float) -> _Lines:
        context, scene, target = problem.context, problem.scene, problem.target
        # The held item stays where the cup met it: the bellows take up the overtravel.
        T_tip_item = inverse(ways.contact) @ target.T_world_item
        attached = AttachedItem(target.item, T_tip_item, problem.uncertainty, target.id)
        modes = ways.modes.holding(attached)
        return cls(
            context, scene, ways.contact, str(ways.grasp), attached, modes, contact_speed, problem.settings
        )

    @property
    def closes(self) -> bool:
        """Whether the tool closes on the target at rest."""
        return self.context.method.closes_at_rest

    def checker(self, mode: Mode) -> SceneChecker:
        """Return the checker of lines in one mode."""
        return self.context.checker_for(self.scene, mode)

    def inward(self, poses: PickPoses, q_contact: Array) -> tuple[MotionSegment, ...] | Failures:
        """Follow contact, approach and pre-approach backwards from the contact configuration."""
        settings, kind, modes = self.settings, SegmentKind, self.modes
        contact_speed = SLOWER_THAN_ALLOWED * self.contact_speed
        approach, preapproach = settings.approach_speed, settings.preapproach_speed
        if self.closes:
            approach = min(approach, contact_speed)
        lines = (
            _Line(kind.CONTACT, modes.taking, poses.contact, poses.touch, contact_speed),
            _Line(kind.APPROACH, modes.approaching, poses.touch, poses.approach, approach),
            _Line(kind.PREAPPROACH, modes.approaching, poses.approach, poses.preapproach, preapproach),
        )
        found = self._followed(lines[self.closes :], q_contact)
        if isinstance(found, Failures):
            return found
        inward = tuple(segment.backwards(segment.kind) for segment in reversed(found))
        return (*inward, at_rest(kind.CONTACT, q_contact, modes.taking)) if self.closes else inward

    def outward(self, poses: LiftPoses, q_contact: Array) -> tuple[MotionSegment, ...] | Failures:
        """Follow lift and retreat with the target, free of all contact after the first stretch."""
        settings, kind, modes = self.settings, SegmentKind, self.modes
        first = _Line(kind.LIFT, modes.lifting, self.contact, poses.first_stretch, settings.lift_speed)
        freeing = self._followed((first,), q_contact)
        if isinstance(freeing, Failures):
            return freeing
        if not poses.retreat and np.array_equal(poses.lift, poses.first_stretch):  # it is put down from here
            return freeing
        q, carrying = freeing[-1].end, self.checker(modes.carrying)
        if not carrying.is_valid(q):
            return _invalid(carrying, q, f"{self.where}, lift")
        lift = _Line(kind.LIFT, modes.carrying, poses.first_stretch, poses.lift, settings.lift_speed)
        lines = (
            _Line(kind.RETREAT, modes.carrying, here, there, settings.retreat_speed)
            for here, there in pairwise((poses.lift, *poses.retreat))
        )
        rest = self._followed((lift, *lines), q)
        return rest if isinstance(rest, Failures) else (*freeing, *rest)

    def down(self, T_over: Array, q: Array) -> MotionSegment | Failures:
        """Follow the line from a pose (4, 4) of the tool, with q (n,) there, to the end of the item."""
        line = _Line(SegmentKind.PLACE, self.modes.lifting, T_over, self.contact, self.settings.lift_speed)
        found = self._followed((line,), q)
        return found if isinstance(found, Failures) else found[0]

    def _followed(self, lines: Iterable[_Line], q: Array) -> tuple[MotionSegment, ...] | Failures:
        """Follow lines one after the other, from a configuration (n,) at the start of the first."""
        found: list[MotionSegment] = []
        arm = self.context.arm
        for line in lines:
            checker, where = self.checker(line.mode), f"{self.where}, {line.kind}"
            waypoints = follow_line(arm, checker, line.T_a, line.T_b, line.mode.tool_state, q, where)
            if isinstance(waypoints, Failures):
                return waypoints
            limits = SegmentLimits(max_tool_speed=line.speed)
            found.append(MotionSegment(line.kind, waypoints, limits, mode=line.mode))
            q = waypoints[-1]
        return tuple(found)


def _first(
    options: Iterable[_Poses],
    follow: Callable[[_Poses, Array], tuple[MotionSegment, ...] | Failures],
    q: Array,
) -> tuple[MotionSegment, ...] | Failures:
    """Return the segments of the first of several ways that the arm can follow from a configuration (n,)."""
    failures = Failures()
    for poses in options:
        segments = follow(poses, q)
        if not isinstance(segments, Failures):
            return segments
        failures += segments
    return failures


def _invalid(checker: SceneChecker, q: Array, where: str) -> Failures:
    """Explain why a configuration (n,) is not valid; evaluated lazily."""
    return Failures((lambda: [checker.explain(q).at(where)],))


def _place(T: Array) -> str:
    x, y, z = T[:3, 3]
    return f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
