"""Builds the tool of an arm from a cell file."""

from __future__ import annotations

import numpy as np

from pickcli.cell.checks.gripper_consistency import finger_joint, finger_sign, opening_sign
from pickcli.cell.robot import joint_motion
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.schemas.tool_schema import GripperModel, SuctionModel
from pickcli.cell.tool import FIXED, Tool, ToolState
from pickcli.cell.tools.cup_limits import CupLimits, twist_of
from pickcli.cell.tools.gripper import Finger, ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.geometry import Array, inverse, pose


def build_tool(tool: SuctionModel | GripperModel | None, tip: str, robot: Urdf, flow: float) -> Tool:
    """Build the tool of an arm.

    Args:
        tool: The tool as it stands in the cell file; None without a tool.
        tip: Name of the chain's last link, used as the tip without a tool.
        robot: The robot with the tool.
        flow: l/min of free air that the pump of a cup draws.

    Returns:
        The tool.
    """
    if tool is None:
        return Tool.bare(tip)
    if isinstance(tool, GripperModel):
        return _gripper_tool(tool, robot)
    positions = {ToolState(name): angle for name, angle in (tool.states or {FIXED.name: 0.0}).items()}
    T_last_tip = pose((0.0, 0.0, tool.cup_length))
    return Tool(
        flange_link=tool.flange_link,
        lance_link=tool.lance_link,
        last_link=tool.last_link,
        joint=tool.joint,
        positions=positions,
        T_lance_tip={s: _T_lance_last(tool, robot, angle) @ T_last_tip for s, angle in positions.items()},
        T_last_tip=T_last_tip,
        grip=_cup(tool, flow),
    )


def _gripper_tool(tool: GripperModel, robot: Urdf) -> Tool:
    """Build a gripper, whose tool frame is the last link of the chain, independent of the width."""
    states = {ToolState(name): width for name, width in tool.states.items()}
    along, deep = tool.pad_size
    return Tool(
        flange_link=tool.flange_link,
        lance_link=tool.lance_link,
        last_link=tool.last_link,
        joint=None,
        positions=states,
        T_lance_tip=dict.fromkeys(states, np.eye(4)),
        T_last_tip=np.eye(4),
        grip=ParallelGripper(
            fingers=(_finger(tool, robot, 0), _finger(tool, robot, 1)),
            pad=(along, deep),
            gap=tool.pad_gap,
            limits=PinchLimits(tool.force, tool.friction, (along, deep)),
            closing_speed=tool.closing_speed,
            contact_speed=tool.contact_speed,
        ),
    )


def _finger(tool: GripperModel, robot: Urdf, k: int) -> Finger:
    link = tool.fingers[k]
    side, opening = finger_sign(tool, robot, link), opening_sign(tool, robot, link)
    return Finger(link, finger_joint(robot, link).name, side, opening)


def _cup(tool: SuctionModel, flow: float) -> SuctionCup:
    return SuctionCup(
        radius=tool.cup_radius,
        stroke=tool.cup_stroke,
        stiffness=tool.cup_stiffness,
        tilt=tool.cup_tilt,
        limits=CupLimits(
            max_pull=tool.max_pull,
            max_shear=tool.max_shear,
            max_moment=tool.max_moment,
            max_twist=twist_of(tool.max_shear, tool.cup_radius) if tool.max_twist is None else tool.max_twist,
        ),
        contact_speed=tool.contact_speed,
        take_up=tool.take_up,
        take_up_speed=tool.take_up_speed,
        seal_time=tool.seal_time,
        flow=flow,
    )


def _T_lance_last(tool: SuctionModel, robot: Urdf, position: float) -> Array:
    """Pose (4, 4) of the cup in the flange as the tool is mounted on it, at a joint position in rad or m."""
    fixed, last = robot.way(tool.last_link)[-2:]
    T_flange_tool = np.eye(4) if tool.T_flange_tool is None else tool.T_flange_tool.T
    T_flange_last = fixed.T_parent_joint @ last.T_parent_joint @ joint_motion(last, position)
    return np.asarray(inverse(T_flange_tool) @ T_flange_last)
