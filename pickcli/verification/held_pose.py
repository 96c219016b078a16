"""Pose of the held item in the tool frame."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import positions_at


def pose_in_tool(plan: Plan, scene: Scene) -> Array | None:
    """Compute the pose of the held item in the tool frame.

    An item that is picked in this plan does not move until the lift: the bellows take up the press. An item
    that is held from the start has the pose that the scene states.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        (4, 4); None for a plan without a grasp.
    """
    if plan.grasp is None:
        return None
    contact = next((s for s in plan.segments if s.kind is SegmentKind.CONTACT), None)
    if contact is None:
        return None if scene.held is None else scene.held.T_tip_item
    robot = scene.cell.robot
    q = positions_at(plan.trajectory, contact.t_end)
    T_world_tip = tip_poses(robot, link_poses(robot, q), contact.tool_state)[0]
    return np.asarray(inverse(T_world_tip) @ scene.find(plan.grasp.item).T_world_item)
