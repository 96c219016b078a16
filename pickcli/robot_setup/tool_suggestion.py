"""Suggests the tool of a new cell from the robot's URDF: a plain suction cup, or the robot's own gripper."""

from __future__ import annotations

from functools import reduce
from math import ceil, floor

import numpy as np

from pickcli.cell.robots.urdf import Urdf
from pickcli.errors import InputError
from pickcli.files.yaml_reader import quoted
from pickcli.geometry import Array, pose, rotation_rpy, to_rpy
from pickcli.robot_setup.chain_selection import PlannedChain, rigid_with
from pickcli.robot_setup.suggested_gripper import find_gripper
from pickcli.robot_setup.suggested_tool import SUCTION, TOOL_URDF, SuggestedTool, ToolFigure, tool_kind

_TUBE, _CUP_LENGTH, _CUP_RADIUS = 0.2, 0.03, 0.015  # m
_IN_LINE = 0.98  # least cosine between z of the flange and the last joint's axis if they count as aligned
_FINE = 1e4  # widths are rounded to 0.1 mm, inwards

_CUP_URDF = """\
<?xml version="1.0"?>
<!-- A plain suction cup on a tube, written by `apc init`: a stand-in for yours. Its frames' z points out of the cup. -->
<robot name="suction_tool">
  <link name="{tube}">
    <inertial><origin xyz="0 0 0.08"/><mass value="0.4"/></inertial>
    <collision name="mount"><origin xyz="0 0 0.015"/><geometry><cylinder radius="0.032" length="0.03"/></geometry></collision>
    <collision name="tube"><origin xyz="0 0 {half}"/><geometry><cylinder radius="0.0125" length="{length}"/></geometry></collision>
  </link>
  <link name="{cup}">
    <inertial><origin xyz="0 0 0.015"/><mass value="0.03"/></inertial>
    <collision name="bellows"><origin xyz="0 0 {cup_half}"/><geometry><cylinder radius="{cup_radius}" length="{cup_length}"/></geometry></collision>
  </link>
  <joint name="{tube}_to_{cup}" type="fixed">
    <parent link="{tube}"/><child link="{cup}"/><origin xyz="0 0 {length}"/>
  </joint>
</robot>
"""  # noqa: E501


def suggest_tool(kind: str, robot: Urdf, chain: PlannedChain) -> SuggestedTool:
    """Suggest a tool of a kind.

    Args:
        kind: "suction" or "gripper".
        robot: The robot.
        chain: The planned chain.

    Returns:
        The tool.

    Raises:
        InputError: There is no such kind, or no gripper in the URDF; with advice.
    """
    return _suction(robot, chain) if tool_kind(kind) == SUCTION else _gripper(robot, chain)


def _suction(robot: Urdf, chain: PlannedChain) -> SuggestedTool:
    taken = {*robot.links, *(joint.name for joint in robot.joints.values())}
    tube, cup = (_free_name(name, taken) for name in ("suction_tube", "suction_cup"))
    names = {"{tube}": tube, "{cup}": cup, "{length}": str(_TUBE), "{half}": str(_TUBE / 2)}
    drawing = reduce(lambda text, name: text.replace(name, names[name]), names, _CUP_URDF)
    R, how = _out_of_flange(robot, chain)
    ends = rigid_with(robot, chain.joints[-1])
    fingers = [name for link in ends for name in robot.driven(robot.children(link))]
    note = f"{', '.join(fingers)} stay beside the cup; if that hand is taken off, add --without with its link"
    measured = "measure yours"
    return SuggestedTool(
        head=(
            "A plain suction cup of 30 mm on a tube, the figures of a common one at 60 kPa of vacuum. They",
            "are not those of yours: measure each, and draw its shape in tool.urdf.",
        ),
        flange=chain.tip,
        links=(
            "kind: suction",
            f"urdf: {TOOL_URDF}",
            f"T_flange_tool: {_pose_text(pose(R=R))}  # its z out of the cup: {how}",
            f"flange_link: {quoted(chain.tip)}",
            f"lance_link: {tube}",
            f"cup_link: {cup}",
        ),
        figures=(
            ToolFigure("cup_length", _CUP_LENGTH, "m, uncompressed; as in tool.urdf"),
            ToolFigure("cup_radius", _CUP_RADIUS, "m; as in tool.urdf"),
            ToolFigure("cup_stroke", 0.008, f"m that the bellows compress; {measured}"),
            ToolFigure("cup_tilt", 0.12, f"rad off square at which the lip still seals; {measured}"),
            ToolFigure("max_pull", 42.0, f"N along the axis at full vacuum; {measured}"),
            ToolFigure("max_shear", 21.0, f"N across it, at a friction of 0.5; {measured}"),
            ToolFigure("max_moment", 0.6, f"Nm of bending; {measured}"),
            ToolFigure("seal_time", 0.25, f"s at rest until the vacuum stands; {measured}"),
            ToolFigure("contact_speed", 0.075, "m/s, fastest final approach; yours to choose"),
        ),
        joints=(),
        travel=0.0,
        drawing=drawing,
        note=note if fingers else "",
    )  # fmt: skip


def _gripper(robot: Urdf, chain: PlannedChain) -> SuggestedTool:
    found = find_gripper(robot, rigid_with(robot, chain.joints[-1]))
    least, most = ceil(_FINE * found.widths[0] - 1e-6) / _FINE, floor(_FINE * found.widths[1] + 1e-6) / _FINE
    if least >= most:
        raise InputError(
            f"--tool gripper: the limits of {' and '.join(found.joints)} leave the pads no way to open (from "
            f"{least:g} to {most:g} m between them); correct them in the URDF"
        )
    sides = ", ".join(f"{floor(_FINE * side) / _FINE:g}" for side in found.pad_size)
    fingers = ", ".join(map(quoted, found.fingers))
    return SuggestedTool(
        head=("The gripper that the URDF has. What that does not say is blank.",),
        flange=found.flange,
        links=(
            "kind: gripper",
            f"flange_link: {quoted(found.flange)}",
            f"hand_link: {quoted(found.hand)}",
            f"T_hand_tip: {_pose_text(found.T_hand_tip)}  # between the pads, z out, y as they close",
            f"fingers: [{fingers}]",
            f"states: {{open: {most:g}, closed: {least:g}}}  # m between the pads, by their joints",
            f"pad_size: [{sides}]  # m along x and z: flat ends of the fingers, which face each other",
            f"pad_gap: {found.pad_gap:g}  # m between the pads where both joints stand at 0",
        ),
        figures=(
            ToolFigure("force", None, "N with which each pad presses: its manual says"),
            ToolFigure("friction", None, "of pads on items: measure it (docs/how-to/my-gripper.md)"),
            ToolFigure("closing_speed", None, "m/s of the width, twice a finger's: its manual says"),
            ToolFigure("contact_speed", 0.1, "m/s, fastest final approach; yours to choose"),
        ),
        joints=found.joints,
        travel=round(most - least, 4),
        drawing=None,
    )  # fmt: skip


def _free_name(name: str, taken: set[str]) -> str:
    """The name, numbered if the robot already uses it."""
    return next(n for n in (name, *(f"{name}_{k}" for k in range(2, len(taken) + 3))) if n not in taken)


def _pose_text(T: Array) -> str:
    xyz, rpy = (
        ", ".join(f"{value + 0.0:.4f}" for value in values.round(4))
        for values in (T[:3, 3], to_rpy(T[:3, :3]))
    )
    return f"{{xyz: [{xyz}], rpy: [{rpy}]}}"


def _out_of_flange(robot: Urdf, chain: PlannedChain) -> tuple[Array, str]:
    """Orientation (3, 3) in the tip of a frame with z away from the wrist, and how it was found.

    Usually z of a flange points outwards along the last joint's axis. Otherwise that axis is used, in the
    direction from the joint to the tip.
    """
    way = robot.way(chain.tip)
    k = next(i for i, joint in enumerate(way) if joint.name == chain.joints[-1])
    R, offset = np.eye(3), np.zeros(3)
    for joint in reversed(way[k + 1 :]):
        offset = joint.T_parent_joint[:3, 3] + joint.T_parent_joint[:3, :3] @ offset
        R = joint.T_parent_joint[:3, :3] @ R
    axis = R.T @ way[k].axis
    if abs(axis[2]) >= _IN_LINE:
        return np.eye(3), "along the flange's own, the axis of the last joint"
    sign = -1.0 if axis @ (R.T @ offset) < 0.0 else 1.0
    return _turned_to(sign * axis), "along the last joint's axis, away from the wrist"


def _turned_to(z: Array) -> Array:
    """Smallest rotation (3, 3) that turns (0, 0, 1) into a direction."""
    pitch, yaw = float(np.arctan2(np.hypot(z[0], z[1]), z[2])), float(np.arctan2(z[1], z[0]))
    turn = rotation_rpy(0.0, 0.0, yaw)
    return np.asarray(turn @ rotation_rpy(0.0, pitch, 0.0) @ turn.T)
