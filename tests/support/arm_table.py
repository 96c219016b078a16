"""The arm once more, as a table and ten lines of numpy: the oracle for the URDF and its reader.

Origins and axes from motoman_sia20d_support, the rail from Team Delft's description; q in the order rail,
s, l, e, u, r, b, t. Returns the pose of the tip of the cup in the world.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.geometry import Array, pose, rotation_axis_angle

ORIGIN_AND_AXIS = (
    ((0.0, 0.0, 0.41), (0, 0, 1)),
    ((0.0, 0.0, 0.0), (0, 1, 0)),
    ((0.0, 0.0, 0.49), (0, 0, 1)),
    ((0.0, 0.0, 0.0), (0, -1, 0)),
    ((0.0, 0.0, 0.42), (0, 0, -1)),
    ((0.0, 0.0, 0.0), (0, -1, 0)),
    ((0.0, 0.0, 0.18), (0, 0, -1)),
)


def tip(q: Sequence[float] | Array, tool_state: float) -> Array:
    """Pose (4, 4) of the cup's tip for a configuration (8,) and the cup's angle in rad."""
    T = pose((-1.758 + q[0], 0.0, 0.85))
    for (origin, axis), angle in zip(ORIGIN_AND_AXIS, q[1:], strict=True):
        T = T @ pose(origin, R=rotation_axis_angle(axis, float(angle)))
    return T @ pose((0, 0, 0.51), R=rotation_axis_angle((0, 1, 0), tool_state)) @ pose((0, 0, 0.03))


def chain_tip(robot, q: Sequence[float] | Array, tool_state: float) -> Array:  # type: ignore[no-untyped-def]
    """The same from a loaded robot: walks its joints as the URDF format defines them."""
    values = {**dict(zip(robot.joint_names, q, strict=True)), robot.tool.joint: tool_state}
    T = robot.T_world_base
    for joint in robot.joints:
        T = T @ joint.T_parent_joint
        if joint.type == "prismatic":
            T = T @ pose(joint.axis * values[joint.name])
        elif joint.type != "fixed":
            T = T @ pose(R=rotation_axis_angle(joint.axis, values[joint.name]))
    return np.asarray(T @ robot.tool.T_last_tip)
