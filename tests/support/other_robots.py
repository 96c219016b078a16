"""A robot as others write it: meshes, a branch with a mimic joint, a tool in its own file, SRDF, limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from pickcli.cell.data_path import data_path
from pickcli.geometry import Array

URDF = """<robot name="branching">
<link name="world_link"/>
<link name="column"><collision><geometry><mesh filename="package://maker/meshes/column.obj"/></geometry></collision></link>
<link name="upper"><collision><origin xyz="0 0 0.2"/><geometry><mesh filename="package://maker/meshes/arm.obj" scale="0.001 0.001 0.001"/></geometry></collision></link>
<link name="camera"><collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
<link name="lower"><inertial><mass value="0"/></inertial><collision><origin xyz="0 0 0.2"/><geometry><mesh filename="package://maker/meshes/arm.obj" scale="0.001 0.001 0.001"/></geometry></collision></link>
<link name="hand"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
<link name="left"><collision><geometry><box size="0.01 0.01 0.05"/></geometry></collision></link>
<link name="right"><collision><geometry><box size="0.01 0.01 0.05"/></geometry></collision></link>
<link name="dummy"/>
<link name="flange"/>
<joint name="world_joint" type="fixed"><parent link="world_link"/><child link="column"/></joint>
<joint name="turn" type="continuous"><parent link="column"/><child link="upper"/><origin xyz="0 0 0.3"/><axis xyz="0 0 1"/></joint>
<joint name="pan" type="revolute"><parent link="upper"/><child link="camera"/><origin xyz="0.12 0 0.3"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
<joint name="bend" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0.15 0.4"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
<joint name="hand_joint" type="fixed"><parent link="lower"/><child link="hand"/><origin xyz="0.1 0 0.4"/></joint>
<joint name="open" type="prismatic"><parent link="hand"/><child link="left"/><origin xyz="0 0 0.05"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04"/></joint>
<joint name="follow" type="prismatic"><parent link="hand"/><child link="right"/><origin xyz="0 0 0.05"/><axis xyz="0 1 0"/><limit lower="-0.04" upper="0"/><mimic joint="open" multiplier="-1" offset="-0.001"/></joint>
<joint name="dummy_joint" type="fixed"><parent link="hand"/><child link="dummy"/></joint>
<joint name="flange_joint" type="revolute"><parent link="lower"/><child link="flange"/><origin xyz="0 0 0.42"/><axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
</robot>
"""  # noqa: E501
TOOL = """<robot name="tool">
<link name="mount"><collision><origin xyz="0 0 0.05"/><geometry><cylinder radius="0.015" length="0.1"/></geometry></collision></link>
<link name="cup"><collision><origin xyz="0 0 0.02"/><geometry><cylinder radius="0.015" length="0.04"/></geometry></collision></link>
<joint name="cup_joint" type="fixed"><parent link="mount"/><child link="cup"/><origin xyz="0 0 0.1"/></joint>
</robot>
"""  # noqa: E501
SRDF = """<robot name="branching">
<group name="arm"><chain base_link="column" tip_link="flange"/></group>
<group_state name="up" group="arm">
<joint name="turn" value="0"/><joint name="bend" value="0.1"/>
</group_state>
<group_state name="of_no_group"><joint name="turn" value="1"/></group_state>
<end_effector name="fingers" group="gripper" parent_link="hand"/>
<disable_collisions link1="lower" link2="camera" reason="Never"/>
<disable_collisions link1="lower" link2="no_link_of_this_robot" reason="Never"/>
</robot>
"""
JOINTS = ("turn", "bend", "flange_joint")
LIMIT = {
    "has_velocity_limits": True,
    "max_velocity": 1.5,
    "has_acceleration_limits": True,
    "max_acceleration": 5.0,
    "has_jerk_limits": True,
    "max_jerk": 50.0,
}


def write_robot(folder: Path) -> Path:
    """A cell of the branching robot.

    Args:
        folder: Where to write it: ``cell`` gets the cell, ``maker`` the package with its meshes.

    Returns:
        The cell's folder.
    """
    cell, meshes = folder / "cell", folder / "maker" / "meshes"
    cell.mkdir()
    meshes.mkdir(parents=True)
    (meshes / "column.obj").write_text(_prism(0.08, 0.0, 0.25))
    (meshes / "arm.obj").write_text(_prism(60.0, -150.0, 150.0))
    for name, text in {"robot.urdf": URDF, "tool.urdf": TOOL, "robot.srdf": SRDF}.items():
        (cell / name).write_text(text)
    limits = {joint: dict(LIMIT) for joint in JOINTS}
    (cell / "joint_limits.yaml").write_text(yaml.safe_dump({"joint_limits": limits}))
    (cell / "cell.yaml").write_text(yaml.safe_dump(content(), sort_keys=False))
    return cell


def content() -> dict[str, object]:
    """The cell file: the default cell's shelf and tote, and the branching robot before them."""
    default: dict[str, Any] = yaml.safe_load((data_path() / "cells/apc2016_delft/cell.yaml").read_text())
    tool = {key: value for key, value in default["tool"].items() if key not in ("joint", "states")}
    return default | {
        "name": "branching",
        "robot": {
            "urdf": "robot.urdf",
            "srdf": "robot.srdf",
            "packages": {"maker": "../maker"},
            "T_world_base": {"xyz": [-1.2, 0.2, 1.0], "rpy": [0.0, 0.0, 0.0]},
            "joints": list(JOINTS),
            "posture": {"pan": 0.3, "open": 0.02},
            "motor_forces": dict.fromkeys(JOINTS, 50.0),
            "joint_limits": "joint_limits.yaml",
        },
        "joint_limits": {"turn": {"max_velocity": 1.0}},
        "tool": tool
        | {
            "urdf": "tool.urdf",
            "T_flange_tool": {"xyz": [0.0, 0.0, 0.01], "rpy": [0.0, 0.0, 0.0]},
            "flange_link": "flange",
            "lance_link": "mount",
            "cup_link": "cup",
            "cup_length": 0.04,
        },
        "obstacles": [{"name": "stand", "lower": [-1.3, 0.1, 0.0], "upper": [-1.1, 0.3, 0.9]}],
        "devices": {
            "pump": {"kind": "pump", "lead": 2.0, "actions": ["on", "off"]},
            "valve": {"kind": "valve", "lead": 0.05, "actions": ["on", "off"]},
        },
        "sensors": {},
        "allowed_pairs": [],
        "configurations": [
            {"name": "home", "kind": "home", "q": [0.0, 0.3, 0.0]},
            {"name": "away", "kind": "midway", "q": [2.5, -0.6, 1.0]},
        ],
    }


def _prism(radius: float, low: float, high: float) -> str:
    """An eight-sided prism about z as OBJ."""
    angles = 2 * np.pi * np.arange(8) / 8
    ring = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    corners: Array = np.vstack([np.column_stack([ring, np.full(8, z)]) for z in (low, high)])
    sides = [(k, (k + 1) % 8, 8 + (k + 1) % 8, 8 + k) for k in range(8)]
    faces = [tuple(range(7, -1, -1)), tuple(range(8, 16)), *sides]
    lines = ["v {} {} {}".format(*corner) for corner in corners]
    return "\n".join(lines + ["f " + " ".join(str(i + 1) for i in face) for face in faces]) + "\n"
