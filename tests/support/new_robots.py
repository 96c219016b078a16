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
GRIPPER_ARM = """<robot name="gripper_arm">
<link name="stand"><collision><origin xyz="0 0 0.1"/><geometry><box size="0.1 0.1 0.2"/></geometry></collision></link>
<link name="upper"><collision><origin xyz="0 0 0.22"/><geometry><box size="0.05 0.05 0.32"/></geometry></collision></link>
<link name="lower"><collision><origin xyz="0 0 0.2"/><geometry><box size="0.05 0.05 0.3"/></geometry></collision></link>
<link name="wrist"><collision><geometry><box size="0.05 0.05 0.05"/></geometry></collision></link>
<link name="tool0"/>
<link name="hand"><collision><origin xyz="0.03 0 0"/><geometry><box size="0.06 0.05 0.15"/></geometry></collision></link>
<link name="one"><collision><origin xyz="0.04 0 {out}"/><geometry><box size="0.08 {pad} 0.012"/></geometry></collision></link>
<link name="other"><collision><origin xyz="0.04 0 -{out}"/><geometry><box size="0.08 {pad} 0.012"/></geometry></collision></link>
<joint name="pan" type="revolute"><parent link="stand"/><child link="upper"/><origin xyz="0 0 0.25"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="50" velocity="1.5"/></joint>
<joint name="lift" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 0.45"/><axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" effort="20" velocity="1.5"/></joint>
<joint name="bend" type="revolute"><parent link="lower"/><child link="wrist"/><origin xyz="0 0 0.42"/><axis xyz="0 1 0"/><limit lower="-2.5" upper="2.5" effort="20" velocity="1.5"/></joint>
<joint name="mount" type="fixed"><parent link="wrist"/><child link="tool0"/><origin xyz="0 0 0.03"/></joint>
<joint name="hand_mount" type="fixed"><parent link="tool0"/><child link="hand"/><origin xyz="0 0 0" rpy="0 -1.5707963267948966 0"/></joint>
<joint name="slide_one" type="{type}"><parent link="hand"/><child link="one"/><origin xyz="0.06 0 0"/><axis xyz="0 0 1"/><limit lower="0" upper="0.04" effort="20" velocity="0.1"/></joint>
<joint name="slide_other" type="{type}"><parent link="hand"/><child link="other"/><origin xyz="0.06 0 0"/><axis xyz="{axis}"/><limit lower="0" upper="0.04" effort="20" velocity="0.1"/><mimic joint="slide_one"/></joint>
</robot>
"""  # noqa: E501


def write_gripper_arm(
    folder: Path,
    out: float = 0.008,
    kind: str = "prismatic",
    axis: str = "0 0 -1",
    pad: str = "0.02",
) -> Path:
    """An arm of three joints and a hand that lies on its side: fingers along its x, which close along z.

    Args:
        folder: Where to write it.
        out: m from the middle to each finger's where its joint stands at 0; they are 12 mm thick.
        kind: Of the fingers' joints.
        axis: Of the second finger's joint.
        pad: m, the fingers' width.

    Returns:
        Its URDF.
    """
    urdf = folder / "gripper_arm.urdf"
    urdf.write_text(GRIPPER_ARM.format(out=out, type=kind, axis=axis, pad=pad))
    return urdf


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
