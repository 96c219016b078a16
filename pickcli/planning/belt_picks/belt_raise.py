"""Lines of a grasp on a belt, lengthened upwards to where nothing that the belt may bring touches the arm.

Where they begin and end the arm may stand as long as it likes, whatever the belt does: there it waits for the
belt, and there its ways off the belt end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cartesian.line import line, shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_motion import GraspMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.scene.scene import Scene

ROOM = 2e-3  # m more than coarse motions keep, so that their last edge can be proven as well
HIGHEST = 0.4  # m that lines are lengthened at most: the highest item with one of the highest in the cup
STEP = 0.02  # m between heights that are tried


def raised_over_belt(
    problem: PickProblem, motion: GraspMotion, coming: Scene, leaving: Scene
) -> GraspMotion | Failures:
    """Lengthen the lines of a grasp to where the arm may stand whatever the belt brings.

    Args:
        problem: The pick from the belt.
        motion: The lines.
        coming: The scene with all that the items on the belt may come to from the start of the motion on.
        leaving: The same from when the item is off the belt.

    Returns:
        The lines, lengthened where needed, or the reasons for failure.
    """
    settings, first, last = problem.settings, motion.inward[0], motion.outward[-1]
    to_item, from_item = _checkers(problem, motion, coming, leaving)
    down = _up_from(problem, motion.start, first.mode, to_item)
    if isinstance(down, Failures):
        return down.within(str(motion.grasp))
    up = _up_from(problem, motion.end, last.mode, from_item)
    if isinstance(up, Failures):
        return up.within(str(motion.grasp))
    inward, outward = motion.inward, motion.outward
    if len(down) > 1:
        limits = SegmentLimits(max_tool_speed=settings.preapproach_speed)
        inward = (MotionSegment(SegmentKind.PREAPPROACH, down[::-1].copy(), limits, mode=first.mode), *inward)
    if len(up) > 1:
        limits = SegmentLimits(max_tool_speed=settings.retreat_speed)
        outward = (*outward, MotionSegment(SegmentKind.RETREAT, up, limits, mode=last.mode))
    return replace(motion, inward=inward, outward=outward)


def higher_item(problem: PickProblem, motion: GraspMotion, coming: Scene, leaving: Scene) -> str:
    """Return an item on the belt over which the lines of a grasp have to lead.

    Args:
        problem: The pick from the belt.
        motion: The lines, not lengthened.
        coming: The scene with all that the items on the belt may come to from the start of the motion on.
        leaving: The same from when the item is off the belt.

    Returns:
        Its id; "" if there is none.
    """
    ends = zip((motion.start, motion.end), _checkers(problem, motion, coming, leaving), strict=True)
    blocked = (each.explain(q) for q, checkers in ends for each in checkers if not each.is_valid(q))
    return next((reason.in_the_way for reason in blocked if reason.in_the_way), "")


def _checkers(
    problem: PickProblem, motion: GraspMotion, coming: Scene, leaving: Scene
) -> tuple[list[SceneChecker], list[SceneChecker]]:
    """Return what has to be free where lines begin, and where they end."""
    first, last = motion.inward[0], motion.outward[-1]
    empty = Mode(first.mode.tool_state, reserve=COARSE_RESERVE + ROOM)
    contacts = problem.contacts.while_transferring()
    held = Mode(last.mode.tool_state, motion.attached, contacts, COARSE_RESERVE + ROOM)
    # Without the item, too: if it was not held, it rides on under the tool.
    unladen = replace(empty, tool_state=last.mode.tool_state)
    context = problem.context
    to_item = [context.checker_for(coming, empty)]
    return to_item, [context.checker_for(leaving, mode) for mode in (held, unladen)]


def _up_from(problem: PickProblem, q: Array, mode: Mode, free: Sequence[SceneChecker]) -> Array | Failures:
    """Return the waypoints (N, n) from a configuration (n,) straight up to the first that all find free.

    mode: in which the line itself is proven, among the items where they are
    """
    if all(checker.is_valid(q) for checker in free):
        return q[None]
    arm, state = problem.context.arm, mode.tool_state
    tip, up = arm.tip(q, state), -problem.T_world_entry[:3, 0]
    poses = line(tip, shifted(tip, HIGHEST * up), STEP)
    followed = arm.follow(poses[1:], state, q)
    higher = followed.configurations
    is_free = np.ones(len(higher), dtype=bool)
    for checker in free if len(higher) else ():
        is_free &= checker.are_valid(higher)
    if not is_free.any():
        highest = higher[-1] if len(higher) else q
        blocked = next((each for each in free if not each.is_valid(highest)), free[0])
        low = blocked.explain(highest)
        why = f"{len(higher) * STEP:.2f} m up, no farther is reached or tried: {low}"
        what = "not clear of what the belt brings"
        return Failures.of(Reason(what, "way off the belt", why, low.in_the_way))
    end = poses[1 + int(np.argmax(is_free))]
    checker = problem.context.checker_for(problem.scene, mode)
    return follow_line(arm, checker, tip, end, state, q, "way off the belt")
