"""Check that a held item stays as upright as its plan states."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.robot import Robot
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import motion, variation

STEP = 2e-3  # s between samples; knots of the trajectory are among them


def check_upright(plan: Plan, robot: Robot) -> Iterator[Reason]:
    """Check the tilt at every instant, against the orientation in which the item was taken.

    The angle between two directions changes by no more than the tool turns, and that by no more than the
    joints travel together, which the control polygons of the quintics bound.

    Args:
        plan: The plan; one without a bound of the tilt has no faults.
        robot: The robot.

    Yields:
        Faults.
    """
    if plan.upright is None:
        return
    upright = None  # of the tool's axes, the one that points up when the item is taken
    for k, segment in enumerate(plan.segments):
        if segment.held is None:
            continue
        where = f"segment {k} ({segment.kind})"
        if segment.tool_state == MOVING:
            yield Reason("tilts the item", where, "the tool changes its state with it")
            continue
        knots = plan.trajectory.times
        knots = knots[(knots > segment.t_start) & (knots < segment.t_end)]
        steps = np.arange(segment.t_start, segment.t_end, STEP)
        times = np.unique(np.concatenate([steps, knots, [segment.t_end]]))
        p, v, a = motion(plan.trajectory, times)
        up = tip_poses(robot, link_poses(robot, p), segment.tool_state)[:, 2, :3]  # the vertical, in its axes
        upright = up[0] if upright is None else upright
        tilt = 2.0 * np.arcsin(np.clip(np.linalg.norm(up - upright, axis=1) / 2.0, 0.0, 1.0))
        turned = variation(p, v, a, times).sum(axis=1) if len(times) > 1 else np.zeros(0)
        most = float(max(tilt.max(), ((tilt[:-1] + tilt[1:] + turned) / 2.0).max(initial=0.0)))
        if not most <= plan.upright:
            detail = (
                f"by up to {np.degrees(most):.2f} degrees, the plan allows {np.degrees(plan.upright):.2f}"
            )
            yield Reason("tilts the item", where, detail)
    if all(segment.held is None for segment in plan.segments):
        yield Reason("nothing is held", "upright", "the plan states how far it tilts an item, and holds none")
