"""What the arm reaches from where its base stands: by inverse kinematics and the collision checker.

The ranking of base poses asks it of one base pose after the other, the search for a place of one pose of the
place after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.kinematics.arm import Arm

TURNS = np.arange(4) * (np.pi / 2)  # rad about the tip's own axis: a cup is round, any of these will do
ROUNDS = 4  # in which starting points are tried: the next only where the last led into something


@dataclass(eq=False)
class ToolReachability:
    """What one base pose reaches. Each pose that is reached begins the search for the next.

    Attributes:
        arm: The robot on that base pose.
        checker: Of the cell with the robot there.
        tool_state: State of the tool.
        seeds: (K, n) starting points of inverse kinematics, others for each turn about the tip's axis, as
            such a turn may move the last joint alone.
        center: (3,) m, middle of the ball that nothing of the robot leaves.
        radius: m.
        last: (1, n) the configuration that reached a pose last; (0, n) before the first.
    """

    arm: Arm
    checker: SceneChecker
    tool_state: ToolState
    seeds: Array
    center: Array
    radius: float
    last: Array

    def has(self, T_world_tip: Array) -> bool:
        """Whether the tip gets there, turned about its own axis by some quarter turns, with nothing hit.

        Args:
            T_world_tip: (4, 4).

        Returns:
            True if it does.
        """
        if np.linalg.norm(T_world_tip[:3, 3] - self.center) > self.radius:
            return False  # inverse kinematics takes longest where there is no solution
        for seeds in np.split(self.seeds, ROUNDS):
            solutions = self._solutions(T_world_tip, seeds)
            for q in solutions:
                if self.checker.is_valid(q):
                    self.last = q[None]
                    return True
            if not len(solutions):
                return False  # more starting points are worth their time where some led there, into something
        return False

    def _solutions(self, T_world_tip: Array, seeds: Array) -> Array:
        """(M, n) configurations that bring the tip there, turned about its own axis."""
        found = [
            self.arm.solve(
                T_world_tip @ pose(R=rotation_rpy(0.0, 0.0, turn)),
                self.tool_state,
                np.vstack([self.last, mine]),
            )
            for turn, mine in zip(TURNS, np.split(seeds, len(TURNS)), strict=True)
        ]
        return np.concatenate(found)


def reach_ball(robot: Robot) -> tuple[Array, float]:
    """A ball that the tip never leaves.

    Args:
        robot: The robot.

    Returns:
        Its middle (3,) in the world, where the first joint that moves is, and its radius in m.
    """
    T, radius, is_fixed = robot.T_world_base, float(np.linalg.norm(robot.tool.T_last_tip[:3, 3])), True
    for joint in _way_to_tip(robot):
        if is_fixed:
            T = T @ joint.T_parent_joint
        else:
            radius += float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
        is_fixed = is_fixed and joint.type is JointType.FIXED
        if joint.type is JointType.PRISMATIC:
            radius += max(abs(joint.lower), abs(joint.upper))
    return T[:3, 3], radius


def _way_to_tip(robot: Robot) -> list[Joint]:
    """The joints from the root to the tip, without those of branches."""
    by_child, way = {joint.child: joint for joint in robot.joints}, list[Joint]()
    link = robot.tool.last_link
    while link in by_child:
        way.insert(0, by_child[link])
        link = way[0].parent
    return way
