"""Check that a held item stays as upright as its plan states, and its item file."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import motion, variation

STEP = 2e-3  # s between samples; knots of the trajectory are among them


def check_upright(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Check the tilt at every instant, against the orientation in which the item was taken.

    The angle between two directions changes by no more than the tool turns, and that by no more than the
    joints travel together, which the control polygons of the quintics bound.

    Args:
        plan: The plan; without a bound of the tilt, of its own or of the item, it has no faults. One of the
            item does not bind a recovery motion, which may start with the item tilted in any way.
        scene: The scene, with the item and the robot.

    Yields:
        Faults.
    """
    allowed = _allowed(plan, scene)
    if allowed is None:
        return
    robot = scene.cell.robot
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
        if not most <= allowed:
            detail = f"by up to {np.degrees(most):.2f} degrees, {np.degrees(allowed):.2f} are allowed"
            yield Reason("tilts the item", where, detail)
    if plan.upright is not None and all(segment.held is None for segment in plan.segments):
        yield Reason("nothing is held", "upright", "the plan states how far it tilts an item, and holds none")


def _allowed(plan: Plan, scene: Scene) -> float | None:
    """Angle (rad) that the held item may be tilted, by its plan and its item file; None for any."""
    bounds = [plan.upright]
    if plan.recovery is None:
        bounds += [scene.item(each.held).max_tilt for each in plan.segments if each.held is not None]
    return min((each for each in bounds if each is not None), default=None)
