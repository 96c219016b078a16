"""Ways with the item to its placement that keep it upright: the fastest one if it does, else a straight line.

On a line between two poses with the item upright, the tool turns about the vertical alone. The rest of the
bound is for the joints' chords and blends; ``assembly.tilt_bound`` proves the timed motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array
from pickcli.motion.segment import SegmentKind
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.assembly.tilt_bound import tilts
from pickcli.planning.coarse_path import COARSE_LIMITS
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion, Transfer
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.planning.stages.item_transfer import plan_direct_transfer

STEP = 0.02  # rad or m of the joint that moves most, between configurations that are looked at
WHERE = "upright transfer"


def plan_upright_transfer(
    problem: PickProblem, taking: GraspMotion, placements: Sequence[PlaceMotion]
) -> Transfer | Failures:
    """Find a transfer to one of several placements that keeps the item as upright as is asked.

    Args:
        problem: The pick, with a bound of the tilt.
        taking: The motion that takes the item.
        placements: Placements in the state of the tool in which it is taken.

    Returns:
        The transfer, or the reasons for failure.
    """
    arm, state, upright = problem.context.arm, taking.holding_state, problem.max_tilt
    assert upright is not None
    up = arm.tip(taking.inward[-1].waypoints[-1], taking.grasp.tool_state)[:3, :3].T @ (0.0, 0.0, 1.0)

    def tilt(waypoints: Array) -> float:
        return float(tilts(up, arm.tips(_dense(waypoints), state)[:, :3, :3]).max())

    level = [each for each in placements if tilt(np.stack([each.start])) <= upright]
    if not level:
        least = np.degrees(min(tilt(np.stack([each.start])) for each in placements))
        allowed = f"{least:.1f} degrees at least at the placements, {np.degrees(upright):.1f} are allowed"
        return Failures.of(Reason("tilts the item", str(taking.grasp), allowed))
    direct = plan_direct_transfer(problem, taking, level)
    if isinstance(direct, Failures):
        failures = direct
    elif (most := tilt(direct.segments[0].waypoints)) > upright:
        failures = Failures.of(_tilted(most, "the fastest way"))
    else:
        return direct
    space = problem.context.space
    for placement in sorted(
        level, key=lambda each: each.cost + estimated_duration(space, np.stack([taking.end, each.start]))
    ):
        way = _line(problem, taking, placement)
        if isinstance(way, Failures):
            failures += way
        elif (most := tilt(way.segments[0].waypoints)) > upright:
            failures += _tilted(most, "a straight line")
        else:
            return way
    return failures


def _tilted(most: float, way: str) -> Reason:
    return Reason("tilts the item", WHERE, f"by {np.degrees(most):.1f} degrees on {way}")


def _line(problem: PickProblem, taking: GraspMotion, placement: PlaceMotion) -> Transfer | Failures:
    """Lead the tool straight to a placement, and the joints from where they end to where they are to be."""
    context, state = problem.context, taking.holding_state
    mode = Mode(state, taking.attached, problem.contacts.while_transferring(), COARSE_RESERVE)
    checker = context.checker_for(problem.scene, mode)
    T_a, T_b = context.arm.tips(np.stack([taking.end, placement.start]), state)
    line = follow_line(context.arm, checker, T_a, T_b, state, taking.end, WHERE)
    if isinstance(line, Failures):
        return line
    waypoints = np.vstack([line, placement.start])
    if not checker.is_valid_path(waypoints[-2:]):
        return Failures.of(checker.explain_path(waypoints[-2:]).at(WHERE))
    segment = MotionSegment(SegmentKind.TRANSFER, waypoints, COARSE_LIMITS, mode=replace(mode, reserve=0.0))
    return Transfer((segment,), placement)


def _dense(waypoints: Array) -> Array:
    """Return configurations (M, n) along a polyline (N, n)."""
    parts = [waypoints[:1]]
    for a, b in pairwise(waypoints):
        n = max(1, int(np.ceil(np.abs(b - a).max() / STEP)))
        parts.append(a + (b - a) * np.arange(1, n + 1)[:, None] / n)
    return np.vstack(parts)
