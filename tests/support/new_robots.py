"""Robots as somebody has them on disk: a folder with URDF, SRDF and meshes, no cell yet."""

from __future__ import annotations

from pathlib import Path

from support.other_robots import SRDF, URDF, write_robot

TWO_ARMS = """<robot name="two_arms">
<link name="trunk"/>
{arms}
</robot>
"""
ARM = """<link name="{side}_upper"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.05 0.05 0.3"/></geometry></collision></link>
<link name="{side}_lower"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.05 0.05 0.3"/></geometry></collision></link>
<link name="{side}_tool0"/>
<joint name="{side}_shoulder" type="revolute"><parent link="trunk"/><child link="{side}_upper"/><origin xyz="0 {y} 0.3"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="1.5"/></joint>
<joint name="{side}_elbow" type="revolute"><parent link="{side}_upper"/><child link="{side}_lower"/><origin xyz="0 0 0.4"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="20" velocity="1.5"/></joint>
<joint name="{side}_mount" type="fixed"><parent link="{side}_lower"/><child link="{side}_tool0"/><origin xyz="0 0 0.4"/></joint>
"""  # noqa: E501


def write_branching(folder: Path) -> Path:
    """The branching robot in the package ``maker``, with its SRDF and a file of limits.

    Args:
        folder: Where to write it.

    Returns:
        Its URDF, beside ``robot.srdf`` and ``joint_limits.yaml``, in ``maker/urdf``.
    """
    cell = write_robot(folder)
    urdf = folder / "maker" / "urdf" / "robot.urdf"
    urdf.parent.mkdir()
    urdf.write_text(URDF)
    urdf.with_name("robot.srdf").write_text(SRDF)
    urdf.with_name("joint_limits.yaml").write_text((cell / "joint_limits.yaml").read_text())
    return urdf


def write_two_arms(folder: Path) -> Path:
    """A robot with two arms of two joints each, of boxes.

    Args:
        folder: Where to write it.

    Returns:
        Its URDF.
    """
    urdf = folder / "two_arms.urdf"
    arms = (ARM.format(side="left", y="0.3"), ARM.format(side="right", y="-0.3"))
    urdf.write_text(TWO_ARMS.format(arms="".join(arms)))
    return urdf
