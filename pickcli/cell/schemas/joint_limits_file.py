"""Reads ROS's joint_limits.yaml files, whose limits complete those stated in a cell file."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from typing import Any

from pickcli.cell.checks.references import refer
from pickcli.files.file_kind import JOINT_LIMITS
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import suggestion

ROOT = "joint_limits"
_FIGURES = {  # figures used by a cell, by the switch without which ROS ignores them
    "has_position_limits": ("min_position", "max_position"),
    "has_velocity_limits": ("max_velocity",),
    "has_acceleration_limits": ("max_acceleration",),
    "has_jerk_limits": ("max_jerk",),
}
_OTHERS = (  # further keys of ROS and MoveIt
    "angle_wraparound", "has_deceleration_limits", "max_deceleration", "has_effort_limits", "max_effort",
    "has_soft_limits", "k_position", "k_velocity", "soft_lower_limit", "soft_upper_limit",
)  # fmt: skip
_KEYS = (*_FIGURES, *(figure for figures in _FIGURES.values() for figure in figures), *_OTHERS)


def read_joint_limits(path: Path) -> Source:
    """Read a ``joint_limits.yaml``, and refuse mistakes that ROS would ignore silently.

    Args:
        path: The file.

    Returns:
        The values: an object for each joint, under ``joint_limits``.

    Raises:
        InputError: With every mistake and its position: a key that ROS does not know, a figure that is not
            switched on, a limit without its figure.
    """
    source = read_yaml(path, JOINT_LIMITS)
    stated = source.data.get(ROOT) if isinstance(source.data, dict) else None
    if not isinstance(stated, dict):
        source.add((), "expected joint_limits with an entry by joint, as ROS has it")
        source.check()
    for joint, entry in (stated or {}).items():
        if isinstance(entry, dict):
            _check_entry(source, joint, entry)
        else:
            source.add((ROOT, joint), "expected an object {...} with the joint's limits; correct it")
    source.check()
    return source


def refuse_unknown_joints(limits: Source, joints: Collection[str]) -> None:
    """Refuse a file of limits that names joints which the robot does not have.

    Args:
        limits: The file.
        joints: Names of all joints of the robot, planned or not.

    Raises:
        InputError: With every such name and its position.
    """
    for name in limits.data[ROOT]:
        refer(limits, (ROOT, name), "joint", name, list(joints))
    limits.check()


def stated_limits(limits: Source, joint: str) -> dict[str, Any]:
    """Return the limits that a file states for a joint.

    Limits that the file switches off (``has_jerk_limits: false``), as MoveIt does for unknown limits, are
    left out.

    Args:
        limits: The file.
        joint: Name of the joint.

    Returns:
        Values by key, as in a cell file.
    """
    entry, found = limits.data[ROOT].get(joint, {}), dict[str, Any]()
    for switch, figures in _FIGURES.items():
        if entry.get(switch) is True:
            found |= {key: entry[key] for key in (switch, *figures) if key in entry}
    found.pop("has_position_limits", None)  # a cell has no such switch
    return found


def add_joint_limits(cell: Source) -> Source | None:
    """Add the limits of the file that a cell names to the cell file, whose own values take precedence.

    Limits that neither file states are not assumed; the validation of the cell reports them.

    Args:
        cell: The cell file; receives the limits of its planned joints, with their positions in the file.

    Returns:
        The file; None if the cell names none.

    Raises:
        InputError: The file cannot be read, has mistakes, or is outside the cell's folder.
    """
    robot = cell.data.get("robot") if isinstance(cell.data, dict) else None
    name = robot.get(ROOT) if isinstance(robot, dict) else None
    joints = _planned(cell.data) if isinstance(name, str) else []
    if not isinstance(name, str) or "\0" in name or not joints:
        return None  # none is named, or validation of the cell reports the mistake
    folder = cell.path.parent
    if not (folder / name).resolve().is_relative_to(folder.resolve()):
        cell.add(("robot", ROOT), f"expected a path inside the cell's folder, got {name!r}")
        cell.check()
    limits = read_joint_limits(folder / name)
    own = cell.data.setdefault(ROOT, {})
    for joint in (joint for joint in joints if isinstance(joint, str) and isinstance(own, dict)):
        found = stated_limits(limits, joint)
        mine = own.setdefault(joint, {}) if found else None
        if isinstance(mine, dict):
            for key in found.keys() - mine.keys():
                mine[key] = found[key]
                _, line, column = limits.place((ROOT, joint, key))
                cell.origins[ROOT, joint, key] = limits.path, line, column
    return limits


def _planned(cell: dict[str, Any]) -> list[Any]:
    """Values given as planned joints in a cell file, of the robot or of each arm."""
    arms = cell.get("arms")
    owners = [cell["robot"], *(arms.values() if isinstance(arms, dict) else ())]
    stated = [owner.get("joints") for owner in owners if isinstance(owner, dict)]
    return [joint for joints in stated if isinstance(joints, list) for joint in joints]


def _check_entry(limits: Source, joint: str, entry: dict[str, Any]) -> None:
    """Report mistakes in the limits of a joint."""
    for key in entry.keys() - set(_KEYS):
        limits.add((ROOT, joint, key), f"unknown key; {suggestion(key, _KEYS)}")
    for switch, figures in _FIGURES.items():
        given = [figure for figure in figures if figure in entry]
        if switch not in entry:
            for figure in given:
                text = f"ROS ignores it without {switch}; add {switch}: true, or leave it out"
                limits.add((ROOT, joint, figure), text)
        elif not isinstance(entry[switch], bool):
            limits.add((ROOT, joint, switch), "expected true or false; correct it")
        elif entry[switch] and not given:
            limits.add(
                (ROOT, joint, switch), f"is true without {' or '.join(figures)}; add it, or write false"
            )
