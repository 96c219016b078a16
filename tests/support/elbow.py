"""An arm of two links whose last joint moves the link at its end, with nothing fixed to it."""

from __future__ import annotations

from pathlib import Path

LIMITS = ("--max-acceleration", "5", "--max-jerk", "50", "--max-velocity", "1", "--motor-force", "10")
# The wall is parallel to the forearm where that moves its tip best, 30 mm from its surface.
WALL = '<collision><origin xyz="0.375 0 0"/><geometry><box size="0.05 1.2 0.2"/></geometry></collision>'
ELBOW = """<robot name="elbow">
<link name="base">{wall}</link>
<link name="upper"><collision><origin xyz="0.13 0 0"/><geometry><box size="0.2 0.04 0.04"/></geometry></collision></link>
<link name="fore"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.2 0.04 0.04"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
  <limit lower="-0.02" upper="0.02" velocity="1" effort="10"/></joint>
<joint name="bend" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.3 0 0"/>
  <axis xyz="0 0 1"/><limit lower="{lower}" upper="{upper}" velocity="1" effort="10"/></joint>
</robot>
"""  # noqa: E501


def write_elbow(folder: Path, lower: float = -2.9, upper: float = 2.9, wall: str = "") -> Path:
    """Write its URDF.

    Args:
        folder: Where to write it.
        lower: rad, limit of the last joint.
        upper: rad, the other.
        wall: Shapes of the base.

    Returns:
        The path.
    """
    path = folder / "elbow.urdf"
    path.write_text(ELBOW.format(lower=lower, upper=upper, wall=wall))
    return path
