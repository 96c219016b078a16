"""Task on the pose of the tool: inequalities such as planes, shells and cones, alone or as an envelope."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.control.hierarchical_qp import BoundedRows
from pickcli.control.tasks.task import ControlState, Task
from pickcli.geometry import inverse
from pickcli.kernel import pose_constraint_gradients, pose_constraint_values
from pickcli.kinematics.arm import Arm, ToolGoal

MET = 1e-4  # m or difference of cosines


@dataclass(frozen=True, eq=False)
class ToolTask(Task):
    """Meets inequalities e(T) <= 0 on where a frame of the tool is relative to an object.

    Attributes:
        name: Name of the task in its stack.
        arm: The arm.
        tool_state: State of the tool.
        goal: The inequalities.
        gain: 1/s.
        inside: m or difference of cosines that the rows aim beyond the bounds: what is approached
            exponentially would never be inside. Bounds of equal value leave no room for that: the task is
            met within ``MET``.
    """

    name: str
    arm: Arm
    tool_state: ToolState
    goal: ToolGoal
    gain: float
    inside: float = 1e-3

    def rows(self, state: ControlState) -> BoundedRows:
        """Return the rows, one for each inequality.

        Args:
            state: The robot now.

        Returns:
            (m, n) rows and their bounds, per s.
        """
        goal = self.goal
        chain, T_last_palm = self.arm.chain(self.tool_state), self.arm.robot.tool.T_last_tip @ goal.T_tip_palm
        T_object_palm = inverse(goal.T_world_object) @ chain.fk(state.q)[-1] @ T_last_palm
        values = pose_constraint_values(goal.constraints, T_object_palm[None])[0]
        gradients = pose_constraint_gradients(goal.constraints, T_object_palm)
        J, R = chain.jacobian(state.q, T_last_palm), goal.T_world_object[:3, :3]
        in_object = np.concatenate([R.T @ J[:3], R.T @ J[3:]])
        return BoundedRows.at_most(gradients @ in_object, -self.gain * (values + self.inside))

    def error(self, state: ControlState) -> float:
        """Return the largest excess over a bound, in m or as a difference of cosines.

        Args:
            state: The robot now.

        Returns:
            Its size, 0 where the task is met within ``MET``.
        """
        goal = self.goal
        T = inverse(goal.T_world_object) @ self.arm.tip(state.q, self.tool_state) @ goal.T_tip_palm
        excess = float(pose_constraint_values(goal.constraints, T[None]).max())
        return excess if excess > MET else 0.0
