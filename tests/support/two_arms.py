"""A torso with two arms that can reach into each other's way, in a cell without places."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from support.other_robots import LIMIT

SIDES = {"left": 1, "right": -1}
JOINTS = ("yaw", "pitch", "elbow")

ARM = """<link name="{side}_shoulder"><collision><geometry><sphere radius="0.07"/></geometry></collision></link>
<link name="{side}_upper"><collision><origin xyz="0.2 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.05" length="0.3"/></geometry></collision></link>
<link name="{side}_lower"><collision><origin xyz="0.2 0 0" rpy="0 1.5707963 0"/><geometry><cylinder radius="0.04" length="0.36"/></geometry></collision></link>
<link name="{side}_hand"><collision><geometry><box size="0.04 0.06 0.06"/></geometry></collision></link>
<joint name="{side}_yaw" type="revolute"><parent link="torso"/><child link="{side}_shoulder"/><origin xyz="0.05 {y} 1.0"/><axis xyz="0 0 1"/><limit lower="-2" upper="2"/></joint>
<joint name="{side}_pitch" type="revolute"><parent link="{side}_shoulder"/><child link="{side}_upper"/><axis xyz="0 1 0"/><limit lower="-1.5" upper="1.5"/></joint>
<joint name="{side}_elbow" type="revolute"><parent link="{side}_upper"/><child link="{side}_lower"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/><limit lower="-2" upper="2"/></joint>
<joint name="{side}_hand_joint" type="fixed"><parent link="{side}_lower"/><child link="{side}_hand"/><origin xyz="0.42 0 0"/></joint>
"""  # noqa: E501
URDF = """<robot name="two_arms">
<link name="base"/>
<link name="torso"><collision><origin xyz="-0.1 0 0.6"/><geometry><box size="0.2 0.5 1.2"/></geometry></collision></link>
<link name="head"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="torso_joint" type="fixed"><parent link="base"/><child link="torso"/></joint>
<joint name="neck" type="revolute"><parent link="torso"/><child link="head"/><origin xyz="-0.1 0 1.35"/><axis xyz="0 0 1"/><limit lower="-1" upper="1"/></joint>
{arms}</robot>
"""  # noqa: E501


def write_two_arms(folder: Path) -> Path:
    """A cell of a torso with two arms.

    Args:
        folder: Where to write it.

    Returns:
        The cell's folder, which is new.
    """
    cell = folder / "two_arms"
    cell.mkdir()
    arms = "".join(ARM.format(side=side, y=0.32 * sign) for side, sign in SIDES.items())
    (cell / "robot.urdf").write_text(URDF.format(arms=arms))
    write_cell(cell, content())
    return cell


def write_cell(cell: Path, content: dict[str, Any]) -> None:
    """Write the cell file.

    Args:
        cell: The cell's folder.
        content: Of the file.
    """
    (cell / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))


def joints(side: str) -> list[str]:
    """Names of an arm's joints, base outwards.

    Args:
        side: Name of the arm.

    Returns:
        The names.
    """
    return [f"{side}_{joint}" for joint in JOINTS]


def content() -> dict[str, Any]:
    """The cell file: both arms, each with three configurations of the same names.

    In ``across`` an arm reaches in front of the torso, where the other one goes through from ``home`` to
    ``parked`` unless it goes round.
    """
    both = [joint for side in SIDES for joint in joints(side)]
    named = {"home": (0.3, 0.2, 0.4), "parked": (1.5, 1.0, 0.3), "across": (-1.0, 0.0, 0.0)}
    return {
        "format": "apc cell",
        "version": 2,
        "name": "two_arms",
        "robot": {
            "urdf": "robot.urdf",
            "T_world_base": {"xyz": [0.0, 0.0, 0.0], "rpy": [0.0, 0.0, 0.0]},
            "posture": {"neck": 0.1},
            "motor_forces": dict.fromkeys(both, 100.0),
        },
        "joint_limits": {joint: dict(LIMIT) for joint in both},
        "speed_scale": 1.0,
        "clearance": 0.005,
        "accepted_warnings": ["no_mass"],
        "arms": {
            side: {
                "joints": joints(side),
                "tip": f"{side}_hand",
                "parked": "parked",
                "preference": 1 if side == "left" else 2,
            }
            for side in SIDES
        },
        "obstacles": [],
        "devices": {},
        "allowed_pairs": [],
        "configurations": [
            {"name": name, "arm": side, "kind": "home" if name == "home" else "midway", "q": [sign * yaw, *q]}
            for side, sign in SIDES.items()
            for name, (yaw, *q) in named.items()
        ],
    }
