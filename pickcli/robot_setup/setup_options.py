"""What a cell is to be made from, and the names of the files in its folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pickcli.robot_setup.suggested_places import SuggestedPlace

URDF, SRDF, LIMITS, CELL = "robot.urdf", "robot.srdf", "joint_limits.yaml", "cell.yaml"


@dataclass(frozen=True)
class StatedLimit:
    """A limit that the author of a cell states.

    Attributes:
        kind: "velocity", "acceleration", "jerk" or "effort".
        joint: Whose it is; None for every planned joint that has none.
        value: In rad or m per s, s2 or s3; of an effort N or Nm.
    """

    kind: str
    joint: str | None
    value: float


@dataclass(frozen=True)
class SetupOptions:
    """What a cell is to be made from.

    Attributes:
        urdf: A URDF or xacro file.
        srdf: An SRDF file, if there is one.
        group: Name of the SRDF group that is to be planned.
        tip: Name of the link at the end of what is to be planned.
        without: Names of links that are not there, with all that hangs on them.
        package_path: Folders in which packages are looked for first.
        packages: Folders of packages by name.
        arguments: Of a xacro, by name.
        joint_limits: A ROS ``joint_limits.yaml``.
        figures: Limits that are stated on top of these.
        accepts_unshaped: Whether links without a collision shape may stay untested.
        tool: Kind of the tool, "suction" or "gripper"; None where nothing is to be mounted.
        tool_figures: What is stated of it, by the keys of a cell file.
        places: What is to hold items.
        seed: Of all samples.
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
