"""Options for creating a cell, and the names of the files in its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pickcli.robot_setup.suggested_places import SuggestedPlace

URDF, SRDF, LIMITS, CELL = "robot.urdf", "robot.srdf", "joint_limits.yaml", "cell.yaml"


@dataclass(frozen=True)
class StatedLimit:
    """A limit stated by the user.

    Attributes:
        kind: "velocity", "acceleration", "jerk" or "effort".
        joint: Name of the joint; None for every planned joint without one.
        value: rad or m per s, s2 or s3; for an effort N or Nm.
    """

    kind: str
    joint: str | None
    value: float


@dataclass(frozen=True)
class SetupOptions:
    """Options for creating a cell.

    Attributes:
        urdf: A URDF or xacro file.
        srdf: An SRDF file, if there is one.
        group: Name of the SRDF group to be planned.
        tip: Name of the last link of the planned chain.
        without: Names of links to remove, with everything attached to them.
        package_path: Folders to search for packages first.
        packages: Folders of packages by name.
        arguments: Arguments of a xacro, by name.
        joint_limits: A ROS ``joint_limits.yaml``.
        figures: Limits that override those of the files.
        accepts_unshaped: Whether links without a collision shape may remain without collision checks.
        tool: Kind of the tool, "suction" or "gripper"; None without a tool.
        tool_figures: Stated figures of the tool, by the keys of a cell file.
        places: Places for items.
        seed: Seed of all samples.
    """

    urdf: Path
    srdf: Path | None = None
    group: str | None = None
    tip: str | None = None
    without: Sequence[str] = ()
    package_path: Sequence[Path] = ()
    packages: Mapping[str, Path] = field(default_factory=dict)
    arguments: Mapping[str, str] = field(default_factory=dict)
    joint_limits: Path | None = None
    figures: Sequence[StatedLimit] = ()
    accepts_unshaped: bool = False
    tool: str | None = None
    tool_figures: Mapping[str, float] = field(default_factory=dict)
    places: Sequence[SuggestedPlace] = ()
    seed: int = 0
