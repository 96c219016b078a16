"""Reachability from a given base pose, by inverse kinematics and the collision checker.

The ranking of base poses uses it for one base pose after the other, the search for a place for one pose of
the place after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Joint, JointType, Robot
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.kinematics.arm import Arm

TURNS = np.arange(4) * (np.pi / 2)  # rad about the tip's own axis, equivalent for a round cup
ROUNDS = 4  # of starting points: the next is only tried if the last led to solutions in collision


@dataclass(eq=False)
class ToolReachability:
    """Reachability from one base pose. Each pose that is reached is the starting point for the next.

    Attributes:
        arm: The robot at that base pose.
        checker: Checker of the cell with the robot there.
        tool_state: State of the tool.
        seeds: (K, n) starting points of inverse kinematics, different for each turn about the tip's axis,
            because such a turn may move only the last joint.
        center: (3,) m, centre of a ball that contains the tip at all times.
        radius: m.
        last: (1, n) the last configuration that reached a pose; (0, n) before the first.
    """

    arm: Arm
    checker: SceneChecker
    tool_state: ToolState
    seeds: Array
    center: Array
    radius: float
    last: Array

    def has(self, T_world_tip: Array) -> bool:
        """Whether the tip reaches a pose, up to quarter turns about its own axis, without a collision.

        Args:
            T_world_tip: (4, 4).

        Returns:
            True if it does.
        """
        if np.linalg.norm(T_world_tip[:3, 3] - self.center) > self.radius:
            return False  # inverse kinematics takes longest without a solution
        for seeds in np.split(self.seeds, ROUNDS):
            solutions = self._solutions(T_world_tip, seeds)
            for q in solutions:
                if self.checker.is_valid(q):
                    self.last = q[None]
                    return True
            if not len(solutions):
                return False  # more starting points are only useful if some led to solutions in collision
        return False

    def _solutions(self, T_world_tip: Array, seeds: Array) -> Array:
        """Return (M, n) configurations with the tip at a pose, turned about its own axis."""
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
    """Return a ball that the tip never leaves.

    Args:
        robot: The robot.

    Returns:
        Its centre (3,) in the world, at the first moving joint, and its radius in m.
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
    """Return the joints from the root to the tip, without those of branches."""
    by_child, way = {joint.child: joint for joint in robot.joints}, list[Joint]()
    link = robot.tool.last_link
    while link in by_child:
        way.insert(0, by_child[link])
        link = way[0].parent
    return way
