"""ROS's joint_limits.yaml files: what they state is taken into a cell where the cell says nothing itself."""

from __future__ import annotations

from typing import Any

from pickcli.files.file_kind import JOINT_LIMITS
from pickcli.files.yaml_reader import Source, read_yaml

_LIMITS = ("velocity", "acceleration", "jerk")


def add_joint_limits(cell: Source) -> None:
    """Add the limits of the file that a cell names to those in the cell itself, which come first.

    A limit that the file switches off (``has_jerk_limits: false``), as MoveIt writes it where it knows none,
    is not stated. Nothing is assumed in its place: the cell is asked for it.

    Args:
        cell: The cell file; gets the limits of its planned joints.

    Raises:
        InputError: The file cannot be read or lies outside of the cell's folder.
    """
    robot = cell.data.get("robot") if isinstance(cell.data, dict) else None
    name = robot.get("joint_limits") if isinstance(robot, dict) else None
    joints = robot.get("joints") if isinstance(robot, dict) else None
    if not isinstance(name, str) or not isinstance(joints, list):
        return  # none is named, or what is wrong is told with all else
    folder = cell.path.parent
    if not (folder / name).resolve().is_relative_to(folder.resolve()):
        cell.add(("robot", "joint_limits"), f"expected a path inside the cell's folder, got {name!r}")
        cell.check()
    source = read_yaml(folder / name, JOINT_LIMITS)
    stated = source.data.get("joint_limits") if isinstance(source.data, dict) else None
    if not isinstance(stated, dict):
        source.add((), "expected joint_limits with an entry by joint, as ROS has it")
        source.check()
    own = cell.data.setdefault("joint_limits", {})
    for joint in joints:
        entry = stated.get(joint) if isinstance(stated, dict) else None
        if isinstance(entry, dict) and isinstance(own, dict):
            mine = own.setdefault(joint, {})
            if isinstance(mine, dict):
                mine.update({key: value for key, value in _stated(entry).items() if key not in mine})


def _stated(entry: dict[str, Any]) -> dict[str, Any]:
    """What an entry of the file limits."""
    found: dict[str, Any] = {}
    for limit in _LIMITS:
        if entry.get(f"has_{limit}_limits") is True:
            found[f"has_{limit}_limits"] = True
            found[f"max_{limit}"] = entry.get(f"max_{limit}")
    if entry.get("has_position_limits") is True:
        found |= {key: entry[key] for key in ("min_position", "max_position") if key in entry}
    return found
